#!/usr/bin/env bash
# Sample images on a sphere, a torus and, where ../shared/data is there, the bunny and spot: pictures by `relievo render`
# in target/pictures/texture, and all of them on one sheet, texture_sheet.png, if Python has pillow.
#
#   scripts/texture_sheet.sh [IMAGE…]     (default: those of `cargo bench --bench texture -- prepare`)
#
# VERTICES (60000), SIZE (360x360) and OPTIONS (further ones of `relievo texture`) can be set in the environment.
set -euo pipefail
cd "$(dirname "$0")/.."
vertices=${VERTICES:-60000} size=${SIZE:-360x360}
read -ra options <<<"${OPTIONS:-}"
out=target/pictures/texture
mkdir -p "$out"
cargo build --locked --release
relievo=target/release/relievo

images=("$@")
if ((${#images[@]} == 0)); then
    cargo bench --locked --bench texture -- prepare
    for image in target/texture-synthesis/samples/*.png; do
        [[ -e $image ]] && images+=("$image")
    done
fi
if ((${#images[@]} == 0)); then
    echo "SKIPPED: there are no images"
    exit 0
fi

# A torus and a sphere as grids of quads: x, y, z of each vertex, then the faces.
grid() { # rows columns expression-of-x expression-of-y expression-of-z
    awk -v n="$1" -v m="$2" "BEGIN {
        tau = 8 * atan2(1, 1)
        for (i = 0; i < n; i++) for (j = 0; j < m; j++) {
            a = tau * i / n; b = tau * j / m; p = tau / 2 * (i + 0.5) / n
            printf \"v %.9g %.9g %.9g\n\", $3, $4, $5
        }
        for (i = 0; i < n - !$6; i++) for (j = 0; j < m; j++) {
            q = (i + 1) % n; r = (j + 1) % m
            printf \"f %d %d %d %d\n\", i * m + j + 1, q * m + j + 1, q * m + r + 1, i * m + r + 1
        }
        if (!$6) {
            printf \"f\"; for (j = 1; j <= m; j++) printf \" %d\", j; printf \"\n\"
            printf \"f\"; for (j = m; j >= 1; j--) printf \" %d\", (n - 1) * m + j; printf \"\n\"
        }
    }"
}
grid 60 120 "(2 + cos(a)) * cos(b)" "-sin(a)" "-(2 + cos(a)) * sin(b)" 1 >"$out/torus.obj"
grid 60 120 "sin(p) * cos(b)" "cos(p)" "-sin(p) * sin(b)" 0 >"$out/sphere.obj"
meshes=("$out/sphere.obj" "$out/torus.obj")
for mesh in ../shared/data/holes/bun_zipper.ply ../shared/data/transfer/spot_triangulated.obj; do
    [[ -e $mesh ]] && meshes+=("$mesh")
done

for image in "${images[@]}"; do
    name=$(basename "${image%.*}")
    for mesh in "${meshes[@]}"; do
        file=$out/$name-$(basename "${mesh%.*}")
        case $mesh in
        *spot*) view=150,15 ;;
        *torus*) view=20,35 ;;
        *) view=20,15 ;;
        esac
        "$relievo" texture "$mesh" --exemplar "$image" --vertices "$vertices" "${options[@]}" -o "$file.ply" --json "$file.json" --quiet >"$file.txt"
        "$relievo" render "$file.ply" --channel color --up y --view "$view" --size "$size" -o "$file.png" --quiet
        echo "$file.png: $(tail -1 "$file.txt")"
    done
done

python3 - "$out" "${#meshes[@]}" "${images[@]}" <<'PYTHON' || echo "no sheet: python3 with pillow is not there"
import pathlib, sys
from PIL import Image
out, columns, images = pathlib.Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]
names = [pathlib.Path(image).stem for image in images]
meshes = ["sphere", "torus", "bun_zipper", "spot_triangulated"][:columns]
width, height = Image.open(out / f"{names[0]}-sphere.png").size
sheet = Image.new("RGB", (width * (columns + 1), height * len(names)), "white")
for row, (name, path) in enumerate(zip(names, images)):
    sample = Image.open(path).convert("RGB")
    sample.thumbnail((width - 20, height - 20))
    sheet.paste(sample, (10, row * height + 10))
    for column, mesh in enumerate(meshes):
        picture = Image.open(out / f"{name}-{mesh}.png").convert("RGB")
        sheet.paste(picture, ((column + 1) * width, row * height))
sheet.save(out / "texture_sheet.png")
print(out / "texture_sheet.png")
PYTHON
