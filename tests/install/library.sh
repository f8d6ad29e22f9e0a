# libfathom.so exports the functions that its headers declare and nothing else, and needs no library that only judges or
# measures. $SOURCE, $BUILD, $CC, $SANITIZE come from CTest; the working directory is the test's own.
set -eu
library=$BUILD/lib/libfathom.so

fail() {
    echo "library: $*" >&2
    exit 1
}

printf '#include <fathom/fathom.h>\n' | "$CC" -std=c99 -E -P -I"$SOURCE/include" - | tr '\n' ' ' | tr ';' '\n' |
    sed -n '/visibility/s/.*[ *]\(fathom_[a-z0-9_]*\)(.*/\1/p' | sort -u >declared.txt
[ "$(wc -l <declared.txt)" -gt 50 ] || fail "found only $(wc -l <declared.txt) functions in the headers"
nm -D --defined-only "$library" | awk '{ print $3 }' | sort -u >exported.txt
# Sanitizers export names of their own from what they instrument.
[ -z "$SANITIZE" ] || { grep '^fathom_' exported.txt >own.txt && mv own.txt exported.txt; }
diff declared.txt exported.txt >difference.txt ||
    fail "the headers declare (<) and the library exports (>): $(grep '^[<>]' difference.txt | tr '\n' ' ')"

readelf --dynamic "$library" | grep -q NODELETE || fail "dlclose() would unmap it below its waiting threads"
readelf --dynamic "$library" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' >needed.txt
grep -q embree needed.txt || fail "readelf shows no library that it needs"
unwanted=$(grep -E 'gmp|OpenImageIO|OpenColorIO|stdc\+\+' needed.txt || true)
[ -z "$unwanted" ] || fail "it needs $unwanted"
