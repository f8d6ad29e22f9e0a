#!/bin/sh
# What each part of the renderer costs where the scene does without it: kept, against left out.
# usage: BUILD=build/release sh bench/leave_out.sh [REPEATS [INSTRUCTIONS]]
# Prints a table for bench/README.md: ratios of the render phase, one thread. The two sides take turns; best of all times,
# and the median of the rounds' ratios. Instructions are of a smaller image, by valgrind (whose processor has AVX2). INSTRUCTIONS=0 does without valgrind. TRIANGLES=20k SIZE=320x180 measure less.
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
# What nobody sees, under the terrain: a geometry of its own kind in Embree's tree.
scene sphere "" ', { "type": "sphere", "center": [0, -0.6, 0], "radius": 0.01, "material": "m" }'
scene quad "" ', { "type": "quad", "center": [0, -0.6, 0], "u": [0.01, 0, 0], "v": [0, 0, 0.01], "material": "m" }'
scene plane "" ', { "type": "plane", "point": [0, -9, 0], "normal": [0, 1, 0], "material": "m" }'
cp plain.json instance.json
sed -i 's/"shading": "flat"/"shading": "flat", "translation": [0, 1e-6, 0]/' instance.json
sed 's/"position": \[1.5, 2.5, 1\]/"position": [1.5, 0.2, 0]/' plain.json >low.json
sed 's/"eye": [^]]*]/"eye": [0.3, 1.1, 9]/' plain.json >sky.json
scene aside ', { "type": "spot", "position": [0, 5, 0], "direction": [0, 1, 0], "intensity": 9, "outerAngle": 30 }' ""
scene faint "$(lights 8 1e-5)" ""

# Each line: a name, the scene and options without, the scene and options with.
cat >cases.txt <<'CASES'
nothing (the spread)|plain|plain
shading normals|plain|plain --keep normals
highlights|plain|plain --keep highlights
ambient and emitted light|plain|plain --keep glow
background|sky|sky --keep background
mirrored and refracted rays|plain|plain --keep bounces
buffers of AOVs|plain|plain --keep hits
watertight repair|plain|plain --keep repair
shadow rays for nothing|low|low --keep unlit
all of these|plain|plain --keep all
sphere geometry|plain|sphere
quad geometry|plain|quad
planes|plain|plane
instances|plain|instance
a light that points aside|aside|aside --keep lights
8 faint lights' shadow rays, 8 bit|faint --leave-out-below 8bit|faint
CASES

# render_seconds SCENE OPTION…
render_seconds() {
    name=$1
    shift
    "$fathom" render "$name.json" --size "${SIZE:-960x540}" --threads 1 -o out.exr --stats s.json -q "$@"
    sed -n '/"seconds"/,/}/s/^ *"render": \([-+.e0-9]*\),*$/\1/p' s.json
}

# The instructions of the render phase; the image is smaller. What was counted before is remembered.
render_instructions() {
    if grep -qxF "$*" counted.txt; then
        grep -xF -A 1 "$*" counted.txt | tail -n 1
        return
    fi
    asked=$*
    name=$1
    shift
    valgrind --tool=callgrind --callgrind-out-file=calls.txt --collect-atstart=no --toggle-collect=run_tiles \
        "$fathom" render "$name.json" --size 160x90 --threads 1 -o out.exr -q "$@" >log.txt 2>&1
    count=$(sed -n 's/^totals: \([0-9]*\).*/\1/p' calls.txt)
    printf '%s\n%s\n' "$asked" "$count" >>counted.txt
    echo "$count"
}

for _ in $(seq "$repeats"); do
    while IFS='|' read -r what without with; do
        # shellcheck disable=SC2086
        left_out=$(render_seconds $without)
        # shellcheck disable=SC2086
        kept=$(render_seconds $with)
        echo "$what|$left_out|$kept"
    done <cases.txt
done >times.txt
: >counted.txt

echo "| what the scene does without | left out, ms | kept / left out, best | median (quartiles) | instructions |"
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
        kept=$(render_instructions $with)
        ratio=$(awk "BEGIN { printf \"%.3f\", $kept / $left_out }")
    fi
    echo "| $what | $row | $ratio |"
done <cases.txt
