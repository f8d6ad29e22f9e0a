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
# Known bad ends in others' code, which cannot be mended here: the dynamic loader leaves with code 127 and a word of
# its own where it lacks memory halfway, as for a thread's destructors or thread-local data.
try_known() {
    name=$1
    shift
    try "$name" -k TLS -k thread-local -k 'exit code 127' "$@"
}
lib=$faults/oom.so
small="--size 16x12 -q"
# shellcheck disable=SC2086
for tracer in embree reference bvh; do
    try_known "render scene.json, $tracer, exr" -x ld-linux -c "$fathom" -o a.exr \
        $lib "$fathom" render scene.json -o a.exr $small --tracer $tracer
done
# shellcheck disable=SC2086
{
    try_known 'render scene.json, png' -r good.exr -x ld-linux -c "$fathom" -o a.png $lib "$fathom" render scene.json -o a.png $small
    try_known 'render scene.json, exr, while libraries are loaded' -i ld-linux -c "$fathom" -o a.exr \
        $lib "$fathom" render scene.json -o a.exr $small
    try_known 'render scene.json, exr, all later requests fail' -a -x ld-linux -c "$fathom" -o a.exr \
        $lib "$fathom" render scene.json -o a.exr $small
    for kind in glb obj ply; do
        # Loading libraries and writing EXR were tried above.
        try_known "render ball.$kind, exr" -x ld-linux -c "$fathom" -o a.exr \
            $lib "$fathom" render ball.$kind --integrator classic -o a.exr $small
        try "info ball.$kind" -t $lib "$fathom" info ball.$kind
        try "info ball.$kind, every request" -n -t $lib "$fathom" info ball.$kind
    done
    try 'info scene.json --json' -t $lib "$fathom" info scene.json --json
    try 'info scene.json, all later requests fail' -a -n -t $lib "$fathom" info scene.json
    try_known 'compare' -x ld-linux -t $lib "$fathom" compare good.exr good.exr
    try 'validate' -w v.json $lib "$fathom" validate scene.json --rays 3 -q --json v.json
    # glibc 2.36 follows the mark of an error that it could not keep, where libraries load others: elf/dlerror.c.
    try 'validate, all later requests fail' -a -k libtbbmalloc -w v.json $lib "$fathom" validate scene.json --rays 3 -q --json v.json
    try 'bench trace' -w b.json $lib "$fathom" bench trace ball.ply --rays 64 --json b.json
    try 'generate' -o g.glb $lib "$fathom" generate forest -t 3k -o g.glb --quiet
}
[ $fine = yes ] || { cat bad.txt >&2; exit 1; }
