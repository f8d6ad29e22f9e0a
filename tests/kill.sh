#!/bin/sh
# Kills renders at random moments, many of them while a checkpoint is written, and resumes them until they finish; so it
# does with parts of renders, which are merged then, and with ranks of a render by Open MPI where there is that. Each has to give the pixels of a render that nobody disturbed.
# Prints how often it hit what.
# usage: sh tests/kill.sh BUILD [KILLS [SEED]]     (default: 100 kills of either, seed 1)
set -eu
SOURCE=$(cd "$(dirname "$0")/.." && pwd)
BUILD=$(cd "$1" && pwd)
FATHOM=$BUILD/bin/fathom
count=${2:-100}
seed=${3:-1}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
. "$SOURCE/tests/cli/check.inc"
. "$SOURCE/tests/kill/kill.inc"
write_scene
even="--spp 1024 --aov all --exr-float"
error="--target-error 0.0005 --spp 4096 --aov all --exr-float"
# shellcheck disable=SC2086
survive $((count / 2)) "$seed" 1200 scene.json --size 160x120 $even
echo "the same samples everywhere: $kills kills, $writing while a file was written, $finished renders finished"
kills=0 writing=0 finished=0
# shellcheck disable=SC2086
survive $((count - count / 2)) $((seed + 1000)) 1200 scene.json --size 160x120 $error
echo "to an error:                 $kills kills, $writing while a file was written, $finished renders finished"
kills=0 finished=0
survive_parts $((count / 2)) $((seed + 2000)) samples scene.json --size 160x120 --spp 256 --aov all
echo "parts by samples:            $kills kills, $finished images merged"
kills=0 finished=0
survive_parts $((count - count / 2)) $((seed + 3000)) tiles scene.json --size 160x120 --target-error 0.004 --spp 1024 \
    --aov all
echo "parts by tiles, to an error: $kills kills, $finished images merged"
[ -e "$BUILD/lib/fathom/fathom_mpi.so" ] && command -v mpirun >/dev/null || exit 0
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
kills=0 finished=0
survive_ranks "$count" $((seed + 4000)) 1500 scene.json --size 160x120 --spp 1024 --aov all --exr-float
echo "ranks of Open MPI:           $kills kills, $finished images finished"
