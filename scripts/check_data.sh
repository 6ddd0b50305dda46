#!/usr/bin/env bash
# Runs `info` and `complete` over every scan of a folder: a Markdown table on standard output.
#
#   scripts/check_data.sh [FOLDER]        (default: ../shared/data; its scans, holes, relief and transfer)
#
# Ends with 1 if a run panicked, was killed by a signal, took longer than LIMIT seconds (default 200), or ended
# otherwise than with 0 (done), 3 (partly done) or 1 and one sentence that names the file.
# RELIEVO=PATH takes that program instead of building one.
set -uo pipefail
caller=$PWD
cd "$(dirname "$0")/.." || exit 2
[[ $# -eq 0 || $1 == /* ]] || set -- "$caller/$1"
data=${1:-../shared/data} limit=${LIMIT:-200}
if [[ ! -d $data ]]; then
    echo "skipped: there is no folder $data" >&2
    exit 0
fi
if [[ -z ${RELIEVO:-} ]]; then
    cargo build --release --locked || exit 2
    RELIEVO=target/release/relievo
elif [[ $RELIEVO == */* && $RELIEVO != /* ]]; then
    RELIEVO=$caller/$RELIEVO
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
bad=0

# Prints a figure of a JSON report, or a dash: figure REPORT KEY…
figure() {
    python3 - "$@" <<'PYTHON'
import json, sys
try:
    value = json.load(open(sys.argv[1], encoding="utf-8"))
    for key in sys.argv[2:]:
        value = value[key]
    print(value)
except (OSError, ValueError, KeyError, TypeError):
    print("-")
PYTHON
}

# Runs a command of relievo; sets $code and $said, and $fault if it ended as no run may: run FILE REPORT COMMAND…
run() {
    local file=$1 report=$2
    shift 2
    rm -f "$report"
    timeout --kill-after=5 "$limit" "$RELIEVO" "$@" "$file" --json "$report" >"$folder/stdout" 2>"$folder/stderr"
    code=$? fault=
    said=$(grep 'relievo: error: ' "$folder/stderr" | sed "s|^relievo: error: ||; s|$file|FILE|g")
    if grep -q 'panicked at' "$folder/stderr"; then
        fault="panicked: $(grep -m1 -A1 'panicked at' "$folder/stderr" | tr '\n' ' ')"
    elif ((code == 124 || code == 137)); then
        fault="no end after $limit s"
    elif ((code > 128)); then
        fault="killed by signal $((code - 128))"
    elif ((code == 1)) && [[ $(wc -l <<<"$said") -ne 1 || $said != *FILE* ]]; then
        fault="exit code 1 without one sentence that names the file: $said"
    elif ((code != 0 && code != 1 && code != 3)); then
        fault="exit code $code: $said"
    elif [[ ! -s $report ]]; then
        fault="exit code $code without a JSON report"
    fi
    [[ -z $fault ]] || bad=$((bad + 1))
}

echo "| file | format | vertices | faces | holes | complete | s |"
echo "|---|---|--:|--:|--:|---|--:|"
found=0
shopt -s nullglob
for file in "$data"/{scans,holes,relief,transfer}/*; do
    case ${file,,} in
        *.ply | *.obj | *.stl | *.off | *.glb | *.gltf | *.xyz | *.pts | *.txt | *.csv | *.ptx | *.pcd | *.e57 | *.las | *.laz) ;;
        *) continue ;; # textures and materials
    esac
    found=$((found + 1))
    run "$file" "$folder/info.json" info
    format=${file##*.}
    told="${format^^} | $(figure "$folder/info.json" vertices) | $(figure "$folder/info.json" faces) | $(figure "$folder/info.json" holes)"
    [[ -z $fault ]] || told="INFO FAILED: $fault | | |"

    start=$(date +%s.%N)
    run "$file" "$folder/complete.json" complete -o "$folder/out.ply"
    seconds=$(awk -v a="$start" -v b="$(date +%s.%N)" 'BEGIN { printf "%.1f", b - a }')
    summary=$(grep -m1 ' gap(s) filled ' "$folder/stderr" | sed 's/^relievo: //')
    case $code in
        0) outcome="done: $summary" ;;
        3) outcome="partly: $summary; first left: $(grep -m1 'left open:' "$folder/stderr" | sed 's/.*left open: //')" ;;
        *) outcome="refused: $said" ;;
    esac
    if [[ -n $fault ]]; then
        outcome="FAILED: $fault"
    elif ((code == 1)) && [[ -e $folder/out.ply ]]; then
        outcome="FAILED: refused, but wrote the output" bad=$((bad + 1))
    elif ((code != 1)) && ! "$RELIEVO" info -q "$folder/out.ply" >/dev/null 2>&1; then
        outcome="FAILED: its output cannot be read" bad=$((bad + 1))
    fi
    rm -f "$folder/out.ply"
    echo "| ${file#"$data"/} | $told | ${outcome//|/\\|} | $seconds |"
done
if ((found == 0)); then
    echo "there are no scans in scans, holes, relief and transfer of $data" >&2
    exit 1
fi
if ((bad)); then
    echo "$bad run(s) went wrong" >&2
    exit 1
fi
