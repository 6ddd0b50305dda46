#!/usr/bin/env bash
# How often coherent search finds a match that costs at most 1.1 times as much as the best of all vertices
# and middles of edges at all rotations: by what continues the neighbors' sources alone, with what is
# similar to that, and with the best of all sites and the search around them. Further scans may be given.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --locked
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for kind in golf-ball bark bricks noise; do
    target/release/relievo synth "$kind" --vertices 12000 --hole 0.1 -o "$folder/$kind.ply" -q
done
for scan in "$folder"/{golf-ball,bark,bricks,noise}.ply "$@"; do
    target/release/relievo complete "$scan" -o "$folder/out.ply" --audit 0.15 --json "$folder/out.json" -q ||
        [ $? -eq 3 ]
    python3 - "$scan" "$folder/out.json" <<'P'
import json, os, sys
searched = json.load(open(sys.argv[2]))["searched"]
recall = searched["recall"]
print(f'{os.path.basename(sys.argv[1]):20} audited {recall["audited"]:5} against {recall["compared"]};',
      ', '.join(f'{name} {100 * recall[name]:.0f} %' for name in ("continuing", "coherent", "all")))
P
done
