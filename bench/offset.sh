#!/bin/sh
# Counts the errors of rays that leave surfaces: sh bench/offset.sh [RAYS]
# So many for each shape; prints tables for bench/README.md: shapes as they come, then slivers. BUILD is a release build
# (default: build/release).
set -eu
rays=${1:-1e7}
source=$(cd "$(dirname "$0")/.." && pwd)
build=${BUILD:-$source/build/release}
"$build/tests/bench_offset" "$rays" 4 1
for thin in 10 100 1000; do
    echo
    echo "Triangles $thin times as long as wide:"
    echo
    "$build/tests/bench_offset" "$rays" 4 "$thin" triangle 2>/dev/null
done
