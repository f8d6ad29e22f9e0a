#!/bin/sh
# Long runs of `fathom validate`: every tracer over the built-in scenes, leaks by instruction set, a mesh of 8 million
# triangles. usage: BUILD=build/release sh bench/validate.sh [RAYS]     (of each family and scene; default 5000)
set -eu
cd "$(dirname "$0")/.."
fathom=${BUILD:-build/release}/bin/fathom
rays=${1:-5000}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

"$fathom" validate --rays "$rays" --tracer embree --tracer embree:user --tracer linear:f32 --tracer linear:f64 --tracer bvh
set --
for isa in sse2 sse4.2 avx avx2 avx512; do set -- "$@" --tracer embree:$isa --tracer embree:default:$isa; done
"$fathom" validate triangles --families edge,vertex,uniform --rays $((4 * rays)) "$@"
"$fathom" generate sphere --triangles 8M -o "$folder/heavy.glb"
"$fathom" validate "$folder/heavy.glb" --rays "$rays" --tracer embree --tracer bvh
