#!/usr/bin/env bash
# Half a golf ball of 12 000 vertices, completed to a whole one: the time of the command, and original
# against completed part. Further arguments go to `complete`.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --locked
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
target/release/relievo synth golf-ball --vertices 12000 --view 0,0,1 -o "$folder/half.ply"
time target/release/relievo complete "$folder/half.ply" -o "$folder/whole.ply" --extend -v "$@"
target/release/relievo stats "$folder/whole.ply"
target/release/relievo holes "$folder/whole.ply"
