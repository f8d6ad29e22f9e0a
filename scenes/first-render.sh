#!/bin/sh
# From nothing to a first image: installs what is missing, builds in release mode, renders scenes/first-render.json to
# out/first-render.exr and out/first-render.png. Safe to run again.
set -eu
cd "$(dirname "$0")/.."
. scenes/build.sh

echo "Rendering scenes/first-render.json"
"$fathom" render scenes/first-render.json -o "$out/first-render.exr" -o "$out/first-render.png"
echo "Done: $out/first-render.png (for looking at) and $out/first-render.exr (scene-linear)"
