#!/bin/sh
# How fast meshes are read: sh bench/read.sh [TRIANGLES [REPEATS]]
# Prints a table for bench/README.md. BUILD is a release build (default: build/release), KEEP=1 keeps the files.
set -eu
triangles=${1:-8000000}
repeats=${2:-9}
source=$(cd "$(dirname "$0")/.." && pwd)
build=${BUILD:-$source/build/release}
folder=${TMPDIR:-/tmp}/fathom-bench-read
mkdir -p "$folder"
[ "${KEEP:-0}" = 1 ] || trap 'rm -rf "$folder"' EXIT

cc -std=c11 -O2 -D_GNU_SOURCE -I"$source/include" -I"$source/src" "$source/bench/read.c" \
    -L"$build/lib" -lfathom -Wl,-rpath,"$build/lib" -o "$folder/read"

for kind in glb ply obj; do
    file=$folder/sphere.$kind
    [ -s "$file" ] || "$folder/read" make "$triangles" "$file"
done
# The same mesh as text.
if [ ! -s "$folder/text.ply" ]; then
    awk '
        BEGIN { print "ply\nformat ascii 1.0" }
        /^v /  { v[nv++] = $2 " " $3 " " $4 }
        /^vn / { n[nn++] = $2 " " $3 " " $4 }
        /^f /  { split($2, a, "/"); split($3, b, "/"); split($4, c, "/")
                 f[nf++] = "3 " a[1] - 1 " " b[1] - 1 " " c[1] - 1 }
        END { print "element vertex " nv "\nproperty float x\nproperty float y\nproperty float z"
              if (nn == nv) print "property float nx\nproperty float ny\nproperty float nz"
              print "element face " nf "\nproperty list uchar int vertex_indices\nend_header"
              for (i = 0; i < nv; ++i) print v[i] (nn == nv ? " " n[i] : "")
              for (i = 0; i < nf; ++i) print f[i] }' "$folder/sphere.obj" >"$folder/text.ply.part"
    mv "$folder/text.ply.part" "$folder/text.ply"
fi

echo "| file             | triangles | seconds, min / median | triangles a second        | CPU time  |"
echo "|---|---|---|---|---|"
for file in sphere.glb sphere.ply text.ply sphere.obj; do
    "$folder/read" time "$folder/$file" "$repeats"
done
