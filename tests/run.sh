#!/bin/sh
# Installs what is missing, builds, and runs all tests through CTest. Safe to run again.
# usage: sh tests/run.sh [release] [sanitize] [thread] [fuzz] [analyze] [sanitize-all] [thread-all]     (default: the first three)
#   release   optimised, warnings are errors, layout checked; then the tests labelled "isa" with plainer instruction sets
#   sanitize  AddressSanitizer and UndefinedBehaviorSanitizer, all tests but those labelled "release"
#   thread    ThreadSanitizer, the tests labelled "threads"
# These take longer and run by name alone:
#   fuzz      every reader with libFuzzer for ten seconds, from the corpus on: tests/fuzz.sh
#   analyze   clang's warnings, clang-tidy, cppcheck and gcc's -fanalyzer: tests/analyze.sh
#   sanitize-all   as sanitize, with the tests labelled "release": some five minutes more
#   thread-all   ThreadSanitizer, every test: an hour and more
# Builds go to build/test-NAME, or $FATHOM_BUILD/test-NAME.
set -eu
cd "$(dirname "$0")/.."
source=$(pwd)
builds=${FATHOM_BUILD:-$source/build}
jobs=$(nproc)
at_once=$((jobs + 1)) # tests that wait leave a core to others

sh tests/packages.sh test

build() { # name, target, further options of cmake…
    name=$1 target=$2
    shift 2
    echo "== $name: building in $builds/test-$name"
    cmake -S "$source" -B "$builds/test-$name" -G Ninja -DFATHOM_WERROR=ON "$@" >"$builds/test-$name.log" 2>&1 ||
        { cat "$builds/test-$name.log" >&2; echo "fathom tests: configuring failed" >&2; exit 1; }
    cmake --build "$builds/test-$name" --target "$target" -j "$jobs" >"$builds/test-$name.log" 2>&1 ||
        { grep -A 12 -E 'error|FAILED' "$builds/test-$name.log" >&2; echo "fathom tests: the build failed" >&2; exit 1; }
}

check_layout() {
    echo "== layout: clang-format"
    git -C "$source" ls-files '*.c' '*.h' '*.cpp' | (cd "$source" && xargs clang-format --dry-run -Werror) ||
        { echo "fathom tests: run clang-format -i on the files above" >&2; exit 1; }
}

# What Embree answers depends on its instructions. The first run had the best there are.
plainer_sets() {
    grep -q avx512f /proc/cpuinfo && echo avx2
    grep -q avx2 /proc/cpuinfo && echo sse4.2
    true
}

sanitized() { # target, options of ctest
    build sanitize "$1" -DCMAKE_BUILD_TYPE=RelWithDebInfo -DFATHOM_SANITIZE=address,undefined
    shift
    # Libraries of the distribution that stay loaded at exit keep memory: tests/leaks.supp says which.
    ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1 \
        LSAN_OPTIONS=suppressions=$source/tests/leaks.supp:print_suppressions=0 \
        ctest --test-dir "$builds/test-sanitize" --output-on-failure -j "$at_once" "$@"
}

mkdir -p "$builds"
[ $# -gt 0 ] || set -- release sanitize thread
for kind; do
    case $kind in
    release)
        # Another clang-format lays out other things differently: Debian 12's judges.
        if clang-format --version | grep -q 'version 14\.' && [ -e "$source/.git" ]; then check_layout; fi
        build release all -DCMAKE_BUILD_TYPE=Release
        ctest --test-dir "$builds/test-release" --output-on-failure -j "$at_once"
        for set in $(plainer_sets); do
            echo "== release: tests that depend on the instruction set, with no more than $set"
            FATHOM_ISA=$set ctest --test-dir "$builds/test-release" --output-on-failure -j "$at_once" -L isa
        done
        ;;
    sanitize) sanitized sanitize_tests -LE release ;;
    sanitize-all) sanitized all ;;
    thread)
        build thread thread_tests -DCMAKE_BUILD_TYPE=RelWithDebInfo -DFATHOM_SANITIZE=thread
        ctest --test-dir "$builds/test-thread" --output-on-failure -j "$at_once" -L threads
        ;;
    fuzz)
        sh "$source/tests/fuzz.sh" 10
        ;;
    analyze)
        sh "$source/tests/packages.sh" clang
        sh "$source/tests/analyze.sh"
        ;;
    thread-all)
        build thread all -DCMAKE_BUILD_TYPE=RelWithDebInfo -DFATHOM_SANITIZE=thread
        ctest --test-dir "$builds/test-thread" --output-on-failure -j "$at_once"
        ;;
    *)
        echo "usage: sh tests/run.sh [release] [sanitize] [thread] [fuzz] [analyze] [sanitize-all] [thread-all]" >&2
        exit 2
        ;;
    esac
done
echo "== all passed"
