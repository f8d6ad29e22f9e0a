#!/bin/sh
# How reading, building and tracing grow from 10^4 to 10^8 triangles, and a scene of ten billion instanced ones.
# usage: BUILD=build/release sh bench/growth.sh [REPORT]
# The page with its plots goes to REPORT/index.html (default: growth), the figures next to it. $TMPDIR holds 2.8 GB for
# a while, memory 14 GB. SIZES=10k,1M are the sizes, REPEATS=5. BILLIONS=0 leaves the instances out, another number is of
# triangles each; IMAGE=FILE keeps their image, OPTIONS="--size 640x360" are for its render.
set -eu
report=${1:-growth}
source=$(cd "$(dirname "$0")/.." && pwd)
fathom=${BUILD:-$source/build/release}/bin/fathom
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir -p "$report"

"${QUIET:-env}" "$fathom" bench render --triangles "${SIZES:-10k,30k,100k,300k,1M,3M,10M,30M,100M}" --spp 1 --threads 1 \
    --repeats "${REPEATS:-5}" --seconds 8 --json "$report/growth.json" --csv "$report/growth.csv" --report "$report"

# A field of 100 x 100 spheres, a group of groups: $1 triangles each.
field() {
    awk -v triangles="$1" 'function size(i) { return 0.3 + 0.1 * sin(i * 2.3) }
    BEGIN {
        printf "{ \"image\": { \"width\": 1280, \"height\": 720 },\n"
        printf "  \"camera\": { \"eye\": [-14, 26, 62], \"target\": [2, -3, 0], \"fovy\": 45 },\n"
        printf "  \"background\": [0.5, 0.65, 0.85], \"ambient\": [0.1, 0.1, 0.12],\n"
        printf "  \"lights\": [ { \"type\": \"directional\", \"direction\": [-0.6, -0.7, -0.4], \"intensity\": 1.5 } ],\n"
        printf "  \"materials\": { \"m\": { \"kd\": [0.6, 0.45, 0.3] }, \"floor\": { \"kd\": [0.25, 0.3, 0.25] } },\n"
        printf "  \"groups\": {\n    \"ball\": [ { \"type\": \"generate\", \"kind\": \"sphere\", \"triangles\": %d, \"material\": \"m\" } ],\n", triangles
        printf "    \"row\": ["
        for (i = 0; i < 100; ++i)
            printf "%s\n      { \"type\": \"instance\", \"of\": \"ball\", \"translation\": [%.3f, %.3f, 0], \"scale\": [%.3f, %.3f, %.3f], \"rotate\": { \"axis\": [0, 1, 0], \"angle\": %d } }",
                i ? "," : "", i - 49.5, 0.1 * sin(i * 1.7), size(i), size(i), size(i), 37 * i
        printf " ] },\n  \"objects\": [\n    { \"type\": \"plane\", \"point\": [0, -0.6, 0], \"normal\": [0, 1, 0], \"material\": \"floor\" }"
        for (k = 0; k < 100; ++k)
            printf ",\n    { \"type\": \"instance\", \"of\": \"row\", \"translation\": [%.3f, 0, %.3f] }", 0.4 * sin(k), k - 49.5
        printf " ] }\n"
    }'
}

[ "${BILLIONS:-1M}" != 0 ] || exit 0
field "$(echo "${BILLIONS:-1M}" | sed 's/k$/000/; s/M$/000000/')" >"$folder/field.json"
"$fathom" info "$folder/field.json" | sed -n '/^triangles\|^instances\|^memory/p'
"$fathom" render "$folder/field.json" --integrator classic -o "${IMAGE:-$folder/field.png}" --spp 4 -v ${OPTIONS:-} 2>"$folder/err.txt" |
    sed -n '/^scene\|^seconds\|^rays\|^memory/p'
