#!/usr/bin/env bash
# Makes the README's pictures (docs/pictures), by relievo alone: synthetic scans, as they are and completed.
# Where ../shared/data is there, pictures of those scans go to target/pictures: they
# are not ours to redistribute.
# RELIEVO=path/to/relievo takes that program instead of building one.
set -euo pipefail
cd "$(dirname "$0")/.."
if [ -z "${RELIEVO:-}" ]; then
    cargo build --release --locked
    RELIEVO=target/release/relievo
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
out=docs/pictures
mkdir -p "$out"

# complete NAME SCAN [OPTION…]: the completed scan, as NAME.
complete() {
    local name=$1 scan=$2
    shift 2
    # 3: some holes had to be left open, which is no failure here.
    "$RELIEVO" complete "$scan" -o "$folder/$name.ply" -q "$@" || [ $? -eq 3 ]
}

# picture NAME WHAT [OPTION…]: a picture NAME-WHAT.png of the completed scan NAME.
picture() {
    local name=$1 what=$2
    shift 2
    "$RELIEVO" render "$folder/$name.ply" -o "$out/$name-$what.png" -q "$@"
}

# before_and_after NAME [OPTION…]
before_and_after() {
    local name=$1
    shift
    picture "$name" before --before "$@"
    picture "$name" after "$@"
}

"$RELIEVO" synth golf-ball --view 0,0,1 -o "$folder/golf-ball-half.ply" -q
complete golf-ball "$folder/golf-ball-half.ply" --extend
golf=(--view 90,20 --up z)
before_and_after golf-ball --size 400x350 "${golf[@]}"
picture golf-ball completed --size 400x350 --channel completed --no-legend "${golf[@]}"
picture golf-ball height --size 480x350 --channel height "${golf[@]}"

"$RELIEVO" synth bark -o "$folder/bark-hole.ply" -q
complete bark "$folder/bark-hole.ply"
before_and_after bark --size 400x350
picture bark completed --size 400x350 --channel completed --no-legend

"$RELIEVO" synth bricks -o "$folder/bricks-hole.ply" -q
complete bricks "$folder/bricks-hole.ply"
before_and_after bricks --size 400x350
picture bricks source --size 400x350 --channel source --no-legend

# A wall's image, seen from above, as the sample for a ball; and its relief on a ring.
"$RELIEVO" synth bricks --full --vertices 40000 -o "$folder/wall.ply" -q
"$RELIEVO" render "$folder/wall.ply" -o "$folder/wall.png" -q --channel color --view top --up z \
    --projection orthographic --size 160x160 --zoom 1.8 --no-legend
cp "$folder/wall.png" "$out/texture-sample.png"
"$RELIEVO" synth golf-ball --full -o "$folder/ball.ply" -q
"$RELIEVO" texture "$folder/ball.ply" -e "$folder/wall.png" --vertices 60000 --symmetry 2 -o "$folder/texture.ply" -q >/dev/null
picture texture ball --size 400x350 --channel color --up z --view 20,15
awk 'BEGIN {
    tau = 8 * atan2(1, 1)
    for (i = 0; i < 40; i++) for (j = 0; j < 80; j++) {
        a = tau * i / 40; b = tau * j / 80
        printf "v %.9g %.9g %.9g\n", (2 + cos(a)) * cos(b), (2 + cos(a)) * sin(b), sin(a)
        p = (i + 1) % 40; q = (j + 1) % 80
        faces = faces sprintf("f %d %d %d %d\n", i * 80 + j + 1, i * 80 + q + 1, p * 80 + q + 1, p * 80 + j + 1)
    }
    printf "%s", faces
}' >"$folder/ring.obj"
"$RELIEVO" texture "$folder/ring.obj" -e "$folder/wall.ply" --vertices 60000 --symmetry 2 -o "$folder/texture.ply" -q >/dev/null
picture texture relief --size 400x350 --channel color --up z --view 20,35
"$RELIEVO" render "$folder/ball.ply" --channel shape -o "$out/transfer-source.png" --size 400x350 --up z --view 20,15 -q
"$RELIEVO" transfer --source "$folder/ball.ply" --target "$folder/ring.obj" --channel height --shape none --up none \
    --final vote -o "$folder/transfer.ply" -q >/dev/null
picture transfer relief --size 400x350 --channel shape --up z --view 20,35

shared=../shared/data
if [ ! -d "$shared" ]; then
    echo "SKIPPED: $shared is not there, so there are no pictures of its scans"
    exit 0
fi
out=target/pictures
mkdir -p "$out"
complete limestone "$shared/scans/limestone_V21_grid.ply"
before_and_after limestone
picture limestone completed --channel completed
picture limestone height --channel height
complete tower "$shared/holes/tower_holes.obj"
before_and_after tower
picture tower completed --channel completed
