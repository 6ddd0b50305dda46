#!/usr/bin/env bash
# All checks: format, lints, tests, docs. Ends non-zero at the first that fails.
# Lints run apart for the crate and for its tests: development dependencies turn features on.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo fmt --check
cargo clippy --locked --lib --bins -- -D warnings
cargo clippy --locked --all-targets -- -D warnings
# Lints link nothing, and need no Python.
PYO3_NO_PYTHON=1 PYO3_BUILD_EXTENSION_MODULE=1 cargo clippy --locked --lib --features python -- -D warnings
scripts/test
RUSTDOCFLAGS='-D warnings' cargo doc --locked --no-deps --lib
