#!/bin/sh
# Fuzzes the readers of files and of the command line with libFuzzer, under AddressSanitizer and
# UndefinedBehaviorSanitizer. Installs what is missing; exit code 1 when something was found.
# usage: sh tests/fuzz.sh [SECONDS] [TARGET…]     (default: 10 seconds each of all targets)
#        sh tests/fuzz.sh coverage [TARGET…]      lines of src/ that all inputs so far reach
# The build and all inputs that reach something new are kept in build/fuzz, or $FATHOM_BUILD/fuzz: further runs go
# on from there. Findings are in build/fuzz/findings; run the program on such a file to see it again.
set -eu
cd "$(dirname "$0")/.."
source=$(pwd)
build=${FATHOM_BUILD:-$source/build}/fuzz
jobs=$(nproc)

seconds=10
[ $# -gt 0 ] && { seconds=$1; shift; }
case $seconds in
coverage) build=$build-coverage ;;
*[!0-9]* | "") echo "usage: sh tests/fuzz.sh [SECONDS|coverage] [TARGET…]" >&2; exit 2 ;;
esac
all=$(cd tests/fuzz/corpus && echo *)
[ $# -gt 0 ] || set -- $all
for target; do
    [ -d "tests/fuzz/corpus/$target" ] || { echo "fathom fuzz: there is no target $target; there are: $all" >&2; exit 2; }
done

sh tests/packages.sh clang

flags=""
[ "$seconds" != coverage ] || flags="-fprofile-instr-generate -fcoverage-mapping"
mkdir -p "$build"
# CC and CXX count for a new build alone. An option that finds another compiler, such as ccache's, than the last run did
# makes CMake forget FATHOM_FUZZ.
echo "== fuzz: building in $build"
{
    CC=clang CXX=clang++ cmake -S "$source" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DFATHOM_FUZZ=ON \
        -DFATHOM_WERROR=ON -DCMAKE_C_FLAGS="$flags" &&
        cmake --build "$build" --target fuzz -j "$jobs"
} >"$build/build.log" 2>&1 ||
    { grep -A 12 -E 'rror|FAILED' "$build/build.log" >&2; echo "fathom fuzz: the build failed" >&2; exit 1; }

# Quarantine: what is freed is kept for so long that a use of it is seen, and no longer, which would take time.
# Who allocated is noted by one caller alone, for the same reason; a finding that is run again shows them all.
export ASAN_OPTIONS=quarantine_size_mb=16:malloc_context_size=1
# libFuzzer's own limit of time is a net for what never ends: it goes by the clock, which a busy machine also spends
# elsewhere. The targets limit an execution to a second of the processor's, and memory by the input's size.
limits="-timeout=600 -rss_limit_mb=2048 -malloc_limit_mb=256"

max_length() { # target
    case $1 in
    command_line) echo 512 ;;
    rays) echo 1024 ;;
    *) echo 4096 ;;
    esac
}

# The words of a format: its keys, from its schema or its reader, and those of dictionaries.
dictionary() { # target
    keys=/dev/null lists=$1
    case $1 in
    scene_json) keys=scenes/fathom.schema.json ;;
    gltf) keys=src/read/gltf ;;
    glb) keys=src/read/gltf lists='gltf glb' ;;
    wire) lists=reply ;;
    esac
    for list in $lists; do cat "tests/fuzz/dictionaries/$list.dict"; done
    grep -rohE '"[A-Za-z0-9_$]+"' $keys | sort -u | sed 's/"\(.*\)"/"\\x22\1\\x22"\n"\\x22\1\\x22:"/'
}

# The large inputs of tests/fuzz/large.py, which not every target has, once; then as long as asked for from the corpus on.
fuzz() { # target
    found=$build/found/$1
    mkdir -p "$found" "$build/findings" "$build/seeds/$1"
    printf '%-14s %12s %8s  %s\n' "$1" - - LARGE >"$build/$1.row"
    # shellcheck disable=SC2086 # limits are words
    [ ! -d "$build/large/$1" ] || "$build/fuzz/fuzz_$1" $limits -artifact_prefix="$build/findings/$1-" "$build/large/$1"/* >"$build/$1.log" 2>&1 || return 0
    dictionary "$1" >"$build/$1.dict"
    # shellcheck disable=SC2086
    "$build/fuzz/fuzz_$1" -max_total_time="$seconds" -max_len="$(max_length "$1")" $limits -print_final_stats=1 \
        -dict="$build/$1.dict" -artifact_prefix="$build/findings/$1-" \
        "$found" "$source/tests/fuzz/corpus/$1" "$build/seeds/$1" >"$build/$1.log" 2>&1 && result=fine || result=FOUND
    executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$build/$1.log")
    edges=$(grep -o 'cov: [0-9]*' "$build/$1.log" | tail -n 1 | cut -c 6-)
    most=$(sed -n 's/^fuzz: \(most memory [0-9]* bytes for [0-9]*\).*\(most time .*\)/\1, \2/p' "$build/$1.log")
    printf '%-14s %12s %8s  %-6s %s\n' "$1" "$executions" "$edges" $result "$most" >"$build/$1.row"
}

coverage() { # target
    LLVM_PROFILE_FILE=$build/$1.profraw "$build/fuzz/fuzz_$1" -runs=0 "$source/tests/fuzz/corpus/$1" \
        $([ -d "${build%-coverage}/found/$1" ] && echo "${build%-coverage}/found/$1") >"$build/$1.log" 2>&1
    llvm-profdata merge -sparse "$build/$1.profraw" -o "$build/$1.profdata"
    llvm-cov export -summary-only -instr-profile "$build/$1.profdata" "$build/fuzz/fuzz_$1" >"$build/$1.json"
}

if [ "$seconds" = coverage ]; then
    for target; do coverage "$target"; done
    python3 tests/fuzz/coverage.py "$build" "$@"
    exit 0
fi

python3 tests/fuzz/large.py "$build/large"
# glTF has two forms, and what one target found is a start for the other.
mkdir -p "$build/found/gltf"
python3 tests/fuzz/glb.py "$build/seeds/glb" tests/fuzz/corpus/gltf "$build/found/gltf"
running=0
for target; do
    fuzz "$target" &
    running=$((running + 1))
    [ $((running % jobs)) -ne 0 ] || wait
done
wait
printf '%-14s %12s %8s  %-6s %s\n' target executions edges result "most of what one took"
code=0
for target; do
    cat "$build/$target.row"
    grep -q ' fine ' "$build/$target.row" || { code=1; grep -E '^fuzz: |SUMMARY|Test unit written' "$build/$target.log"; }
done
exit $code
