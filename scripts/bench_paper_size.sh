#!/usr/bin/env bash
# A completion of the size of the paper's Fig. 9: about 7200 targets, 12852 samples, 4 rotations,
# window 5, in the paper's metric. Half a golf ball of 3213 vertices, subdivided to 12.7 k samples; the other half is filled
# at the spacing that gives that many targets.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --locked
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
target/release/relievo synth golf-ball --vertices 6440 --view 0,0,1 -o "$folder/half.ply"
time target/release/relievo complete "$folder/half.ply" -o "$folder/whole.ply" --extend \
    --spacing 0.675 --method paper -v "$@"
target/release/relievo stats "$folder/whole.ply"
