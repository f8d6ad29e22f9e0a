#!/bin/sh
# How fast meshes are generated and written, through the command line: sh bench/generate.sh [TRIANGLES [REPEATS]]
# Prints a table for bench/README.md. BUILD is a release build (default: build/release).
set -eu
triangles=${1:-8000000}
repeats=${2:-5}
source=$(cd "$(dirname "$0")/.." && pwd)
fathom=${FATHOM:-${BUILD:-$source/build/release}/bin/fathom}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Into $seconds, the CPU time of all programs run so far: the second line of `times` is "0m1.23s 0m0.12s", user and
# system. Not in a subshell, which would count its own alone.
cpu() {
    times >"$folder/times"
    seconds=$(awk 'NR == 2 { gsub(/s/, ""); split($1, u, "m"); split($2, s, "m"); print (u[1] + s[1]) * 60 + u[2] + s[2] }' \
        "$folder/times")
}

measure() { # kind extension
    cpu
    before=$seconds
    : >"$folder/log"
    i=0
    while [ $i -lt "$repeats" ]; do
        "$fathom" generate "$1" --triangles "$triangles" -o "$folder/mesh.$2" >>"$folder/log"
        i=$((i + 1))
    done
    cpu
    # "FILE: 223.7 MB, made in 0.76 s, written in 0.25 s"
    sed -n 's/.* \([0-9.]*\) MB, made in \([0-9.]*\) s, written in \([0-9.]*\) s$/\1 \2 \3/p' "$folder/log" |
        awk -v n="$triangles" -v row="$1, .$2" -v before="$before" -v after="$seconds" '
            NR == 1 || $2 < made { made = $2 }
            NR == 1 || $3 < written { written = $3 }
            { size = $1 }
            END {
                if (!NR) exit 1
                printf "| %-12s | %5.2f M | %5.2f s, %5.1f M/s | %5.2f s, %5.1f M/s | %5.2f s | %5.0f MB |\n", row,
                    n / 1e6, made, n / made / 1e6, written, n / written / 1e6, (after - before) / NR, size
            }'
    rm "$folder/mesh.$2"
}

echo "| mesh         | triangles | generated          | written            | CPU time |     file |"
echo "|---|---|---|---|---|---|"
measure sphere glb
measure terrain glb
measure sphere ply
measure sphere obj
