#!/bin/sh
# The same small glTF scenes by Fathom and by Blender's Cycles: sh bench/fidelity.sh [FOLDER [SPP]]
# Prints the table of bench/fidelity.md and writes FOLDER/sheet.png (default: a folder of its own). BUILD is a release
# build (default: build/release). ONLY=ours keeps what Blender has rendered. Needs blender, python3-numpy, python3-openimageio.
set -eu
source=$(cd "$(dirname "$0")/.." && pwd)
program=${BUILD:-$source/build/release}/bin/fathom
folder=${1:-$(mktemp -d)}
spp=${2:-64}
seeds='1 2 3 4'
mkdir -p "$folder/scenes" "$folder/ours" "$folder/theirs"
python=/usr/bin/python3
"$python" "$source/bench/fidelity/scenes.py" "$folder/scenes"
rm -f "$folder/ours/"*.exr

# Name, file, size, background and options of each scene, by tabs.
"$python" -c 'import json, sys
for s in json.load(open(sys.argv[1])):
    print(s["name"], s["file"], "%dx%d" % tuple(s["size"]), ",".join(map(str, s["background"])), *s["options"],
          sep="\t")' \
    "$folder/scenes/scenes.json" >"$folder/list"
tab=$(printf '\t')
while IFS=$tab read -r name file size background options; do
    for seed in $seeds; do
        # shellcheck disable=SC2086 # several options
        "$program" render "$file" -o "$folder/ours/$name-$seed.exr" --exr-float --size "$size" --spp "$spp" \
            --background "$background" --seed "$seed" --quiet $options
    done
done <"$folder/list"
# shellcheck disable=SC2086 # several seeds
[ "${ONLY:-}" = ours ] || blender -b --factory-startup -P "$source/bench/peers/gltf.py" -- \
    "$folder/scenes/scenes.json" "$folder/theirs" "$spp" $seeds >"$folder/blender.log" 2>&1 ||
    { tail -5 "$folder/blender.log" >&2; exit 1; }
# shellcheck disable=SC2086
"$python" "$source/bench/fidelity/compare.py" "$folder/scenes/scenes.json" "$folder/ours" "$folder/theirs" \
    "$folder/sheet.png" $seeds
echo "$folder/sheet.png"
