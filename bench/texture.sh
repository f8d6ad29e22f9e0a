#!/bin/sh
# Texture lookups a second, next to OpenImageIO's TextureSystem, and renders with and without a limit:
# sh bench/texture.sh [SIDE [COUNT]]
# Prints tables for bench/README.md. BUILD is a release build (default: build/release), KEEP=1 keeps the files. Needs oiiotool.
set -eu
side=${1:-4096}
count=${2:-4}
source=$(cd "$(dirname "$0")/.." && pwd)
build=${BUILD:-$source/build/release}
folder=${TMPDIR:-/tmp}/fathom-bench-texture
mkdir -p "$folder"
[ "${KEEP:-0}" = 1 ] || trap 'rm -rf "$folder"' EXIT

includes="-I$source/include"
for module in base scene math image texture; do includes="$includes -I$build/modules/$module"; done
# shellcheck disable=SC2046,SC2086 # several words each
c++ -std=c++17 -O2 -Wno-array-bounds $includes $(pkg-config --cflags OpenImageIO) "$source/bench/texture.cpp" \
    "$build/src/libfathom_core.a" $(pkg-config --libs OpenImageIO) -ljansson -lpng -lpthread -ldl -lm \
    -o "$build/bin/bench_texture"

set --
i=0
while [ $i -lt "$count" ]; do
    file=$folder/$i.tx
    if [ ! -s "$file" ]; then
        oiiotool --create "${side}x$side" 3 --noise:type=uniform:min=0:max=1:seed=$i -d uint8 -o "$folder/$i.tif"
        "$build/bin/fathom" texture "$folder/$i.tif" -o "$file" --quiet
    fi
    set -- "$@" "$file"
    i=$((i + 1))
done
# As many names of these files as make four gigabytes of tiles.
while [ $((i * side * side / 250000)) -lt 2650 ]; do
    ln -sf $((i % count)).tx "$folder/link$i.tx"
    set -- "$@" "$folder/link$i.tx"
    i=$((i + 1))
done
echo '| lookups | threads | limit | Fathom, million a second | OpenImageIO | ratio |'
echo '|---|---|---|---|---|---|'
for threads in 1 2; do "$build/bin/bench_texture" $threads 8e9 "$@"; done
"$build/bin/bench_texture" 2 512e6 "$@"

# A floor and a wall of such textures, in white light from everywhere. `linear` reads full resolution at every bounce.
write_hall() {
    filter=$1
    shift
    echo '{ "camera": { "eye": [2.5, 2, 5.5], "target": [2.5, 1, 1], "fovy": 50 }, "background": [1, 1, 1], "lights": [],'
    echo '"materials": {'
    i=0
    for file in "$@"; do
        [ $i = 0 ] || echo ,
        printf '"%d": { "model": "metallicRoughness", "metallic": 0, "baseColorTexture":' $i
        printf '{ "file": "%s", "scale": [4, 4], "filter": "%s" } }' "${file##*/}" "$filter"
        i=$((i + 1))
    done
    echo '}, "objects": ['
    i=0
    for file in "$@"; do
        [ $i = 0 ] || echo ,
        row=$((i / 5))
        if [ $((row % 2)) = 0 ]; then
            place="$((i % 5)).5, 0, $((row / 2)).5], \"v\": [0, 0, 0.5]"
        else
            place="$((i % 5)).5, $((row / 2)).5, 0], \"v\": [0, 0.5, 0]"
        fi
        printf '{ "type": "quad", "u": [0.5, 0, 0], "center": [%s, "material": "%d" }' "$place" $i
        i=$((i + 1))
    done
    echo '] }'
}

seconds() {
    "$build/bin/fathom" render "$folder/hall.json" -o "$folder/$1.exr" --exr-float --texture-memory "$1" --spp 64 \
        --size 640x360 --stats - --quiet | sed -n 's/.*"total": \([0-9.]*\).*/\1/p' | head -1
}

echo '| a render, filter | no limit, s | 512 MB, s | ratio |'
echo '|---|---|---|---|'
for filter in linear trilinear stochastic; do
    write_hall $filter "$@" > "$folder/hall.json"
    free=$(seconds 8G)
    limited=$(seconds 512M)
    "$build/bin/fathom" compare "$folder/8G.exr" "$folder/512M.exr" >&2
    echo "$filter $free $limited" | awk '{ printf "| %s | %.1f | %.1f | %.2f |\n", $1, $2, $3, $3 / $2 }'
done
