#!/bin/sh
# Which branches of src/ the tests take: a table by folder, a list of what is missed, and pages in HTML.
# usage: sh tests/coverage.sh [OUTPUT]     (default: build/coverage)
#        sh tests/coverage.sh OUTPUT [OPTION OF CTEST…]      some tests only, added to what was counted before
# clang counts in the source, before it optimises: what is counted does not depend on how fast the code is made.
set -eu
cd "$(dirname "$0")/.."
source=$(pwd)
mkdir -p "${1:-build/coverage}"
out=$(cd "${1:-build/coverage}" && pwd)
[ $# -eq 0 ] || shift
jobs=$(nproc)

sh tests/packages.sh clang
{
    cmake -S "$source" -B "$out/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DFATHOM_COVERAGE=ON \
        -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ &&
        cmake --build "$out/build" -j "$jobs"
} >"$out/build.log" 2>&1 || { grep -A 12 -E 'rror|FAILED' "$out/build.log" >&2; exit 1; }

# Every program adds its counts to a file of its own at its end.
[ $# -gt 0 ] || rm -rf "$out/counts"
mkdir -p "$out/counts"
failed=0
LLVM_PROFILE_FILE="$out/counts/%${jobs}m.profraw" \
    ctest --test-dir "$out/build" -j "$jobs" "$@" >"$out/tests.log" 2>&1 || failed=$?
tail -n 12 "$out/tests.log"

# A program that was killed while it wrote leaves counts that cannot be read.
llvm-profdata merge --sparse --failure-mode=all -o "$out/counts.profdata" "$out/counts"/*.profraw 2>"$out/merge.log"
counted() { # command of llvm-cov, options…
    command=$1
    shift
    llvm-cov "$command" "$out/build/bin/fathom" -object "$out/build/lib/libfathom.so" \
        -object "$out/build/lib/fathom/fathom_image.so" -instr-profile "$out/counts.profdata" "$@"
}
counted export >"$out/counts.json" 2>"$out/export.log"
python3 tests/coverage.py "$out/counts.json" "$source" "$out/missed.txt"
counted show -format=html -output-dir="$out/html" -show-branches=count -show-instantiations=false >"$out/show.log" 2>&1
echo "Details: $out/html/index.html, $out/missed.txt"
exit $failed
