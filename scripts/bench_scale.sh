#!/usr/bin/env bash
# Whole commands by coherent search: half a golf ball of 25 000 vertices, and waves on a plane with a tenth
# missing, from 25 000 to a million vertices. Wall-clock seconds, peak memory in kB, seconds of growth for
# each new vertex. The kind of relief may be given, as in `bench_scale.sh bricks`.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --locked
kind=${1:-noise}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
run() {
    local name=$1
    shift
    echo "== $name"
    /usr/bin/env time -f '%e s, %M kB' target/release/relievo complete "$@" -o "$folder/out.ply" \
        --json "$folder/out.json" -q
    python3 - "$folder/out.json" <<'P'
import json, sys
report = json.load(open(sys.argv[1]))
stages = {stage["stage"]: stage["seconds"] for stage in report["seconds"]}
count = report["counts"]["completed_vertices"]
print(f'{count} new vertices, {stages["growth"]:.2f} s growth, {1e6 * stages["growth"] / count:.0f} us each;',
      ', '.join(f'{name} {seconds:.2f}' for name, seconds in stages.items()))
P
}
target/release/relievo synth golf-ball --vertices 25000 --view 0,0,1 -o "$folder/scan.ply" -q
run 'half a golf ball of 25 000' "$folder/scan.ply" --extend
for count in 25000 250000 1000000; do
    target/release/relievo synth "$kind" --vertices "$count" --hole 0.1 -o "$folder/scan.ply" -q
    run "$kind, $count" "$folder/scan.ply"
done
