#!/bin/sh
# How long a first image takes, against programs that do nothing else: BUILD=build/release sh bench/image_time.sh [REPEATS]
# `fathom render` of a GLB of 8 million triangles at 1280x720 and 1 spp to PNG, whole processes, against one that maps the
# file, builds and traces the same rays by nothing but Embree; and of 70,000 triangles against one that loads the image
# module. Sides take turns. Before each, memory is touched: a virtual machine may have to fetch it from its host first, which
# takes longer than all the rest. TRIANGLES=8M and QUALITIES="low medium" may be set.
set -eu
source=$(cd "$(dirname "$0")/.." && pwd)
build=$(cd "${BUILD:-$source/build/release}" && pwd)
fathom=$build/bin/fathom
bare=$build/tests/bench_image_time
module=$build/lib/fathom/fathom_image.so
repeats=${1:-7}
triangles=${TRIANGLES:-8M}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
now() { date +%s%N; }

# timed NAME COMMAND…: microseconds to $folder/NAME.
timed() {
    name=$1
    shift
    "$bare" touch
    begin=$(now)
    "$@" >>"$folder/out.txt"
    echo $((($(now) - begin) / 1000)) >>"$folder/$name"
}

# quartile FILE K: the K-th quartile in seconds.
quartile() { sort -n "$1" | awk -v k="$2" '{ t[NR] = $1 * 1e-6 } END { print t[1 + int((NR - 1) * k / 4 + 0.5)] }'; }

# rays MESH: camera and lights that `fathom render` gives to a bare model, as the arguments of bench_image_time.
rays() {
    "$fathom" info "$1" --json | awk '
        /"origin"|"direction"/ { list = $1 }
        /^ *-?[0-9.e-]+,?$/ && list { gsub(/,/, ""); v[list, n[list]++] = $1 }
        function light(right, up, back,  k) {
            printf " sun:"
            for (k = 0; k < 3; ++k) printf "%s%.9g", k ? "," : "", right * x[k] + up * y[k] + back * z[k]
        }
        END {
            o = "\"origin\":"; d = "\"direction\":"
            for (k = 0; k < 3; ++k) z[k] = -v[d, k]
            l = sqrt(z[0] * z[0] + z[2] * z[2])
            x[0] = z[2] / l; x[1] = 0; x[2] = -z[0] / l
            y[0] = z[1] * x[2]; y[1] = z[2] * x[0] - z[0] * x[2]; y[2] = -z[1] * x[0]
            printf "%.9g,%.9g,%.9g %.9g,%.9g,%.9g 45", v[o, 0], v[o, 1], v[o, 2], v[d, 0], v[d, 1], v[d, 2]
            light(-0.6, 0.9, 0.7); light(0.9, 0.25, 0.5)
        }'
}

"$fathom" generate sphere --triangles "$triangles" -o "$folder/heavy.glb" -q
"$fathom" generate sphere --triangles 70k -o "$folder/light.glb" -q
arguments=$(rays "$folder/heavy.glb")
for _ in $(seq "$repeats"); do
    timed fathom "$fathom" render "$folder/heavy.glb" --integrator classic -o "$folder/heavy.png" --spp 1 -q
    for quality in ${QUALITIES:-low}; do
        # shellcheck disable=SC2086
        timed "bare-$quality" "$bare" trace "$folder/heavy.glb" "$(nproc)" "$quality" robust $arguments
    done
    timed light "$fathom" render "$folder/light.glb" --integrator classic -o "$folder/light.png" --spp 1 -q
    timed load "$bare" load "$module"
done

row() { printf '| %s | %.3f (%.3f–%.3f) |' "$1" "$(quartile "$2" 2)" "$(quartile "$2" 1)" "$(quartile "$2" 3)"; }
echo "| whole process | seconds (quartiles) | beside the other |"
echo "|---|---|---|"
row "\`fathom render\`, $triangles triangles, to PNG" "$folder/fathom"
echo " |"
for quality in ${QUALITIES:-low}; do
    row "Embree alone, $quality quality, robust" "$folder/bare-$quality"
    awk -v a="$(quartile "$folder/fathom" 2)" -v b="$(quartile "$folder/bare-$quality" 2)" 'BEGIN { printf " %.3f times |\n", a / b }'
done
row "\`fathom render\`, 70 k triangles, to PNG" "$folder/light"
echo " |"
row "loading the image module" "$folder/load"
awk -v a="$(quartile "$folder/light" 2)" -v b="$(quartile "$folder/load" 2)" 'BEGIN { printf " %+.3f s |\n", a - b }'
grep '^read' "$folder/out.txt" | sort | uniq -c | tail -n 1
