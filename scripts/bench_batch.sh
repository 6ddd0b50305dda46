#!/usr/bin/env bash
# Many scans: two cores against one, and a batch that is killed in the middle and resumed.
#   scripts/bench_batch.sh [SCANS] [VERTICES]
# The bar: 200 scans of 25 000 vertices on two cores at least 1.8 times as fast as on one; after kill -9 and --resume the very
# bytes of an undisturbed run. RELIEVO names the program, WORK a folder for the scans [default: a new one].
set -euo pipefail
cd "$(dirname "$0")/.."
scans=${1:-200}
vertices=${2:-25000}
relievo=${RELIEVO:-target/release/relievo}
[ -x "$relievo" ] || cargo build --release --locked
work=${WORK:-$(mktemp -d)}
echo "in $work: $scans scans of $vertices vertices"
mkdir -p "$work/scans"
kinds=(golf-ball bricks waves noise)
for ((i = 0; i < scans; i++)); do
    scan=$work/scans/$(printf %04d "$i").ply
    [ -e "$scan" ] || "$relievo" synth "${kinds[i % 4]}" -o "$scan" --vertices "$vertices" --hole 0.01 --seed "$i" -q
done

# What a batch takes on these cores; waiting for the disk counts, too.
timed() { # cores, folder
    local begin end
    begin=$(date +%s.%N)
    taskset -c "$1" "$relievo" batch "$work/scans/*.ply" --out "$work/$2" --json "$work/$2.json" > "$work/$2.jsonl" 2> "$work/$2.log" || true
    end=$(date +%s.%N)
    echo "$end - $begin" | bc
}
same() { # folder, folder
    diff -rq --exclude=.relievo "$work/$1" "$work/$2" && echo "$2: the same bytes as $1"
}

rm -rf "$work"/{one,two,killed}
one=$(timed 0 one)
two=$(timed 0,1 two)
tail -1 "$work/two.log"
echo "one core $one s, two cores $two s: $(echo "scale=2; $one / $two" | bc) times as fast"
same one two

"$relievo" batch "$work/scans/*.ply" --out "$work/killed" > "$work/killed.jsonl" 2> "$work/killed.log" &
batch=$!
sleep "$(echo "$two / 2" | bc)"
kill -9 "$batch"
wait "$batch" 2> /dev/null || true
echo "killed after $(wc -l < "$work/killed.jsonl") scans"
"$relievo" batch "$work/scans/*.ply" --out "$work/killed" --resume > "$work/resumed.jsonl" 2> "$work/resumed.log" || true
tail -1 "$work/resumed.log"
same one killed
begin=$(date +%s.%N)
"$relievo" batch "$work/scans/*.ply" --out "$work/killed" --resume > /dev/null 2>&1 || true
echo "all skipped in $(echo "$(date +%s.%N) - $begin" | bc) s"
