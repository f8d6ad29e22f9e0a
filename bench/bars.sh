#!/bin/sh
# How often the stated 95 % interval of a pixel's value holds the true value: 12 path traced scenes, 8 seeds each.
# usage: BUILD=build/release sh bench/bars.sh [SIZE [REFERENCE_SPP]]      (64x36, 8192)
# Values are those of all pixels and channels. They are told apart by what the render itself says of them: trusted,
# doubtful (error.doubt above 0.98), and alike, where all samples of a square are.
set -eu
cd "$(dirname "$0")/.."
program=$(cd "${BUILD:-build/release}" && pwd)/bin/fathom
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$program" generate terrain --triangles 20k -o "$folder/field.ply" --quiet

# name, camera and what is around, materials, objects
scene() {
    printf '{ "image": { "integrator": "path", "width": 320, "height": 180, "maxDepth": 12 }, %s, "materials": { %s },\n  "objects": [ %s ] }\n' \
        "$2" "$3" "$4" >"$folder/$1.json"
}
view='"camera": { "eye": [0, 1.2, 6], "target": [0, 0.8, 0], "fovy": 40 }'
white='"white": { "kd": [0.73, 0.73, 0.73] }'
lamp='"lamp": { "kd": [0, 0, 0], "ke": [12, 11, 10] }'
floor='{ "type": "quad", "center": [0, 0, 0], "u": [4, 0, 0], "v": [0, 0, -4], "material": "white" }'
ball='{ "type": "sphere", "center": [0, 0.8, 0], "radius": 0.8, "material": "it" }'
above='{ "type": "quad", "center": [0, 3, 0], "u": [0.6, 0, 0], "v": [0, 0, 0.6], "material": "lamp" }'
sky='"background": [0.6, 0.8, 1]'
scene matt "$view" "$white, $lamp, \"it\": { \"kd\": [0.6, 0.2, 0.1] }" "$floor, $ball, $above"
scene field '"camera": { "eye": [0.9, 0.9, 0.5], "target": [0, 0, 0], "up": [0, 0, 1], "fovy": 40 }, '"$sky" \
    '"earth": { "kd": [0.4, 0.35, 0.3] }' '{ "type": "mesh", "file": "field.ply", "material": "earth" }'
scene rough "$view" "$white, $lamp, \"it\": { \"model\": \"metallicRoughness\", \"baseColor\": [1, 0.8, 0.5], \"metallic\": 1, \"roughness\": 0.3 }" \
    "$floor, $ball, $above"
scene plastic "$view, $sky" "$white, \"it\": { \"model\": \"metallicRoughness\", \"baseColor\": [0.1, 0.3, 0.7], \"metallic\": 0, \"roughness\": 0.2 }" \
    "$floor, $ball"
scene mirror "$view, \"lights\": [ { \"type\": \"sun\", \"direction\": [-1, -2, -1], \"irradiance\": 6 } ], $sky" \
    "$white, \"it\": { \"kd\": [0, 0, 0], \"kr\": [0.9, 0.9, 0.9] }" "$floor, $ball"
scene glass "$view, $sky" "$white, \"it\": { \"model\": \"metallicRoughness\", \"metallic\": 0, \"roughness\": 0, \"transmission\": 1, \"thickness\": 1, \"attenuationColor\": [0.4, 0.8, 0.6], \"attenuationDistance\": 1 }" \
    "$floor, $ball"
scene points "$view, \"lights\": [ { \"type\": \"point\", \"position\": [2, 3, 2], \"intensity\": 12 } ]" \
    "$white, \"it\": { \"kd\": [0.2, 0.6, 0.3] }" "$floor, $ball"
scene lens '"camera": { "eye": [0, 1.2, 6], "target": [0, 0.8, 0], "fovy": 40, "lensRadius": 0.2, "focusDistance": 5 }, '"$sky" \
    "$white, \"it\": { \"kd\": [0.7, 0.6, 0.2] }" "$floor, $ball"
scene leaf "$view" "$white, $lamp, \"it\": { \"model\": \"metallicRoughness\", \"baseColor\": [0.3, 0.7, 0.2], \"metallic\": 0, \"roughness\": 0.8, \"opacity\": 0.5 }" \
    "$floor, $ball, $above"

for file in scenes/first-render.json scenes/light/cornell-box.json scenes/light/material-row.json "$folder"/*.json; do
    "$program" bench error "$file" --adaptive --size "${1:-64x36}" --seeds ${SEEDS:-8} --max-spp 256 --reference-spp "${2:-8192}" \
        --allow-outside 2>/dev/null | sed "1s|.*/||"
done
