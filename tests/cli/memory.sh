# --memory-limit: compact structures where only they fit, refusal before anything is built where not even they do.
. "$SOURCE/tests/cli/check.inc"
refused 2 'memory-limit: expected a whole number from 1000000' render ball.glb -o none.exr --memory-limit 10
# Sanitizers hold memory of their own.
[ -z "$SANITIZE" ] || exit 0

run 0 generate sphere -t 1200k -o ball.glb
run 0 render ball.glb -o usual.exr --size 64x48 --memory-limit 8G
not_said err.txt warning

# 135 MB of program, 29 MB of mesh; the usual structures take 125 MB, compact ones 49.
run 0 render ball.glb -o compact.exr --size 64x48 --memory-limit 225M --stats s.json
said err.txt 'warning: the usual acceleration structure would take about 0.12 GB and 0.06 GB may be used: a compact'
[ "$(number s.json peakMemoryBytes)" -le 225000000 ] || die "beyond the limit: $(number s.json peakMemoryBytes)"
run 0 compare usual.exr compact.exr --tolerance 1e-3

refused 4 'out of memory: building takes about 0.05 GB and' \
    render ball.glb -o none.exr --size 64x48 --memory-limit 180M --quiet

# Who names the structures gets them or nothing.
refused 4 'out of memory: building takes about 0.12 GB' \
    render ball.glb -o none.exr --size 64x48 --memory-limit 225M --tracer embree:medium --quiet
run 0 render ball.glb -o named.exr --size 64x48 --memory-limit 225M --tracer embree:compact
not_said err.txt warning
