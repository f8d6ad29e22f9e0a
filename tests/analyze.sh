#!/bin/sh
# Static analysis of src/: nothing is found but what tests/analyze.txt lists, each with its reason, and everything in
# that list is still found.
# usage: sh tests/analyze.sh [clang] [tidy] [cppcheck] [analyzer]     (default: all four)
#   clang     clang's own warnings, of all files, those of the tests too; nothing is compiled to code
#   tidy      clang-tidy 14, as .clang-tidy says
#   cppcheck  cppcheck 2.10: errors, warnings, performance, portability
#   analyzer  gcc 12's -fanalyzer, which knows C alone
# Other versions find other things: those that are missing are passed by with a word. Configures, but does not build,
# build/analyze, or $FATHOM_BUILD/analyze. $JOBS: how many run at once (default: one for each processor).
set -eu
cd "$(dirname "$0")/.."
source=$(pwd)
build=${FATHOM_BUILD:-$source/build}/analyze
jobs=${JOBS:-$(nproc)}
[ $# -gt 0 ] || set -- clang tidy cppcheck analyzer

configure() { # folder, further options of cmake…
    folder=$1
    shift
    mkdir -p "$folder"
    cmake -S "$source" -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=Release "$@" >"$folder/configure.log" 2>&1 ||
        { cat "$folder/configure.log" >&2; echo "fathom analysis: configuring failed" >&2; exit 1; }
}

# The compiler's commands, one a line.
commands() { # folder
    sed -n 's/^  "command": "\(.*\)",$/\1/p' "$1/compile_commands.json" | sed 's/\\\([\\"]\)/\1/g'
}

configure "$build" -DFATHOM_TESTS=OFF
findings=$build/findings
: >"$findings"

# Those of src/, each file once: kernels are compiled several times over.
commands "$build" |
    awk -v folder="$source/src/" 'index($NF, folder) == 1 && !seen[$NF]++' >"$build/commands"
awk '{ print $NF }' "$build/commands" >"$build/files"

# Lines such as "src/a.c:12:3: warning: text [check]", in whatever folder, to tool|file|line|check|text.
keep() { # tool
    sed -n -E -e "s#^$build/(clang/)?modules/[a-z0-9_]+/#src/#" -e "s#^$source/##" \
        -e "s#^([^ :]+):([0-9]+):([0-9]+:)? (warning|error|performance|portability|style): (.*) \[([^][]*)\]\$#$1|\1|\2|\6|\5#p" |
        sed -E "s#^([^|]*\|[^|]*\|[^|]*\|)([^|,]*)(,[^|]*)?\|#\1\2|#" | sort -u >>"$findings"
}

clang_warnings() {
    command -v clang >/dev/null || { echo "no clang: passed by"; return 1; }
    configure "$build/clang" -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++
    # Those of the sources: others are made by the build.
    commands "$build/clang" | awk -v folder="$source/" 'index($NF, folder) == 1' | sed -E 's# -o [^ ]+ -c # -fsyntax-only -fno-caret-diagnostics #' | (
        cd "$build/clang"
        tr '\n' '\0' | xargs -0 -P "$jobs" -n 1 sh -c 'eval "LC_ALL=C $0" 2>&1 || echo "${0##* }:1: error: does not compile [clang]"'
    ) | sed -E 's#\[-W([^][]*)\]$#[\1]#' | keep clang
}

tidy() {
    clang-tidy --version | grep -q 'version 14\.' || { echo "no clang-tidy 14: passed by"; return 1; }
    # One process for each file: several in one carry state from one to the next.
    xargs -a "$build/files" -P "$jobs" -n 1 sh -c 'clang-tidy --quiet -p "$0" "$1" 2>/dev/null || true' "$build" |
        sed 's/,-warnings-as-errors\]$/]/' | keep tidy
}

cppcheck_all() {
    cppcheck --version | grep -q ' 2\.10' || { echo "no cppcheck 2.10: passed by"; return 1; }
    xargs -a "$build/files" -n 1000 cppcheck -j "$jobs" --quiet --std=c11 --std=c++17 \
        --enable=warning,performance,portability --library=posix,gnu "--library=$source/tests/analyze.cfg" \
        -D__x86_64__=1 -D__SIZEOF_FLOAT128__=16 -D_GNU_SOURCE=1 -DFATHOM_EMBREE_MAJOR=3 -DKERNEL_ISA=plain \
        -I "$source/src" -I "$source/include" \
        --template='{file}:{line}: {severity}: {message} [{id}]' 2>&1 | keep cppcheck
}

analyzer() {
    gcc-12 --version >/dev/null 2>&1 || { echo "no gcc 12: passed by"; return 1; }
    grep '\.c$' "$build/commands" | sed -E 's#^[^ ]+#gcc-12#; s# -Werror # #; s# -o [^ ]+ -c # -fanalyzer -fanalyzer-verbosity=0 -fno-diagnostics-show-caret -fdiagnostics-color=never -S -o /dev/null #' |
        tr '\n' '\0' | xargs -0 -P "$jobs" -n 1 sh -c 'eval "LC_ALL=C $0" 2>&1' |
        sed -E 's# \[CWE-[0-9]+\]##; s#\[-W([a-z0-9-]+)\]$#[\1]#' | keep analyzer
}

ran=""
for tool; do
    began=$(date +%s)
    case $tool in
    clang) clang_warnings && ran="$ran clang" ;;
    tidy) tidy && ran="$ran tidy" ;;
    cppcheck) cppcheck_all && ran="$ran cppcheck" ;;
    analyzer) analyzer && ran="$ran analyzer" ;;
    *)
        echo "usage: sh tests/analyze.sh [clang] [tidy] [cppcheck] [analyzer]" >&2
        exit 2
        ;;
    esac
    echo "$tool: $(wc -l <"$build/files") files, $(($(date +%s) - began)) s"
done

# The list: tool | file | check | part of the message | reason.
awk -F ' *[|] *' -v ran="$ran " -v list="$source/tests/analyze.txt" '
    BEGIN {
        while ((getline line <list) > 0) {
            if (line ~ /^ *(#|$)/) continue
            if (split(line, f, / *[|] */) != 5 || f[5] == "") {
                print "tests/analyze.txt: expected tool | file | check | part of the message | reason, found: " line
                bad = 1
                continue
            }
            ++n; tool[n] = f[1]; file[n] = f[2]; check[n] = f[3]; part[n] = f[4]; text[n] = line
        }
    }
    {
        known = 0
        for (i = 1; i <= n; ++i) {
            if ($1 == tool[i] && $2 == file[i] && $4 == check[i] && index($5, part[i])) known = used[i] = 1
        }
        if (!known) { print $2 ":" $3 ": " $5 " [" $1 ": " $4 "]"; bad = 1 }
    }
    END {
        for (i = 1; i <= n; ++i) {
            if (!used[i] && index(ran, " " tool[i] " ")) { print "tests/analyze.txt: is no longer found: " text[i]; bad = 1 }
        }
        exit bad
    }' "$findings" || { echo "fathom analysis: see above" >&2; exit 1; }
