# bench/render.sh at small size: a row for each number of lights and samples. No time is judged.
. "$SOURCE/tests/cli/check.inc"
BUILD=$BUILD MESHES=5k SIZE=160x90 SPP="1 4" sh "$SOURCE/bench/render.sh" 1 >out.txt || die 'bench/render.sh'
[ "$(grep -c '^| 5k | [18] | [14] | .* s | [0-9.]* | [0-9.]* (.*) | [0-9.]* |$' out.txt)" = 4 ] ||
    die 'bench/render.sh: 4 rows'
