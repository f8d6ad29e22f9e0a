#!/bin/sh
# How long a user waits: for help, for an interrupted render to end, for the first image.
# usage: BUILD=build/release sh bench/start.sh [REPEATS]
set -eu
cd "$(dirname "$0")/.."
fathom=$(cd "${BUILD:-build/release}" && pwd)/bin/fathom
repeats=${1:-9}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
now() { date +%s%N; }

# measure NAME COMMAND…: minimum, median and maximum in milliseconds.
measure() {
    name=$1
    shift
    for _ in $(seq "$repeats"); do
        begin=$(now)
        "$@" >"$folder/out.txt" 2>&1 || true
        echo $((($(now) - begin) / 1000))
    done | sort -n | awk -v name="$name" '{ t[NR] = $1 / 1000 }
        END { printf "%-34s min %8.1f  median %8.1f  max %8.1f ms\n", name, t[1], t[int((NR + 1) / 2)], t[NR] }'
}

# From the signal to the end of the process, with the images written.
interrupted() {
    env --default-signal=INT "$fathom" render "$folder/m.glb" --integrator classic --spp 65536 -o "$folder/i.exr" -o "$folder/i.png" "$@" \
        >"$folder/out.txt" 2>&1 &
    sleep 2
    begin=$(now)
    kill -INT $!
    wait $! || true
    echo $((($(now) - begin) / 1000000))
}

"$fathom" generate sphere --triangles 70000 -o "$folder/m.glb" >"$folder/out.txt"
measure "help" "$fathom" help
measure "70 k triangles, 1 spp, to PNG" "$fathom" render "$folder/m.glb" --integrator classic -o "$folder/o.png" --spp 1 --quiet
measure "70 k triangles, 1 spp, to EXR" "$fathom" render "$folder/m.glb" --integrator classic -o "$folder/o.exr" --spp 1 --quiet
echo "interrupted, to EXR and PNG: $(interrupted) ms, $(interrupted) ms, $(interrupted) ms"
echo "interrupted, linear search:  $(interrupted --tracer reference) ms, $(interrupted --tracer reference) ms"
