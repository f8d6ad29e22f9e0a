#!/bin/sh
# Texture lookups a second, next to OpenImageIO's TextureSystem, and under a limit: sh bench/texture.sh [SIDE [COUNT]]
# Prints tables for bench/README.md. BUILD is a release build (default: build), KEEP=1 keeps the files. Needs oiiotool.
set -eu
side=${1:-4096}
count=${2:-4}
source=$(cd "$(dirname "$0")/.." && pwd)
build=${BUILD:-$source/build}
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
