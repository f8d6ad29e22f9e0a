# The program's commands use the public interface, as any other program would: they include the public headers, those
# of the system, their own, and a few helpers for text. `bench` and `validate` belong to the library that judges and
# measures. $SOURCE comes from CTest.
set -eu
cd "$SOURCE/src"
allowed='<[^>]*>|"cli/[^"]*"|"base/(array|clock|file_name|parameter|text)\.h"|"json/memory\.h"'
own='"cli/(bench|validate)/'
files=$(find cli -name '*.c' -o -name '*.cpp' -o -name '*.h' | grep -vE '^cli/(bench|validate)/')
[ "$(echo "$files" | wc -l)" -gt 20 ] || { echo "includes: found only: $files" >&2; exit 1; }
# shellcheck disable=SC2086
wrong=$(grep -nE '^ *# *include' $files | grep -vE "include +($allowed)" || true)
# shellcheck disable=SC2086
wrong="$wrong$(grep -nE "^ *# *include +$own" $files || true)"
[ -z "$wrong" ] || { echo "includes: not of the public interface:" >&2; echo "$wrong" >&2; exit 1; }
# The helpers themselves know nothing else.
wrong=$(grep -nE '^ *# *include +"' base/array.h base/clock.h base/file_name.h base/parameter.h base/text.h json/memory.h | grep -v 'include "base/text.h"' || true)
[ -z "$wrong" ] || { echo "includes: a helper for text includes more: $wrong" >&2; exit 1; }
