#!/bin/sh
# Secondary rays by depth against single-ray calls: BUILD=build/release sh bench/secondary.sh [REPEATS [RAYS]]
# Prints a table for bench/README.md: displaced spheres of 0.36 and 2 million triangles of mirror and of glass, a ball of
# mirror over a terrain of a million, a scene of the tour, and the first render. SCENES="mirror-360k glass-2M terrain tour
# first" measures less; DEPTH=3 tells of fewer bounces.
set -eu
repeats=${1:-9}
rays=${2:-60000}
deepest=${DEPTH:-8}
source=$(cd "$(dirname "$0")/.." && pwd)
fathom=${BUILD:-$source/build}/bin/fathom
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# scene MESH MATERIAL [OBJECT]
scene() {
    cat >"$folder/scene.json" <<END
{ "image": { "width": 1280, "height": 720 }, "background": [0.3, 0.4, 0.5],
  "camera": { "eye": [0, 0.8, 3.2], "target": [0, 0, 0], "fovy": 40 },
  "materials": {
    "mirror": { "kd": [0.05, 0.05, 0.05], "kr": [0.9, 0.9, 0.9] }, "floor": { "kd": [0.5, 0.5, 0.5] },
    "glass": { "kd": [0, 0, 0], "kr": [1, 1, 1], "kt": [0.97, 1, 0.98], "fresnel": true, "ior": 1.5 } },
  "lights": [ { "type": "point", "position": [2, 2.5, 3.5], "intensity": 20 } ],
  "objects": [ { "type": "mesh", "file": "mesh.glb", "material": "$2" },
    { "type": "quad", "center": [0, -1.2, 0], "u": [6, 0, 0], "v": [0, 0, -6], "material": "floor" }${3:+, $3} ] }
END
    "$fathom" generate ${4:-sphere} --triangles "$1" -o "$folder/mesh.glb" -q
    echo "$folder/scene.json"
}

file_of() {
    case $1 in
    terrain) scene 1M floor '{ "type": "sphere", "center": [0, 0.6, 0], "radius": 0.6, "material": "mirror" }' terrain ;;
    tour) echo "$source/scenes/tour/27-antialiased-reflections.json" ;;
    first) echo "$source/scenes/first-render.json" ;;
    *) scene "${1#*-}" "${1%-*}" ;;
    esac
}

# A line for each scene and kind: by depth the time of the render's way over that of single rays, and single rays'
# nanoseconds. Columns of the CSV: 3 the tracer, 7 the set, 10 its rays, 13 million rays a second.
echo "| scene | kind |$(seq "$deepest" | sed 's/.*/ & |/' | tr -d '\n')"
echo "|---|---|$(seq "$deepest" | sed 's/.*/---|/' | tr -d '\n')"
for name in ${SCENES:-mirror-360k mirror-2M glass-360k glass-2M terrain tour first}; do
    "$fathom" bench trace "$(file_of "$name")" --of-render --tracer embree --tracer bare:embree:1 --rays "$rays" \
        --repeats "$repeats" --quiet --csv "$folder/result.csv"
    awk -F, -v name="$name" -v deepest="$deepest" '
        /^#/ || $1 == "triangles" || $10 < 2000 { next }
        { split($7, set, " "); depth = set[1]; kind = set[2] }
        depth < 1 || depth > deepest { next }
        $3 == "embree" { own[kind, depth] = $13; next }
        !seen[kind]++ { kinds[++count] = kind }
        { cell[kind, depth] = sprintf("%.2f of %.0f", $13 / own[kind, depth], 1000 / $13) }
        END {
            for (k = 1; k <= count; ++k) {
                printf "| %s | %s |", name, kinds[k]
                for (d = 1; d <= deepest; ++d) printf " %s |", cell[kinds[k], d]
                print ""
            }
        }' "$folder/result.csv"
done
