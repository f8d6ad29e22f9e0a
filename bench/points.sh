#!/bin/sh
# Clouds of points as spheres: sh bench/points.sh [COUNT...]
# Prints the table for bench/README.md. BUILD is a release build (default: build/release), BEFORE another program to run in turns
# with it; RUNS of each (default: 3). Needs python3 with numpy.
set -eu
[ $# -gt 0 ] || set -- 1000000 10000000
source=$(cd "$(dirname "$0")/.." && pwd)
build=${BUILD:-$source/build/release}
folder=$(mktemp -d "${TMPDIR:-/tmp}/fathom-bench-points-XXXXXX")
trap 'rm -rf "$folder"' EXIT

# Coloured points at random on a bumpy sphere.
make_cloud() {
    python3 - "$1" "$2" <<'END'
import sys
import numpy
count = int(sys.argv[1])
normal = numpy.random.default_rng(1).normal(size=(count, 3))
normal /= numpy.linalg.norm(normal, axis=1)[:, None]
rows = numpy.zeros(count, dtype=[("xyz", "<f4", 3), ("rgb", "u1", 3)])
rows["xyz"] = normal * (1 + 0.1 * numpy.sin(5 * normal[:, 0]) * numpy.cos(7 * normal[:, 1]))[:, None]
rows["rgb"] = 127 * (normal + 1)
names = [("float", name) for name in "xyz"] + [("uchar", name) for name in ("red", "green", "blue")]
header = f"ply\nformat binary_little_endian 1.0\nelement vertex {count}\n"
header += "".join(f"property {kind} {name}\n" for kind, name in names) + "end_header\n"
with open(sys.argv[2], "wb") as out:
    out.write(header.encode() + rows.tobytes())
END
}

# Medians of the runs.
print_row() {
    python3 - "$@" <<'END'
import json
import statistics
import sys
program, count, *files = sys.argv[1:]
runs = [json.load(open(name)) for name in files]
middle = lambda of: statistics.median(map(of, runs))
seconds = [middle(lambda r: r["seconds"][phase]) for phase in ("read", "build", "render")]
bytes_held = [middle(lambda r: r["memory"][key]) / 1e6 for key in ("meshBytes", "bvhBytes", "peakBytes")]
print(f"|{int(count):,}|{program}|" + " / ".join(f"{s:.2f}" for s in seconds) + " s|"
      + " / ".join(f"{b:.0f}" for b in bytes_held) + " MB|")
END
}

echo '|points|program|read / build / render|mesh / tree / peak|'
echo '|---|---|---|---|'
for count in "$@"; do
    make_cloud "$count" "$folder/cloud.ply"
    run=0
    while [ $run -lt "${RUNS:-3}" ]; do
        run=$((run + 1))
        for program in "$build/bin/fathom" ${BEFORE:+"$BEFORE"}; do
            name=after
            [ "$program" = "$build/bin/fathom" ] || name=before
            "$program" render "$folder/cloud.ply" -o "$folder/cloud.png" --spp 16 --quiet \
                --stats "$folder/$name$run.json" 2>"$folder/err.txt" ||
                { cat "$folder/err.txt" >&2; exit 1; }
        done
    done
    print_row after "$count" "$folder"/after*.json
    [ -z "${BEFORE:-}" ] || print_row before "$count" "$folder"/before*.json
    rm "$folder"/*.json
done
