#!/usr/bin/env bash
# Judges completion on many kinds of relief: a Markdown table of scenes and fills on standard output.
#
#   scripts/evaluate_scenes.sh [SCENE…] [smooth] [paper] [default]
#
# Without a scene all of them, without a fill smooth and default (paper takes a minute a hole).
# HOLE, REPEAT, SEED and VERTICES (of synthetic scenes) can be set in the environment.
set -euo pipefail
cd "$(dirname "$0")/.."
data=../shared/data
all_scenes=(waves noise golf-ball golf-ball-half bark column bricks limestone lato bunny scallop mountain)
scenes=() fills=()
for word in "$@"; do
    case $word in
        smooth | paper | default) fills+=("$word") ;;
        *)
            if [[ " ${all_scenes[*]} " != *" $word "* ]]; then
                echo "there is no scene $word; there are ${all_scenes[*]}" >&2
                exit 2
            fi
            scenes+=("$word")
            ;;
    esac
done
((${#scenes[@]})) || scenes=("${all_scenes[@]}")
((${#fills[@]})) || fills=(smooth default)
hole=${HOLE:-0.04} repeat=${REPEAT:-2} seed=${SEED:-0} vertices=${VERTICES:-12000}

cargo build --release --locked
relievo=target/release/relievo
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Sets $scan to the scene's file; fails if it is a real scan that is not there.
scan_of() {
    case $1 in
        limestone) scan=$data/scans/limestone_V21_grid.ply ;;
        lato) scan=$data/scans/lato000.ply ;;
        bunny) scan=$data/scans/bun000.ply ;;
        scallop) scan=$data/relief/scallop_shell_rgb.ply ;;
        mountain) scan=$data/relief/mountain.obj ;;
        golf-ball-half)
            scan=$folder/$1.ply
            "$relievo" synth golf-ball --view 0,0,1 --vertices "$vertices" -o "$scan" -q
            ;;
        *)
            scan=$folder/$1.ply
            "$relievo" synth "$1" --full --vertices "$vertices" -o "$scan" -q
            ;;
    esac
    [[ -e $scan ]]
}

echo "| scene | fill | Sq | Sdq | score | outside (worst score) | RMSE/Sq | mean integral, % | colour corr. | copied with neighbors | largest piece | s |"
echo "|---|---|---|---|---|---|---|---|---|---|---|---|"
for scene in "${scenes[@]}"; do
    if ! scan_of "$scene"; then
        echo "$scene is left out: there is no $scan" >&2
        continue
    fi
    for fill in "${fills[@]}"; do
        case $fill in
            smooth) options=(--fill smooth --window 1 --rotations 1 --sites 64) ;;
            paper) options=(--method paper) ;;
            default) options=() ;;
        esac
        rm -f "$folder/report.json"
        "$relievo" evaluate "$scan" --hole "$hole" --repeat "$repeat" --seed "$seed" "${options[@]}" \
            -q --json "$folder/report.json" > "$folder/text" 2> "$folder/errors" || true
        python3 scripts/evaluate_row.py "$scene" "$fill" "$folder/report.json"
    done
done
