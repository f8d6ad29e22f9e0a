#!/bin/sh
# Measures the cost of ten quads or spheres for the rays of a mesh: BUILD=build/release sh bench/beside.sh [TRIANGLES [ROUNDS]]
# Prints a table for bench/README.md: a displaced sphere under one point light, 1280x720, 1 sample a pixel, one thread,
# alone and with ten small shapes in a ring around it, inside it, or behind the camera. The scenes take turns; times are
# the least of all rounds, of the render phase. TRACER=embree:user measures another tracer.
set -eu
triangles=${1:-1M}
rounds=${2:-21}
source=$(cd "$(dirname "$0")/.." && pwd)
fathom=${BUILD:-$source/build/release}/bin/fathom
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$fathom" generate sphere --triangles "$triangles" -o "$folder/mesh.glb" -q

# scene KIND RADIUS_OF_RING Z SIZE
scene() {
    awk -v kind="$1" -v ring="$2" -v z="$3" -v size="$4" 'BEGIN {
        printf "{ \"image\": { \"width\": 1280, \"height\": 720 },\n"
        printf "  \"camera\": { \"eye\": [0, 0.8, 3.2], \"target\": [0, 0, 0], \"fovy\": 40 },\n"
        printf "  \"materials\": { \"m\": { \"kd\": [0.6, 0.5, 0.4], \"ks\": [0.3, 0.3, 0.3], \"specular\": \"phong\" } },\n"
        printf "  \"lights\": [ { \"type\": \"point\", \"position\": [1.55, 1.96, 3.5], \"intensity\": 20 } ],\n"
        printf "  \"objects\": [ { \"type\": \"mesh\", \"file\": \"mesh.glb\", \"material\": \"m\" }"
        for (k = 0; k < 10 && kind != "none"; ++k) {
            x = ring * cos(0.6283 * k); y = ring * sin(0.6283 * k)
            printf ",\n    { \"type\": \"%s\", \"center\": [%.4f, %.4f, %.4f], \"material\": \"m\", ", kind, x, y, z
            if (kind == "sphere") printf "\"radius\": %g }", size
            else printf "\"u\": [%g, 0, 0], \"v\": [0, %g, 0] }", size, size
        }
        printf " ] }\n" }'
}
scene none 0 0 0 >"$folder/alone.json"
for kind in sphere quad; do
    scene $kind 1.15 0 0.02 >"$folder/$kind-around.json"
    scene $kind 0.5 0 0.3 >"$folder/$kind-inside.json"
    scene $kind 1 10 0.1 >"$folder/$kind-behind.json"
done

scenes="alone sphere-around sphere-inside sphere-behind quad-around quad-inside quad-behind"
round=0
while [ $round -lt "$rounds" ]; do
    for name in $scenes; do
        "$fathom" render "$folder/$name.json" --integrator classic -o "$folder/a.png" --threads 1 --spp 1 --tracer "${TRACER:-embree}" -q \
            --stats "$folder/stats.json"
        sed -n 's/.*"render": \([0-9.]*\).*/'"$name"' \1/p' "$folder/stats.json" >>"$folder/times"
    done
    round=$((round + 1))
done
echo "| shapes | render, seconds | over the mesh alone |"
echo "|---|---|---|"
awk -v order="$scenes" '!($1 in least) || $2 < least[$1] { least[$1] = $2 }
    END { n = split(order, name, " ")
          for (i = 1; i <= n; ++i) printf "| %s | %.4f | %.3f |\n", name[i], least[name[i]], least[name[i]] / least["alone"] }' \
    "$folder/times"
