#!/bin/sh
# Has memory run out at every place in turn, all libraries' included, over small scenes of each format: see
# tests/README.md for what came of it. Takes about an hour a core; prints one line for each command.
# usage: sh tests/oom.sh [BUILD] [PART/OF]     (default: build/release, all; 0/4 to 3/4 are quarters)
set -eu
cd "$(dirname "$0")/.."
build=$(cd "${1:-build/release}" && pwd)
part=${2:-0/1}
faults=$build/tests/faults
fathom=$build/bin/fathom
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cp scenes/tour/11-mirror.json "$place/scene.json"
cd "$place"
for kind in glb obj ply; do "$fathom" generate sphere -t 100 -o ball.$kind --quiet; done
"$fathom" render scene.json -o good.exr --size 16x12 -q
fine=yes
: >bad.txt
try() {
    name=$1
    shift
    printf '%s: ' "$name"
    "$faults/each" -s "$part" -l bad.txt "$@" || fine=no
}
# What ends badly in others' code, and cannot be helped from here: OpenImageIO's tables of strings, the C library where
# it notes a thread's destructor for them or makes room for their thread-local data.
known="-k libOpenImageIO_Util -k TLS -k thread-local"
lib=$faults/oom.so
small="--size 16x12 -q"
# shellcheck disable=SC2086
for tracer in embree reference bvh; do
    try "render scene.json, $tracer, exr" $known -x ld-linux -c "$fathom" -o a.exr \
        $lib "$fathom" render scene.json -o a.exr $small --tracer $tracer
done
# shellcheck disable=SC2086
{
    try 'render scene.json, png' $known -r good.exr -x ld-linux -c "$fathom" -o a.png $lib "$fathom" render scene.json -o a.png $small
    try 'render scene.json, exr, while libraries are loaded' $known -i ld-linux -c "$fathom" -o a.exr \
        $lib "$fathom" render scene.json -o a.exr $small
    try 'render scene.json, exr, all later requests fail' -a $known -x ld-linux -c "$fathom" -o a.exr \
        $lib "$fathom" render scene.json -o a.exr $small
    for kind in glb obj ply; do
        try "render ball.$kind, exr" $known -x fathom_image -c "$fathom" -o a.exr \
            $lib "$fathom" render ball.$kind -o a.exr $small
        try "info ball.$kind" -t $lib "$fathom" info ball.$kind
        try "info ball.$kind, every request" -n -t $lib "$fathom" info ball.$kind
    done
    try 'info scene.json --json' -t $lib "$fathom" info scene.json --json
    try 'info scene.json, all later requests fail' -a -n -t $lib "$fathom" info scene.json
    try 'compare' $known -x ld-linux -t $lib "$fathom" compare good.exr good.exr
    try 'validate' -w v.json $lib "$fathom" validate scene.json --rays 3 -q --json v.json
    try 'validate, all later requests fail' -a -w v.json $lib "$fathom" validate scene.json --rays 3 -q --json v.json
    try 'bench trace' -w b.json $lib "$fathom" bench trace ball.ply --rays 64 --json b.json
    try 'generate' -o g.glb $lib "$fathom" generate forest -t 3k -o g.glb --quiet
}
[ $fine = yes ] || { cat bad.txt >&2; exit 1; }
