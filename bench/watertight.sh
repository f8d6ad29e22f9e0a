#!/bin/sh
# What slips through the vertices of closed meshes before and after the repair, and what the repair costs:
#   sh bench/watertight.sh [RAYS [REPEATS]]
# Prints the tables for bench/README.md. BUILD is a release build (default: build).
set -eu
rays=${1:-10000000}
repeats=${2:-15}
source=$(cd "$(dirname "$0")/.." && pwd)
build=${BUILD:-$source/build}
folder=${TMPDIR:-/tmp}/fathom-bench-watertight
mkdir -p "$folder"
trap 'rm -rf "$folder"' EXIT

includes=""
for module in base math reference scene trace verify shade; do includes="$includes -I$build/modules/$module"; done
embree=$(pkg-config --libs embree4 2>/dev/null || echo "-l$(ls /usr/lib/*/libembree[34].so | sed 's/.*lib\(embree[34]\).so/\1/' | tail -n 1)")
# shellcheck disable=SC2086 # lists of words
cc -std=c11 -O2 -D_GNU_SOURCE -ffp-contract=off $includes -I"$source/include" "$source/bench/watertight.c" \
    "$build/src/libfathom_check.a" "$build/src/libfathom_core.a" $embree -ljansson -lgmp -lpthread -ldl -lm -o "$folder/watertight"

"$build/bin/fathom" generate sphere --triangles 160k -o "$folder/sphere.glb" --quiet
echo "| tracer | rays at vertices, from inside | closest: missed | after repair | any: missed | after repair | closed meshes found, s |"
echo "|---|---|---|---|---|---|---|"
"$folder/watertight" count "$folder/sphere.glb" "$rays" embree:avx512 embree:avx2 embree:sse4.2 embree:default
for mesh in "sphere 360k" "sphere 8M" "sponge 1M" "forest 2M" "terrain 2M"; do
    # shellcheck disable=SC2086 # two words
    set -- $mesh
    "$build/bin/fathom" generate "$1" --triangles "$2" -o "$folder/mesh.glb" --quiet
    printf '%s: ' "$mesh"
    "$folder/watertight" cost "$folder/mesh.glb" "$repeats"
done
