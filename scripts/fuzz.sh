#!/usr/bin/env bash
# Fuzzes the readers and the pipeline: scripts/fuzz.sh SECONDS [TARGET...]
# Needs cargo-fuzz (cargo install cargo-fuzz). New inputs are kept in tests/fuzz/corpus, which is not committed; what
# breaks something is left in tests/fuzz/artifacts: put it into tests/crashes/TARGET and mend it.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:?how many seconds for each target?}
shift
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
    mapfile -t targets < <(cargo fuzz list --fuzz-dir tests/fuzz)
fi
# The sanitizers' flags are unstable ones.
export RUSTC_BOOTSTRAP=1
for target in "${targets[@]}"; do
    mkdir -p "tests/fuzz/corpus/$target" "tests/samples/$target" "tests/crashes/$target"
    echo "== $target"
    cargo fuzz run --fuzz-dir tests/fuzz "$target" "tests/fuzz/corpus/$target" "tests/samples/$target" "tests/crashes/$target" -- \
        -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 -max_len=65536 -print_final_stats=1 2>&1 |
        grep -E "stat::|SUMMARY|ERROR|panicked|Test unit|artifact" || true
done
