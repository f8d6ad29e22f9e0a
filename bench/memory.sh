#!/bin/sh
# Measures the memory of renders, against the meshes, BVH and film that they need: BUILD=build/release sh bench/memory.sh
# Prints a table for bench/README.md: displaced spheres, 1280x720, one sample a pixel. MESHES="360k 8M" are which;
# LIMITS="8G 3G" render each with these limits besides, from 4G on where no more address space can be had (libraries
# reserve some 0.7 GB of it that they never use); KEEP=DIR keeps the meshes.
set -eu
source=$(cd "$(dirname "$0")/.." && pwd)
fathom=${BUILD:-$source/build/release}/bin/fathom
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
meshes=${KEEP:-$folder}

# row MESH WHAT: from stats.json and err.txt. Without Embree's own: the peak less what Embree gave back after building.
row() {
    awk -v mesh="$1" -v what="$2" '
        { gsub(/[",:]/, "") }
        $1 == "peakBytes" { peak = $2 }
        $1 == "meshBytes" { mesh_bytes = $2 }
        $1 == "bvhBytes" { bvh = $2 }
        $1 == "filmBytes" { film = $2 }
        $1 == "bvhPeakBytes" { most = $2 }
        $1 == "foreseenBytes" { foreseen = $2 }
        END {
            needed = mesh_bytes + bvh + film
            printf "| %s | %s | %.1f | %.1f | %.1f | %.1f | %.1f | %.3f | %.3f |\n", mesh, what, mesh_bytes / 1e6, bvh / 1e6,
                most / 1e6, peak / 1e6, foreseen / 1e6, peak / needed, (peak - most + bvh) / needed
        }' "$folder/stats.json"
}

# with MESH WHAT OPTION…
with() {
    mesh=$1
    what=$2
    shift 2
    code=0
    (
        [ "$1" != --memory-limit ] || [ "$2" = "${2%G}" ] || [ "${2%G}" -lt 4 ] || ulimit -v $((${2%G} * 1000000000 / 1024))
        exec "$fathom" render "$meshes/$mesh.glb" --integrator classic -o "$folder/out.png" --size 1280x720 --spp 1 --quiet \
            --stats "$folder/stats.json" "$@"
    ) 2>"$folder/err.txt" || code=$?
    if [ $code -eq 0 ]; then
        ! grep -q 'a compact one' "$folder/err.txt" || what="$what: compact, it says"
        row "$mesh" "$what"
    else
        echo "| $mesh | $what: exit code $code, $(tail -n 1 "$folder/err.txt" | sed 's/^fathom: //') | | | | | | | |"
    fi
}

echo "| triangles | structures | meshes | BVH | at most while built | peak, MB | foreseen | peak over meshes, BVH, film | without Embree's own |"
echo "|---|---|---|---|---|---|---|---|---|"
for mesh in ${MESHES:-360k 8M}; do
    [ -e "$meshes/$mesh.glb" ] || "$fathom" generate sphere --triangles "$mesh" -o "$meshes/$mesh.glb" -q
    for tracer in ${TRACERS:-embree:low embree:medium embree:compact:medium}; do
        with "$mesh" "$tracer" --tracer "$tracer"
    done
    for limit in ${LIMITS:-}; do with "$mesh" "limit $limit" --memory-limit "$limit"; done
    [ "$meshes" != "$folder" ] || rm -f "$meshes/$mesh.glb"
done
