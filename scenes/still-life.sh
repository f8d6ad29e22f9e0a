#!/bin/sh
# Makes the images and meshes of scenes/still-life/still-life.json in out/still-life, and renders them to
# out/still-life.exr and out/still-life.png. Installs and builds as first-render.sh does. Safe to run again.
# usage: sh scenes/still-life.sh [options of fathom render]
set -eu
cd "$(dirname "$0")/.."
. scenes/build.sh
sh tests/packages.sh scenes

echo "Making images and meshes in $out/still-life"
/usr/bin/python3 -B scenes/still-life/make.py "$out/still-life" # Debian's, which has the packages
echo "Rendering $out/still-life/still-life.json"
"$fathom" render "$out/still-life/still-life.json" -o "$out/still-life.exr" -o "$out/still-life.png" "$@"
