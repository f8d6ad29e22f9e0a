#!/bin/sh
# How often the robust sphere in float is wrong about hit or miss: sh bench/sphere.sh [RAYS]
# Prints a table for bench/README.md: RAYS (default: 1e7) for each power of ten of radius over distance, half of them
# near the rim. BUILD is a release build (default: build/release).
set -eu
rays=${1:-1e7}
source=$(cd "$(dirname "$0")/.." && pwd)
build=${BUILD:-$source/build/release}
folder=${TMPDIR:-/tmp}/fathom-bench-sphere
mkdir -p "$folder"
trap 'rm -rf "$folder"' EXIT
cc -std=c11 -O2 -D_GNU_SOURCE -ffp-contract=off -fno-tree-slp-vectorize -I"$source/include" -I"$source/src" -I"$source/tests" \
    "$source/bench/sphere.c" "$build/src/libfathom_core.a" -lm -o "$folder/sphere"
"$folder/sphere" "$rays"
