# --memory-limit: compact structures where only they fit, refusal before anything is built where not even they do.
. "$SOURCE/tests/cli/check.inc"
refused 2 'memory-limit: expected a whole number from 1000000' render ball.glb -o none.exr --memory-limit 10
# Sanitizers hold memory of their own.
[ -z "$SANITIZE" ] || exit 0

run 0 generate sphere -t 1200k -o ball.glb
run 0 render ball.glb -o usual.exr --size 64x48 --memory-limit 8G
not_said err.txt warning

# What was foreseen is never less than what it comes to, nor more by as much as the program's share, which is held
# whole only while the image module loads.
foreseen() {
    run 0 render ball.glb -o seen.exr --size 64x48 --stats m.json "$@"
    peak=$(number m.json peakBytes) all=$(number m.json foreseenBytes)
    [ "$peak" -le "$all" ] || die "$*: $peak bytes at most, $all were foreseen"
    [ "$((all - peak))" -le 150000000 ] || die "$*: only $peak bytes at most, $all were foreseen"
    [ "$(number m.json bvhBytes)" -le "$(number m.json bvhPeakBytes)" ] || die "$*: more is kept than there was at most"
}
for spec in embree:low embree:medium embree:compact:medium; do foreseen --tracer $spec; done
needed=$(($(number m.json meshBytes) + $(number m.json bvhBytes) + $(number m.json filmBytes)))
awk "BEGIN { d = $(number m.json peakToNeeded) * $needed / $(number m.json peakBytes) - 1; exit !(d < 1e-6 && d > -1e-6) }" ||
    die 'peakToNeeded'
run 0 render ball.glb -o seen.exr --size 64x48 -v
said out.txt 'times meshes 28.8, BVH '

# 150 MB of program, 29 MB of mesh; the usual structures take 125 MB, compact ones 49.
run 0 render ball.glb -o compact.exr --size 64x48 --memory-limit 240M --stats s.json
said err.txt 'warning: the usual acceleration structure would take about 0.12 GB and 0.06 GB may be used: a compact'
[ "$(number s.json peakMemoryBytes)" -le 240000000 ] || die "beyond the limit: $(number s.json peakMemoryBytes)"
run 0 compare usual.exr compact.exr --tolerance 1e-3

refused 4 'out of memory: building takes about 0.05 GB and' \
    render ball.glb -o none.exr --size 64x48 --memory-limit 190M --quiet

# Who names the structures gets them or nothing.
refused 4 'out of memory: building takes about 0.12 GB' \
    render ball.glb -o none.exr --size 64x48 --memory-limit 240M --tracer embree:medium --quiet
run 0 render ball.glb -o named.exr --size 64x48 --memory-limit 240M --tracer embree:compact
not_said err.txt warning
