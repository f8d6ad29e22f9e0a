#!/bin/sh
# Path tracing against Blender's Cycles: the same scenes and depth, no denoiser, no clamp, no adaptive sampling.
# usage: BUILD=build/release sh bench/peers.sh [ROUNDS [SCENES]]     (default: 3, at least 2; "box sky house still")
# Needs Debian's package blender, and for "still", the still life as .glb, those of scenes/still-life.sh. Installs them as
# root.
# The time of a sample is that of the samples by which one render is longer than another, so that reading and building
# count in neither. The build of 8 M triangles takes Blender some 14 s, and varies by more than 16 samples take: under
# the sky the longer render has 256 samples more. The noise is that of two seeds: RMS difference / sqrt 2. Equal-error
# time is time × noise², as a ratio.
set -eu
cd "$(dirname "$0")/.."
[ "${1:-3}" -ge 2 ] || { echo "peers.sh: expected at least 2 rounds: the noise is that of two seeds" >&2; exit 2; }
program=$(cd "${BUILD:-build/release}" && pwd)/bin/fathom
rounds=${1:-3} scenes=${2:-box sky house still}
command -v blender >/dev/null || apt-get install -y --no-install-recommends blender
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
threads=$(nproc)

"$program" generate sphere --triangles 70k -o "$folder/body.ply" --quiet
"$program" generate terrain --triangles 8M -o "$folder/field.ply" --quiet
cat >"$folder/box.json" <<'JSON'
{ "image": { "integrator": "path", "width": 512, "height": 512, "spp": 64, "maxDepth": 12 },
  "camera": { "eye": [0, 0, 6.6], "target": [0, 0, 0], "fovy": 40 },
  "materials": { "white": { "kd": [0.73, 0.73, 0.73] }, "red": { "kd": [0.63, 0.06, 0.05] },
    "green": { "kd": [0.14, 0.45, 0.09] }, "lamp": { "kd": [0, 0, 0], "ke": [17, 12, 6.5] } },
  "objects": [ { "type": "mesh", "file": "body.ply", "material": "white" },
    { "type": "quad", "center": [0, -2, 0], "u": [2, 0, 0], "v": [0, 0, -2], "material": "white" },
    { "type": "quad", "center": [0, 2, 0], "u": [2, 0, 0], "v": [0, 0, 2], "material": "white" },
    { "type": "quad", "center": [0, 0, -2], "u": [2, 0, 0], "v": [0, 2, 0], "material": "white" },
    { "type": "quad", "center": [-2, 0, 0], "u": [0, 0, -2], "v": [0, 2, 0], "material": "red" },
    { "type": "quad", "center": [2, 0, 0], "u": [0, 0, 2], "v": [0, 2, 0], "material": "green" },
    { "type": "quad", "center": [0, 1.99, 0], "u": [0.6, 0, 0], "v": [0, 0, 0.6], "material": "lamp" } ] }
JSON
python3 bench/house.py 3 4 >"$folder/house.json"
case $scenes in *still*)
    sh tests/packages.sh scenes
    /usr/bin/python3 -B scenes/still-life/make.py "$folder/still-life"
    "$program" convert "$folder/still-life/still-life.json" "$folder/still.glb" --quiet 2>"$folder/lost"
    python3 - "$folder" <<'PYTHON' ;;
import json, sys
with open(sys.argv[1] + "/still-life/still-life.json") as file:
    scene = json.load(file)
camera = {key: scene["camera"][key] for key in ("eye", "target", "fovy")}
image = {"integrator": "path", "width": 480, "height": 270, "spp": 64, "maxDepth": 16}
with open(sys.argv[1] + "/still.json", "w") as file:
    json.dump({"image": image, "camera": camera, "background": scene["background"],
               "objects": [{"type": "mesh", "file": "still.glb"}]}, file)
PYTHON
esac
cat >"$folder/sky.json" <<'JSON'
{ "image": { "integrator": "path", "width": 960, "height": 540, "spp": 16, "maxDepth": 6 },
  "camera": { "eye": [0.9, 0.9, 0.5], "target": [0, 0, 0], "up": [0, 0, 1], "fovy": 40 },
  "background": [0.6, 0.8, 1],
  "materials": { "earth": { "kd": [0.4, 0.35, 0.3] } },
  "objects": [ { "type": "mesh", "file": "field.ply", "material": "earth" } ] }
JSON

ours() { # scene spp seed image: prints the seconds of rendering
    "$program" render "$folder/$1.json" --spp "$2" --seed "$3" -o "$folder/$4.exr" --exr-float --quiet \
        --stats "$folder/stats.json" && sed -n 's/.*"render": \([0-9.]*\).*/\1/p' "$folder/stats.json" | head -1
}
theirs() {
    blender -b --factory-startup -P bench/peers/cycles.py -- "$folder/$1.json" "$folder/$4.exr" "$2" "$3" "$threads" \
        2>&1 | sed -n 's/^seconds //p'
}
rms() { "$program" compare "$folder/$1.exr" "$folder/$2.exr" | sed -n 's/.*RMSE \([0-9.e+-]*\).*/\1/p' | head -1; }

echo "| scene | s a sample, Fathom | Cycles | ratio | noise, Fathom | Cycles | equal-error time, Fathom over Cycles | RMS between both |"
echo "|---|---|---|---|---|---|---|---|"
for scene in $scenes; do
    spp=$([ $scene = sky ] && echo 16 || echo 64) more=$([ $scene = sky ] && echo 256 || echo 64)
    : >"$folder/times"
    for round in $(seq "$rounds"); do
        printf '%s %s %s %s\n' "$(ours $scene $spp "$round" "a$round")" "$(ours $scene $((spp + more)) "$round" long)" \
            "$(theirs $scene $spp "$round" "b$round")" "$(theirs $scene $((spp + more)) "$round" long)" >>"$folder/times"
    done
    awk -v scene=$scene -v more=$more -v na="$(rms a1 a2)" -v nb="$(rms b1 b2)" -v both="$(rms a1 b1)" '
        { a[NR] = ($2 - $1) / more; b[NR] = ($4 - $3) / more }
        function median(x, i, j, t) {
            for (i = 1; i < NR; ++i) for (j = i + 1; j <= NR; ++j) if (x[j] < x[i]) { t = x[i]; x[i] = x[j]; x[j] = t }
            return x[int((NR + 1) / 2)] }
        END { s = median(a); t = median(b)
            printf "| %s | %.4f | %.4f | %.2f | %.4f | %.4f | %.2f | %.4f |\n", scene, s, t, s / t, na / sqrt(2),
                nb / sqrt(2), s / t * (na / nb) ^ 2, both }' "$folder/times"
done
