#!/bin/sh
# Measures the cost of a part of the renderer: a scene that does without it, against the same view of a scene that needs it.
# usage: BUILD=build/release sh bench/leave_out.sh [REPEATS [INSTRUCTIONS]]
# Prints a table for bench/README.md: ratios of the render phase, one thread. The two scenes take turns; the table has the
# best times and the median of the rounds' ratios. Instructions are of a smaller image, by valgrind (whose processor has AVX2).
# INSTRUCTIONS=0 does without valgrind. TRIANGLES=20k SIZE=320x180 measure less.
set -eu
repeats=${1:-9}
instructions=${2:-1}
source=$(cd "$(dirname "$0")/.." && pwd)
fathom=$(cd "${BUILD:-$source/build/release}" && pwd)/bin/fathom
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# scene NAME LIGHTS OBJECTS: an open, faceted terrain of one Lambert material under one light, black around it.
scene() {
    cat >"$1.json" <<JSON
{ "image": { "width": 960, "height": 540 }, "background": [0, 0, 0], "ambient": [0, 0, 0],
  "camera": { "eye": [0.3, 1.1, 1.9], "target": [0, 0, 0], "fovy": 45 },
  "materials": { "m": { "kd": [0.6, 0.5, 0.4] } },
  "lights": [ { "type": "point", "position": [1.5, 2.5, 1], "intensity": 8 }$2 ],
  "objects": [ { "type": "mesh", "file": "terrain.glb", "shading": "flat", "material": "m" }$3 ] }
JSON
}

# lights COUNT INTENSITY: further lights.
lights() {
    awk -v n="$1" -v i="$2" 'BEGIN { for (k = 0; k < n; ++k)
        printf ", { \"type\": \"point\", \"position\": [%.3f, 2, %.3f], \"intensity\": %g }", cos(k), sin(k), i }'
}

"$fathom" generate terrain --triangles "${TRIANGLES:-200k}" -o terrain.glb -q
scene plain "" ""
# Shapes under the terrain, which nobody sees: each adds a geometry of its own kind to Embree's tree.
scene sphere "" ', { "type": "sphere", "center": [0, -0.6, 0], "radius": 0.01, "material": "m" }'
scene quad "" ', { "type": "quad", "center": [0, -0.6, 0], "u": [0.01, 0, 0], "v": [0, 0, 0.01], "material": "m" }'
scene plane "" ', { "type": "plane", "point": [0, -9, 0], "normal": [0, 1, 0], "material": "m" }'
# One corner of an open and of a closed tetrahedron there, and one that mirrors.
faces='[0, -9, 0], [1, -9, 0], [0, -9, 1], [0, -8, 0]], "indices": [[0, 1, 2], [0, 3, 1], [0, 2, 3]'
scene open "" ", { \"type\": \"mesh\", \"positions\": [$faces], \"material\": \"m\" }"
scene closed "" ", { \"type\": \"mesh\", \"positions\": [$faces, [1, 3, 2]], \"material\": \"m\" }"
sed 's/\("m": {[^}]*}\)/\1, "mirror": { "kr": [0.5, 0.5, 0.5] }/; s/\(.*\)"material": "m"/\1"material": "mirror"/' open.json >mirror.json
cp plain.json instance.json
sed -i 's/"shading": "flat"/"shading": "flat", "translation": [0, 1e-6, 0]/' instance.json
sed 's/"eye": [^]]*]/"eye": [0.3, 1.1, 9]/' plain.json >dark.json
sed 's/"background": \[0, 0, 0\]/"background": [1e-30, 0, 0]/' dark.json >sky.json
scene faint "$(lights 8 1e-5)" ""

# Each line: a name, the scene and options that do without it, the scene and options that need it.
cat >cases.txt <<'CASES'
nothing (the spread)|plain|plain
background|dark|sky
mirrored and refracted rays|open|mirror
buffers of AOVs|plain|plain --aov Z
watertight repair|open|closed
sphere geometry|plain|sphere
quad geometry|plain|quad
planes|plain|plane
instances|plain|instance
8 faint lights' shadow rays, 8 bit|faint --leave-out-below 8bit|faint
CASES

# render_seconds SCENE OPTION…
render_seconds() {
    name=$1
    shift
    "$fathom" render "$name.json" --integrator classic --size "${SIZE:-960x540}" --threads 1 -o out.exr --stats s.json -q "$@"
    sed -n '/"seconds"/,/}/s/^ *"render": \([-+.e0-9]*\),*$/\1/p' s.json
}

# The instructions of the render phase; the image is smaller. Earlier counts are remembered.
render_instructions() {
    if grep -qxF "$*" counted.txt; then
        grep -xF -A 1 "$*" counted.txt | tail -n 1
        return
    fi
    asked=$*
    name=$1
    shift
    valgrind --tool=callgrind --callgrind-out-file=calls.txt --collect-atstart=no --toggle-collect=run_tiles \
        "$fathom" render "$name.json" --integrator classic --size 160x90 --threads 1 -o out.exr -q "$@" >log.txt 2>&1
    count=$(sed -n 's/^totals: \([0-9]*\).*/\1/p' calls.txt)
    printf '%s\n%s\n' "$asked" "$count" >>counted.txt
    echo "$count"
}

for _ in $(seq "$repeats"); do
    while IFS='|' read -r what without with; do
        # shellcheck disable=SC2086
        left_out=$(render_seconds $without)
        # shellcheck disable=SC2086
        with_it=$(render_seconds $with)
        echo "$what|$left_out|$with_it"
    done <cases.txt
done >times.txt
: >counted.txt

echo "| what the scene does without | without, ms | with / without, best | median (quartiles) | instructions |"
echo "|---|---|---|---|---|"
while IFS='|' read -r what without with; do
    row=$(awk -F'|' -v what="$what" '$1 == what { print $3 / $2, $2, $3 }' times.txt | sort -n | awk '
        { r[NR] = $1; if (NR == 1 || $2 < a) a = $2; if (NR == 1 || $3 < b) b = $3 }
        END { if (!NR) { printf "| |"; exit } h = int((NR + 1) / 2); q = int((NR + 3) / 4)
              printf "%.1f | %.3f | %.3f (%.3f–%.3f)", 1000 * a, b / a, r[h], r[q], r[NR + 1 - q] }')
    ratio=
    if [ "$instructions" != 0 ]; then
        # shellcheck disable=SC2086
        left_out=$(render_instructions $without)
        # shellcheck disable=SC2086
        with_it=$(render_instructions $with)
        ratio=$(awk "BEGIN { printf \"%.3f\", $with_it / $left_out }")
    fi
    echo "| $what | $row | $ratio |"
done <cases.txt
