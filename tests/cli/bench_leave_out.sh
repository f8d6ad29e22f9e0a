# bench/leave_out.sh at small size: it prints a row for each part. No time is judged.
. "$SOURCE/tests/cli/check.inc"
BUILD=$BUILD TRIANGLES=2k SIZE=64x36 sh "$SOURCE/bench/leave_out.sh" 1 0 >out.txt || die 'bench/leave_out.sh'
[ "$(grep -c '^| .* | [0-9.]* | [0-9.]* | [0-9.]* (.*) |' out.txt)" = 10 ] || die 'bench/leave_out.sh: 10 rows'
said out.txt '| buffers of AOVs | '
