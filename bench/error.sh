#!/bin/sh
# Measures the error against time: `fathom bench error` on a scene of the tour and on a generated forest; and what build quality
# costs and saves on a sphere of a million triangles, `fathom bench render`. The error of intersectors against their time is in the page of
# `fathom validate --report`, section "Error against time".
# usage: BUILD=build/release sh bench/error.sh [WIDTHxHEIGHT [MAX_SPP [SEEDS [REPORTS]]]]
# (default 480x270, 1024, 5; REPORTS: a folder for the pages, none without)
set -eu
cd "$(dirname "$0")/.."
fathom=${BUILD:-build/release}/bin/fathom
size=${1:-480x270} most=${2:-1024} seeds=${3:-5} reports=${4:-}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# page NAME: the options that keep a page, if they are kept.
page() { [ -z "$reports" ] || { mkdir -p "$reports" && echo "--report $reports/$1"; }; }

"$fathom" generate forest --triangles 1M -o "$folder/forest.glb" >"$folder/log"
for scene in scenes/tour/27-antialiased-reflections.json "$folder/forest.glb"; do
    # shellcheck disable=SC2046
    "$fathom" bench error "$scene" --size "$size" --max-spp "$most" --seeds "$seeds" \
        $(page "error-$(basename "${scene%.*}")") 2>"$folder/log"
    echo
done
for flags in "" :default; do
    # shellcheck disable=SC2046
    "$fathom" bench render --triangles 1M --size "$size" --repeats "$seeds" --spp 1,4,16,64 --threads 1 \
        --tracer "embree$flags:low" --tracer "embree$flags:medium" --tracer "embree$flags:high" $(page "build${flags#:}") 2>"$folder/log"
    echo
done
