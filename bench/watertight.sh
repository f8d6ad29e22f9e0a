#!/bin/sh
# Counts rays through the vertices of closed meshes before and after the repair, and measures its cost:
#   sh bench/watertight.sh [RAYS [REPEATS]]
# Prints the tables for bench/README.md. BUILD is a release build (default: build/release).
set -eu
rays=${1:-10000000}
repeats=${2:-15}
build=${BUILD:-$(cd "$(dirname "$0")/.." && pwd)/build/release}
folder=${TMPDIR:-/tmp}/fathom-bench-watertight
mkdir -p "$folder"
trap 'rm -rf "$folder"' EXIT

watertight=$build/tests/bench_watertight
"$build/bin/fathom" generate sphere --triangles 160k -o "$folder/sphere.glb" --quiet
echo "| tracer | rays at vertices, from inside | closest: missed | after repair | any: missed | after repair | closed meshes found, s |"
echo "|---|---|---|---|---|---|---|"
"$watertight" count "$folder/sphere.glb" "$rays" embree:avx512 embree:avx2 embree:sse4.2 embree:default
for mesh in "sphere 360k" "sphere 8M" "sponge 1M" "forest 2M" "terrain 2M"; do
    # shellcheck disable=SC2086 # two words
    set -- $mesh
    "$build/bin/fathom" generate "$1" --triangles "$2" -o "$folder/mesh.glb" --quiet
    printf '%s: ' "$mesh"
    "$watertight" cost "$folder/mesh.glb" "$repeats"
done
