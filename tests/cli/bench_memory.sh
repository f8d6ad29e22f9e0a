# bench/memory.sh at small size: a row for each way, compact structures and refusal under limits.
. "$SOURCE/tests/cli/check.inc"
# Sanitizers hold memory of their own.
[ -z "$SANITIZE" ] || exit 0
BUILD=$BUILD MESHES='20k 1200k' LIMITS='150M 70M' sh "$SOURCE/bench/memory.sh" >out.txt
[ "$(grep -c '^| 20k ' out.txt)" -eq 5 ] || die 'five rows'
[ "$(grep -c '^| 1200k ' out.txt)" -eq 5 ] || die 'five rows'
said out.txt '| 1200k | limit 150M: compact, it says | 28.8 | '
said out.txt '| 1200k | limit 70M: exit code 4, '
said out.txt '1200k.glb: out of memory: building takes about'
awk -F '|' '/embree:/ { if (!($9 > 0.5 && $9 < 100 && $10 <= $9 && $7 <= $8)) exit 1 }' out.txt || die 'numbers'
