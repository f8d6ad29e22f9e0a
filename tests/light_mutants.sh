#!/bin/sh
# Plants one fault of light transport at a time into a copy of the sources, and has `fathom validate --light` find it. Takes
# some 20 minutes on two cores, building included; prints a line for each, and exits with 1 when a fault is not found.
# usage: sh tests/light_mutants.sh FOLDER [all] [TEXT]
#   FOLDER  where the copy and its build go; kept, so that a second run builds faster
#   all     asks every law, not only those that are named with the fault
#   TEXT    only faults whose names hold it
set -eu
cd "$(dirname "$0")/.."
python=${PYTHON:-python3}
[ $# -ge 1 ] || { sed -n 2,8p "$0"; exit 2; }
mkdir -p "$1"
copy=$(cd "$1" && pwd)/copy
shift
laws=named
[ "${1:-}" != all ] || { laws=all; shift; }
only=${1:-}
mkdir -p "$copy"
for part in CMakeLists.txt LICENSE README.md include src scenes tests bench third_party_notes; do
    # Files that did not change keep their times: a second run builds what the last fault touched.
    cp -pRu "$part" "$copy/"
done
cd "$copy"
launcher=
[ -z "$(command -v ccache)" ] || launcher=-DCMAKE_C_COMPILER_LAUNCHER=ccache
cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release $launcher >build.log
exec "$python" -B tests/light_mutants.py build "$laws" "$only"
