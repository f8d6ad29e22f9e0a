#!/bin/sh
# Rays a second of every tracer: BUILD=build/release sh bench/trace.sh [REPEATS]
# Prints a table for bench/README.md: generated spheres of 10 thousand to a million triangles, and of 8 million for those
# that matter there. TRIANGLES=10k,100k and HEAVY= measure less. REPORT=folder writes the plots too.
set -eu
repeats=${1:-9}
source=$(cd "$(dirname "$0")/.." && pwd)
fathom=${BUILD:-$source/build/release}/bin/fathom
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

table() {
    awk -F, '
        /^#/ || $1 == "triangles" { next }
        { key = $1 "," $3; if (!(key in build)) order[++n] = key
          build[key] = $5; bytes[key] = $6
          rate[key, $7] = sprintf("%.3g ± %.0f %%", $13, 50 * ($14 - $12) / $13) ($10 < 16384 ? sprintf(" (%d rays)", $10) : "") }
        END { for (i = 1; i <= n; ++i) { split(order[i], k, ","); key = order[i]
              printf "| %d | `%s` | %.3f s | %.1f MB | %s | %s | %s | %s |\n", k[1], k[2], build[key], bytes[key] / 1e6,
                  rate[key, "camera"], rate[key, "bounce"], rate[key, "shadow"], rate[key, "between"] } }' "$1"
}

echo "| triangles | tracer | build, processor time | BVH | camera | bounce | shadow | between |"
echo "|---|---|---|---|---|---|---|---|"
"$fathom" bench trace --triangles "${TRIANGLES:-10k,100k,1M}" --repeats "$repeats" --quiet --csv "$folder/result.csv" \
    ${REPORT:+--report "$REPORT"}
table "$folder/result.csv"
[ -n "${HEAVY=8M}" ] || exit 0
"$fathom" bench trace --triangles "$HEAVY" --repeats "$repeats" --tracer embree:1 --tracer embree:8 --tracer embree:16 \
    --tracer embree:raw:16 --quiet --csv "$folder/result.csv"
table "$folder/result.csv"
