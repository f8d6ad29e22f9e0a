#!/bin/sh
# How far rendering is from Embree's bare calls: BUILD=build/release sh bench/render.sh [REPEATS [REPEATS_AT_16_SPP]]
# Prints a table for bench/README.md: displaced spheres of 0.36 and 8 million triangles, Lambert and Phong, 1280x720,
# with 1 and 8 point lights, 1 and 16 spp. MESHES="8M", LIGHTS="1", SPP="1", SIZE=160x90 measure less; TRACER=embree:avx2 another.
set -eu
repeats=${1:-9}
many=${2:-$repeats}
source=$(cd "$(dirname "$0")/.." && pwd)
fathom=${BUILD:-$source/build/release}/bin/fathom
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# scene MESH LIGHTS: lights on a ring around the view, so that each reaches about the same part of what is seen.
scene() {
    awk -v mesh="$1" -v n="$2" 'BEGIN {
        printf "{ \"image\": { \"width\": 1280, \"height\": 720 },\n"
        printf "  \"camera\": { \"eye\": [0, 0.8, 3.2], \"target\": [0, 0, 0], \"fovy\": 40 },\n"
        printf "  \"materials\": { \"m\": { \"kd\": [0.6, 0.5, 0.4], \"ks\": [0.3, 0.3, 0.3], \"specular\": \"phong\" } },\n"
        printf "  \"lights\": ["
        for (k = 0; k < n; ++k) {
            a = 0.9 + 6.283185307 * k / n
            printf "%s\n    { \"type\": \"point\", \"position\": [%.4f, %.4f, 3.5], \"intensity\": %.4f }", k ? "," : "",
                2.5 * cos(a), 2.5 * sin(a), 20 / n
        }
        printf " ],\n  \"objects\": [ { \"type\": \"mesh\", \"file\": \"%s\", \"material\": \"m\" } ] }\n", mesh
    }'
}

echo "| triangles | lights | spp | rays: closest, any | bare calls, one thread | through the tracer | render phase (quartiles) | two threads, by the clock |"
echo "|---|---|---|---|---|---|---|---|"
for mesh in ${MESHES:-360k 8M}; do
    "$fathom" generate sphere --triangles "$mesh" -o "$folder/$mesh.glb" -q
    for lights in ${LIGHTS:-1 8}; do
        scene "$mesh.glb" "$lights" >"$folder/scene.json"
        for spp in ${SPP:-1 16}; do
            times=$repeats
            [ "$spp" = 1 ] || times=$many
            "$fathom" bench render "$folder/scene.json" --tracer "${TRACER:-embree}" --spp "$spp" --repeats "$times" \
                --size "${SIZE:-1280x720}" --quiet --csv "$folder/result.csv"
            awk -F, -v mesh="$mesh" -v lights="$lights" '
                /^#/ || $1 == "spp" { next }
                { row = sprintf("| %s | %s | %s | %.2f M, %.2f M | %.4f s | %.3f | %.3f (%.3f–%.3f) |", mesh, lights, $1,
                                ($10 + $12 + $13) / 1e6, $11 / 1e6, $14, $18, $16, $15, $17); speedup = sprintf("%.2f", $9) }
                END { printf "%s %s |\n", row, speedup }' "$folder/result.csv"
        done
    done
    rm -f "$folder/$mesh.glb"
done
