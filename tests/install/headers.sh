# Each public header compiles alone, as C99 and as C++17, without a warning. $SOURCE, $CC and $CXX come from
# CTest.
set -eu
for path in "$SOURCE"/include/fathom/*.h; do
    header=${path##*/}
    warnings="-pedantic -Wall -Wextra -Wundef -Werror -fsyntax-only -I$SOURCE/include"
    # shellcheck disable=SC2086
    printf '#include <fathom/%s>\n#include <fathom/%s>\ntypedef int used;\n' "$header" "$header" |
        "$CC" -std=c99 $warnings -x c - || { echo "$header: is not C99" >&2; exit 1; }
    # shellcheck disable=SC2086
    printf '#include <fathom/%s>\n#include <fathom/%s>\n' "$header" "$header" |
        "$CXX" -std=c++17 $warnings -x c++ - || { echo "$header: is not C++17" >&2; exit 1; }
done
