#!/bin/sh
# The least that a path tracer computes at a vertex next to the tracer's calls, by two designs, with AVX2 and, where
# there is, AVX-512: sh bench/vertices.sh [MILLIONS of vertices, 2]
set -eu
source=$(cd "$(dirname "$0")/.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for isa in x86-64-v3 x86-64-v4; do
    [ $isa = x86-64-v3 ] || grep -q avx512vl /proc/cpuinfo || continue
    cc -std=c11 -O3 -D_GNU_SOURCE -march=$isa -mprefer-vector-width=512 -ffp-contract=off -fno-math-errno \
        -fno-trapping-math "$source/bench/vertices.c" -lm -o "$folder/vertices"
    printf '%s: ' $isa
    "$folder/vertices" "${1:-2}"
done
