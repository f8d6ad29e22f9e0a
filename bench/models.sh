#!/bin/sh
# Renders the models that Debian's packages hold, and lists those that are refused, with the message.
# usage: BUILD=build/release sh bench/models.sh [FOLDER]        keeps downloads (2 GB) and images in FOLDER
set -eu
cd "$(dirname "$0")/.."
fathom=$(cd "${BUILD:-build/release}" && pwd)/bin/fathom
folder=${1:-$(mktemp -d)}
mkdir -p "$folder/packages" "$folder/images"
cd "$folder"

for package in assimp-testmodels bouncy brutalchess castle-game-engine-doc cube2-data cura dustracing2d-data embree-tools \
    glmark2-data gltron lazpaint-qt5 libmujoco-samples libsimbody-dev linuxcnc-uspace mayavi2 minetest-data \
    minetest-mod-3d-armor minetest-mod-basic-materials minetest-mod-homedecor minetest-mod-mesecons \
    minetest-mod-moreblocks minetest-mod-pipeworks neverball-common octave-matgeom opencv-doc openfoam-examples \
    performous psychtoolbox-3-common python-kivy-examples python3-pyglet python3-tinyobjloader qt3d5-examples \
    qtdatavisualization5-examples redeclipse-data spring-common stellarium-data structure-synth sumo-tools \
    uranium-plugins; do
    [ -d "packages/$package" ] && continue
    apt-get download "$package" >/dev/null 2>&1 || { echo "$package cannot be downloaded" >&2; continue; }
    dpkg-deb -x "$package"_*.deb "packages/$package"
    rm "$package"_*.deb
done

find packages/*/ -type f | grep -iE '\.(gltf|glb|obj|ply)$' | sort >models
: >refused
number=0
while read -r model; do
    number=$((number + 1))
    "$fathom" render "$model" --size 200x150 --spp 4 --quiet -o "images/$number.png" >message 2>&1 ||
        grep -v warning message >>refused
done <models
cat refused
echo "$(wc -l <models) models, $(wc -l <refused) refused; the images are $folder/images/LINE.png, by the lines of $folder/models"
