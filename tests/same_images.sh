#!/bin/sh
# Shows that two builds render the same images, to the last bit of every channel.
# usage: sh tests/same_images.sh OLD NEW [FOLDER]     OLD and NEW are `fathom` programs; FOLDER keeps the images
# Renders the tour, the example, the first render and the variations below with both programs and compares each
# pair with tolerance 0. Both render by the integrator classic, whose name an old program may not know. Colours are
# written as 32-bit floats, so that no rounding hides a difference.
# Exit code 0: all images agree. 1: some differ; their names are printed.
set -eu
[ $# -ge 2 ] || { sed -n '2,6p' "$0" >&2; exit 2; }
cd "$(dirname "$0")/.."
old=$1
new=$2
work=${3:-$(mktemp -d)}
[ $# -ge 3 ] || trap 'rm -rf "$work"' EXIT
mkdir -p "$work/old" "$work/new"
total=0
differing=""

"$new" generate sphere --triangles 40k -o "$work/sphere.glb" --quiet
"$new" generate forest --triangles 60k -o "$work/forest.glb" --quiet
"$new" generate terrain --triangles 20k -o "$work/terrain.ply" --quiet

compare() { # name extension: the pair of images that both programs made
    total=$((total + 1))
    "$new" compare "$work/old/$1.$2" "$work/new/$1.$2" >"$work/$1.difference" 2>&1 && return
    differing="$differing $1.$2"
    echo "$1.$2: $(cat "$work/$1.difference")"
}

# The scenes as a program reads them: an old one knows no integrators.
cp -r scenes "$work/scenes"
classic="--integrator classic"
"$old" help render | grep -q -e --integrator && old_classic=$classic || old_classic=
[ -n "$old_classic" ] || find "$work/scenes" -name '*.json' -exec sed -i 's/"integrator": "classic", //' {} +

# which arguments…: renders by the integrator classic.
rendered() {
    if [ "$1" = old ]; then program=$old scenes=$work/scenes by=$old_classic; else program=$new scenes=scenes by=$classic; fi
    scene=$2
    shift 2
    case $scene in scenes/*) scene=$scenes/${scene#scenes/} ;; esac
    # $by is two words or none.
    # shellcheck disable=SC2086
    $limit "$program" render "$scene" $by "$@"
}

# name extension scene options…: renders with both programs. A program's messages go to a file next to its image.
try() {
    name=$1 extension=$2
    shift 2
    for which in old new; do
        limit= rendered $which "$@" -o "$work/$which/$name.$extension" --quiet 2>"$work/$which/$name.log" ||
            echo "$name: the $which program ended with code $?: $(tail -n 1 "$work/$which/$name.log")"
    done
    compare "$name" "$extension"
}
exr() { # name scene options…
    name=$1
    shift
    try "$name" exr "$@" --exr-float
}

# name scene options…: stopped after part of a second and continued, as often as it takes.
resumed() {
    name=$1
    shift
    for which in old new; do
        part="$work/$which/$name.part"
        code=5
        while [ "$code" = 5 ] || [ "$code" = 130 ]; do # 130: stopped before it listened
            code=0
            limit="timeout --preserve-status -s INT 0.4" rendered $which "$@" --exr-float --quiet -o "$work/$which/$name.exr" \
                --checkpoint "$part" --resume 2>"$work/$which/$name.log" || code=$?
        done
        [ "$code" = 0 ] || echo "$name: the $which program ended with code $code: $(tail -n 1 "$work/$which/$name.log")"
    done
    compare "$name" exr
}

tour() {
    for scene in scenes/tour/*.json; do
        exr "tour-$(basename "$scene" .json)" "$scene" --aov all
    done
    exr example scenes/example.json --aov all
    exr first-render scenes/classic.json --size 480x270 --spp 4
}

# Patterns, outputs, crops, threads and tile sizes.
sampling() {
    example=scenes/example.json
    exr grid "$example" --size 200x150 --spp 9 --pattern grid
    exr stratified "$example" --size 200x150 --spp 9 --pattern stratified --seed 7
    exr sobol "$example" --size 200x150 --spp 7 --pattern sobol --seed 7
    exr one-sample "$example" --size 333x217 --spp 1
    for aov in alpha Z N P albedo id samples direct indirect emission lightGroups cryptoObject cryptoMaterial; do exr "aov-$aov" "$example" --size 160x120 --spp 4 --aov $aov; done
    exr crop "$example" --size 400x300 --spp 4 --crop 101,57,333,222 --aov all
    exr crop-one-pixel "$example" --size 400x300 --spp 4 --crop 200,150,201,151
    exr wide-crop "$example" --size 400x300 --spp 2 --pattern sobol --crop 0,31,400,33
    for threads in 1 2 3; do exr "threads-$threads" "$example" --size 200x150 --spp 4 --threads $threads --aov all; done
    for width in 1 4 8; do exr "block-$width" "$example" --size 200x150 --spp 4 --block-width $width; done
    exr tiles "$example" --size 200x150 --spp 4 --tile-size 64
    exr error "$example" --size 200x150 --pattern sobol --target-error 0.02 --spp 64 --aov samples
    exr error-forest "$work/forest.glb" --size 200x150 --pattern sobol --target-error 0.05 --spp 32
    resumed resumed "$example" --size 240x180 --spp 64
    resumed resumed-error "$example" --size 240x180 --pattern sobol --target-error 0.005 --spp 256
}

# Light and geometry.
transport() {
    first=scenes/classic.json
    for depth in 0 1 3 64; do exr "depth-$depth" "$first" --size 160x90 --max-depth $depth; done
    exr loss-8bit "$first" --size 160x90 --spp 4 --leave-out-below 8bit
    exr loss-half "$first" --size 160x90 --spp 4 --leave-out-below half
    exr epsilon scenes/tour/17-smooth-normals.json --epsilon 1e-4
    exr facets scenes/tour/17-smooth-normals.json --no-terminator-fix
    exr background scenes/tour/11-mirror.json --background 0.2,0.5,1
    exr sphere "$work/sphere.glb" --size 320x240 --spp 4 --aov all
    exr forest "$work/forest.glb" --size 320x240 --spp 4 --aov all
    exr terrain "$work/terrain.ply" --size 320x240 --spp 4 --aov all
    exr small-tracer scenes/tour/11-mirror.json --tracer bvh
    exr reference scenes/tour/13-refraction.json --tracer reference --size 80x60
    exr reference-meshes scenes/tour/17-smooth-normals.json --tracer reference --size 80x60
    exr user-shapes "$first" --tracer embree:user --size 160x90
    exr raw scenes/tour/21-instances.json --tracer embree:raw
    exr compact "$work/forest.glb" --tracer embree:compact --size 160x120
}

# Each way from radiance to a display.
views() {
    example=scenes/example.json
    for extension in png jpg tif; do
        try "view" $extension "$example" --size 160x120 --spp 4
        try "exposed" $extension "$example" --size 160x120 --spp 4 --exposure 1.5
        try "raw-view" $extension "$example" --size 160x120 --spp 4 --view Raw
    done
    try covered png "$example" --size 160x120 --spp 4 --aov alpha
    try half exr "$example" --size 160x120 --spp 4 --aov all
}

tour
sampling
transport
views
echo "$((total - $(echo "$differing" | wc -w))) of $total images agree"
[ -z "$differing" ]
