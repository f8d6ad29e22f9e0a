#!/bin/sh
# Rendering to an error against as many samples everywhere: CPU time at equal true error.
# usage: BUILD=build/release sh bench/adaptive.sh [WIDTH HEIGHT [TRUTH_SPP [REPEATS]]]
set -eu
cd "$(dirname "$0")/.."
program=$(cd "${BUILD:-build/release}" && pwd)/tests/bench_adaptive
for scene in scenes/first-render.json scenes/tour/27-antialiased-reflections.json; do
    printf '\n%s\n\n' "$scene"
    "$program" "$scene" "${1:-160}" "${2:-90}" "${3:-512}" "${4:-2}"
done
