#!/bin/sh
# Which branches of src/ the tests take: a table by folder, a list of what is missed, and a page in HTML.
# usage: sh tests/coverage.sh [OUTPUT]     (default: build/coverage)
# Hardly optimised, so that a branch is one of the source; takes half an hour and more.
set -eu
cd "$(dirname "$0")/.."
source=$(pwd)
mkdir -p "${1:-build/coverage}"
out=$(cd "${1:-build/coverage}" && pwd)
jobs=$(nproc)

sh tests/packages.sh coverage
cmake -S "$source" -B "$out/build" -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG="-Og -g" \
    -DCMAKE_CXX_FLAGS_DEBUG="-Og -g" -DFATHOM_COVERAGE=ON >"$out/build.log"
cmake --build "$out/build" -j "$jobs" >"$out/build.log" || { tail -n 30 "$out/build.log" >&2; exit 1; }
find "$out/build" -name '*.gcda' -delete
failed=0
FATHOM_SLOW=1 ctest --test-dir "$out/build" -j "$jobs" --timeout 1800 >"$out/tests.log" 2>&1 || failed=$?
tail -n 12 "$out/tests.log"
gcovr --root "$source" --filter "$source/src/" --object-directory "$out/build" --branches --exclude-throw-branches \
    --exclude-unreachable-branches --json-summary "$out/summary.json" --txt "$out/missed.txt" \
    --html-details "$out/index.html" "$out/build/src" >"$out/gcovr.log" 2>&1 || { tail "$out/gcovr.log" >&2; exit 1; }
python3 tests/coverage.py "$out/summary.json"
echo "Details: $out/index.html, $out/missed.txt"
exit $failed
