#!/bin/sh
# Rendering to an error against as many samples everywhere: CPU time at equal true error.
# usage: BUILD=build/release sh bench/adaptive.sh [SCENE [WIDTH HEIGHT [TRUTH_SPP [MOST_SPP [REPEATS]]]]]
# The true image is rendered in bands of 96 rows into TRUTH (default: a temporary file), and kept there.
set -eu
cd "$(dirname "$0")/.."
program=$(cd "${BUILD:-build/release}" && pwd)/tests/bench_adaptive
scene=${1:-scenes/first-render.json} width=${2:-1280} height=${3:-720}
truth=${TRUTH:-$(mktemp)}
[ -n "${TRUTH:-}" ] || trap 'rm -f "$truth"' EXIT
y=0
while [ ! -e "$truth.done" ] && [ "$y" -lt "$height" ]; do
    end=$((y + 96 < height ? y + 96 : height))
    "$program" truth "$scene" "$width" "$height" "${4:-512}" "$truth" "$y" "$end"
    y=$end
done
[ -z "${TRUTH:-}" ] || : >"$truth.done"
"$program" compare "$scene" "$width" "$height" "$truth" "${5:-32}" "${6:-2}"
