#!/usr/bin/env bash
# Textures and relief of real meshes on others: pictures by `relievo render` from two sides in target/pictures/transfer, and
# all of them on one sheet, transfer_sheet.png, if Python has pillow. Needs ../shared/data.
#
#   scripts/transfer_sheet.sh [NAME…]     (default: all)
#
# VERTICES (65536), SIZE (420x360) and OPTIONS (further ones of `relievo transfer`) can be set in the environment.
set -euo pipefail
cd "$(dirname "$0")/.."
data=../shared/data
if [[ ! -d $data/transfer ]]; then
    echo "SKIPPED: $data/transfer is not there"
    exit 0
fi
vertices=${VERTICES:-65536} size=${SIZE:-420x360}
read -ra options <<<"${OPTIONS:-}"
out=target/pictures/transfer
mkdir -p "$out"
cargo build --locked --release
relievo=target/release/relievo

# A sphere as a grid of quads: x, y, z of each vertex, then the faces.
awk 'BEGIN {
    n = 60; m = 120; pi = 4 * atan2(1, 1)
    for (i = 0; i < n; i++) for (j = 0; j < m; j++) {
        p = pi * (i + 0.5) / n; b = 2 * pi * j / m
        printf "v %.9g %.9g %.9g\n", sin(p) * cos(b), cos(p), -sin(p) * sin(b)
    }
    for (i = 0; i + 1 < n; i++) for (j = 0; j < m; j++) {
        r = (j + 1) % m
        printf "f %d %d %d %d\n", i * m + j + 1, (i + 1) * m + j + 1, (i + 1) * m + r + 1, i * m + r + 1
    }
    printf "f"; for (j = 1; j <= m; j++) printf " %d", j; printf "\n"
    printf "f"; for (j = m; j >= 1; j--) printf " %d", (n - 1) * m + j; printf "\n"
}' >"$out/sphere.obj"
"$relievo" texture "$out/sphere.obj" --exemplar "$data/textures/cheetah.png" --vertices 40000 -o "$out/cheetah.ply" --quiet

names=()
# name source target axis-that-is-up-on-the-target-as-drawn two-sides options…
pair() {
    local name=$1 source=$2 target=$3 up=$4 views=$5 side=0
    shift 5
    if [[ -n ${only:-} && " $only " != *" $name "* ]]; then
        return
    fi
    "$relievo" transfer --source "$source" --target "$target" --vertices "$vertices" "$@" "${options[@]}" \
        -o "$out/$name.ply" --json "$out/$name.json" --overwrite --quiet
    for view in $views; do
        side=$((side + 1))
        "$relievo" render "$out/$name.ply" --channel "${channel:-color}" --up "$up" --view "$view" --size "$size" \
            --no-legend -o "$out/$name-$side.png" --quiet
    done
    names+=("$name")
    echo "$out/$name.ply: $(grep -o '"coherent_edges":[^,]*' "$out/$name.json" | head -1)"
}
only="$*"
animals=$data/transfer
# The horse of this file has its outside inside: turned round to be drawn.
"$relievo" convert "$animals/horse.ply" "$out/horse.obj" --overwrite --quiet
sed -i -E 's/^f ([^ ]+) ([^ ]+) ([^ ]+)/f \1 \3 \2/' "$out/horse.obj"
pair zebra-horse "$animals/zebra.obj" "$out/horse.obj" z "left right" --up z
pair zebra-cow "$animals/zebra.obj" "$animals/cow.obj" y "front back" --up y --source-up z
pair zebra-camel "$animals/zebra.obj" "$animals/camel.off" y "left right" --up y --source-up z
pair spot-cow "$animals/spot_rgb.ply" "$animals/cow.obj" y "front back"
pair cheetah-bunny "$out/cheetah.ply" "$data/holes/bun_zipper.ply" y "front back"
channel=shape
pair bunny-sphere "$data/holes/bun_zipper.ply" "$out/sphere.obj" y "front back" --channel height --shape none
pair limestone-scallop "$data/scans/limestone_V21_grid.ply" "$data/relief/scallop_shell_rgb.ply" y "front back" --channel height --shape none

python3 - "$out" "${names[@]}" <<'PYTHON' || echo "no sheet: python3 with pillow is not there"
import pathlib, sys
from PIL import Image, ImageDraw
out, names = pathlib.Path(sys.argv[1]), sys.argv[2:]
width, height = Image.open(out / f"{names[0]}-1.png").size
sheet = Image.new("RGB", (4 * width, height * ((len(names) + 1) // 2)), "white")
for i, name in enumerate(names):
    for k in range(2):
        picture = Image.open(out / f"{name}-{k + 1}.png").convert("RGB")
        sheet.paste(picture, ((2 * (i % 2) + k) * width, i // 2 * height))
    ImageDraw.Draw(sheet).text((2 * (i % 2) * width + 6, i // 2 * height + 4), name, fill="black")
sheet.save(out / "transfer_sheet.png")
print(out / "transfer_sheet.png")
PYTHON
