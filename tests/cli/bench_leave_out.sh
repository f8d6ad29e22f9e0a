# bench/leave_out.sh at small size: a row for each part, every render fine. No time is judged.
. "$SOURCE/tests/cli/check.inc"
BUILD=$BUILD TRIANGLES=2k SIZE=64x36 sh "$SOURCE/bench/leave_out.sh" 1 0 >out.txt || die 'bench/leave_out.sh'
[ "$(grep -c '^| .* | [0-9.]* | [0-9.]* | [0-9.]* (.*) |' out.txt)" = 16 ] || die 'bench/leave_out.sh: 16 rows'
said out.txt '| buffers of AOVs | '
