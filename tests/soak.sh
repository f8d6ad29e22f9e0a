#!/bin/sh
# Renders many times in one process and asks whether memory, descriptors and threads stay as they are: tests/soak.c.
# usage: sh tests/soak.sh [RENDERS]     (default 10000, some minutes; a multiple of 500, at least 1000)
# Builds in build/test-release, or $FATHOM_BUILD/test-release.
set -eu
cd "$(dirname "$0")/.."
build=${FATHOM_BUILD:-build}/test-release
renders=${1:-10000}
sh tests/packages.sh test
mkdir -p "$build"
{ cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release && cmake --build "$build" --target soak fathom_image_module fathom_image_helper; } \
    >"$build/soak.log" 2>&1 || { tail -n 20 "$build/soak.log" >&2; exit 1; }
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# Other libraries have taken what they keep by a tenth of the way. Threads keep no blocks for themselves: such blocks
# would count as handed out, and come and go by chance.
GLIBC_TUNABLES=glibc.malloc.tcache_count=0 "$build/tests/soak" "$renders" "$folder" "$((renders / 500 * 50))"
