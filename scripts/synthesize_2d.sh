#!/usr/bin/env bash
# Textures synthesized in two dimensions by somebody else's program, the crate texture-synthesis (a multiresolution
# method with its own settings, one thread, a fixed seed), for comparison with those on a flat mesh.
#
#   scripts/synthesize_2d.sh [IMAGE…]     (default: the images in ../shared/data/textures)
#   cargo bench --bench texture -- judge target/texture-synthesis
#
# Installs the program into target/texture-synthesis (once; from crates.io), writes the samples there that `texture`
# synthesizes from as well, and then OUT/NAME.png and OUT/sources/NAME.png (where each pixel is from); a Markdown
# table of processor seconds on standard output. SIZE (192), SEED (0), OPTIONS (further ones of the program) and
# OUT (target/texture-synthesis) can be set in the environment.
set -euo pipefail
caller=$PWD
cd "$(dirname "$0")/.."
folder=target/texture-synthesis
size=${SIZE:-192} seed=${SEED:-0} out=${OUT:-$folder}
read -ra options <<<"${OPTIONS:-}"

images=()
for image in "$@"; do
    [[ $image == /* ]] || image=$caller/$image
    images+=("$image")
done
if ((${#images[@]} == 0)); then
    for image in ../shared/data/textures/*.png; do
        [[ -e $image ]] && images+=("$image")
    done
fi
if ((${#images[@]} == 0)); then
    echo "SKIPPED: there are no images in ../shared/data/textures"
    exit 0
fi

program=$folder/bin/texture-synthesis
[[ -x $program ]] || cargo install texture-synthesis-cli --version 0.8.3 --locked --root "$folder"
cargo bench --locked --bench texture -- prepare "${images[@]}"

mkdir -p "$out/sources"
transform=$(mktemp)
trap 'rm -f "$transform"' EXIT
echo "$("$program" --version) --out-size $size --seed $seed --threads 1 ${options[*]-}"
echo
TIMEFORMAT=%U
echo "| sample | s |"
echo "|---|---|"
for image in "${images[@]}"; do
    name=$(basename "${image%.*}")
    # Seconds of the processor: what else the machine does counts less in them.
    seconds=$({
        time "$program" --out-size "$size" --seed "$seed" --threads 1 --no-progress "${options[@]}" \
            --out "$out/$name.png" generate --save-transform "$transform" "$folder/samples/$name.png" >&3 2>&3
    } 3>&2 2>&1)
    # The same pixels put together again, of an image whose colors say where they are.
    "$program" --out "$out/sources/$name.png" repeat --transform "$transform" "$folder/places/$name.png"
    echo "| $name | $seconds |"
done
