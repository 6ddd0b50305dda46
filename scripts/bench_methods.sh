#!/usr/bin/env bash
# The size of the paper's Fig. 9 (see bench_paper_size.sh) by exhaustive and by coherent search: seconds of
# the stages `samples` and `growth`, with one thread and with two.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --locked
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
target/release/relievo synth golf-ball --vertices 6440 --view 0,0,1 -o "$folder/half.ply"
for method in exhaustive coherent; do
    for threads in 1 2; do
        echo "$method, $threads thread(s)"
        target/release/relievo complete "$folder/half.ply" -o "$folder/whole.ply" --extend \
            --spacing 0.675 --method "$method" --threads "$threads" -v 2>&1 | grep -E 'samples:|growth:|filled'
    done
    target/release/relievo stats "$folder/whole.ply"
done
