#!/bin/sh
# From nothing to a first image: installs what is missing, builds in release mode, renders scenes/first-render.json to
# out/first-render.exr and out/first-render.png. Safe to run again.
set -eu
cd "$(dirname "$0")/.."
source=$(pwd)
build=${FATHOM_BUILD:-$source/build}/release
out=${FATHOM_OUT:-$source/out}

sh tests/packages.sh build
mkdir -p "$build" "$out"
echo "Building Fathom in $build (once; a minute or two)"
log=$build/build.log
if ! cmake -S "$source" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DFATHOM_TESTS=OFF >"$log" 2>&1 ||
    ! cmake --build "$build" -j "$(nproc)" >>"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "first-render: the build failed; the whole log is $log" >&2
    exit 1
fi
echo "Rendering scenes/first-render.json"
"$build/bin/fathom" render "$source/scenes/first-render.json" -o "$out/first-render.exr" -o "$out/first-render.png"
echo "Done: $out/first-render.png (for looking at) and $out/first-render.exr (scene-linear)"
