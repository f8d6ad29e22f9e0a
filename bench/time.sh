#!/bin/sh
# Rendering to a time: when the last file is complete and when the process ends, against the time that was asked for.
# usage: BUILD=build/release sh bench/time.sh [SCENE [SECONDS…]]
set -eu
cd "$(dirname "$0")/.."
program=$(cd "${BUILD:-build/release}" && pwd)/bin/fathom
scene=${1:-scenes/first-render.json}
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- 2 5 15
folder=$(mktemp -d)
failed=0
trap 'rm -rf "$folder"' EXIT

# one SECONDS ARGUMENT…: a row of the table.
one() {
    seconds=$1
    shift
    rm -f "$folder"/*
    began=$(date +%s.%N)
    "$program" render "$scene" --max-time "$seconds" --stats "$folder/stats.json" --quiet "$@" || { failed=1; return 0; }
    ended=$(date +%s.%N)
    last=0
    for file in "$folder"/out.*; do
        last=$(printf '%s\n%s\n' "$last" "$(date -r "$file" +%s.%N)" | sort -n | tail -1)
    done
    shown=$(echo "$*" | sed "s|$folder/||g")
    awk -v s="$seconds" -v b="$began" -v l="$last" -v e="$ended" -v a="$shown" \
        -v w="$(sed -n 's/.*"write": \([0-9.]*\).*/\1/p' "$folder/stats.json")" \
        -v n="$(sed -n 's/.*"meanSpp": \([0-9.]*\).*/\1/p' "$folder/stats.json")" \
        -v x="$(sed -n 's/.*"errorEstimate": \([0-9.]*\).*/\1/p' "$folder/stats.json")" 'BEGIN {
        printf "| %s | `%s` | %.3f | %+.1f %% | %.3f | %+.1f %% | %.3f | %.1f | %s |\n",
            s, a, l - b, 100 * ((l - b) / s - 1), e - b, 100 * ((e - b) / s - 1), w, n, x ? x : "unknown" }'
}

echo '| asked for, s | outputs | last file complete, s | off by | process ended, s | off by | of it writing, s | samples a pixel | largest estimate |'
echo '|---|---|---|---|---|---|---|---|---|'
for seconds in "$@"; do
    one "$seconds" -o "$folder/out.png"
    one "$seconds" -o "$folder/out.exr" -o "$folder/out.png"
    one "$seconds" -o "$folder/out.exr" --aov all
done
exit $failed
