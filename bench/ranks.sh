#!/bin/sh
# Many processes on one image: the processor time of 2, 4 and 8 ranks, and of as many parts, over that of one process
# (the machine has fewer processors); and the efficiency of up to 1,024 ranks, simulated from the measured times
# of the tiles of one image.
# usage: BUILD=build/release sh bench/ranks.sh [SCENE [SPP [WIDTHxHEIGHT of the simulated image [its SPP]]]]
# (default scenes/light/cornell-box.json, 32, 1920x1080, 4)
set -eu
cd "$(dirname "$0")/.."
fathom=$(cd "${BUILD:-build/release}" && pwd)/bin/fathom
scene=${1:-scenes/light/cornell-box.json} spp=${2:-32} size=${3:-1920x1080} simulated=${4:-4}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
exec python3 -B bench/ranks.py "$fathom" "$scene" "$spp" "$size" "$simulated" "$folder"
