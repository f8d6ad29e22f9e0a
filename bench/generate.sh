#!/bin/sh
# How fast meshes are generated and written, through the command line. Run from the top of the checkout on a quiet
# machine: sh bench/generate.sh [TRIANGLES]. $FATHOM is the program (build/bin/fathom).
# Prints rows for bench/README.md: million triangles a second, the best of five runs.
set -eu
fathom=${FATHOM:-build/bin/fathom}
triangles=${1:-8000000}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# "FILE: 223.7 MB, made in 0.76 s, written in 0.25 s"
best() { # kind extension
  for run in 1 2 3 4 5; do "$fathom" generate "$1" --triangles "$triangles" -o "$folder/mesh.$2"; done |
    sed -n 's/.* \([0-9.]*\) MB, made in \([0-9.]*\) s, written in \([0-9.]*\) s$/\1 \2 \3/p' |
    awk -v n="$triangles" -v row="$1, .$2" '
      NR == 1 || $2 < made { made = $2 }
      NR == 1 || $3 < written { written = $3 }
      { size = $1 }
      END {
        if (!NR) exit 1
        printf "| %s | %.1f | %.1f | %.0f MB |\n", row, n / made / 1e6, n / written / 1e6, size
      }'
}

echo "| $triangles triangles | generated, M/s | written, M/s | file |"
echo "|---|---|---|---|"
for kind in sphere terrain; do best $kind glb; done
best sphere ply
best sphere obj
