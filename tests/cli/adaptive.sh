# --target-error and --max-time: what is said of the error, and what is refused.
. "$SOURCE/tests/cli/check.inc"
write_scene

holds() { awk "BEGIN { exit !($1) }" || die "expected $1"; }

run 0 render scene.json -o a.exr --exr-float --target-error 0.01 --stats a.json
grep -q ' spp, error 0\.0[0-9]* (target 0.01 reached), ' out.txt || die 'the line does not tell the error'
holds "$(number a.json errorEstimate) > 0 && $(number a.json errorEstimate) <= 0.01"
holds "$(number a.json meanSpp) >= 4"
[ "$(number a.json spp)" = 65536 ] || die 'the most samples'
grep -aq 'fathom:errorEstimate' a.exr || die 'the header does not tell the error'
run 0 render scene.json -o b.exr --exr-float --target-error 0.01 --threads 3 --tile-size 64
same a.exr b.exr
run 0 render scene.json -o b.exr --exr-float --target-error 0.005 --stats b.json
holds "$(number b.json meanSpp) > $(number a.json meanSpp)"
run 0 render scene.json -o b.exr --target-error 0.01 --min-spp 32 --stats b.json
holds "$(number b.json meanSpp) >= 32"

# Paths go to an error of their own; a number of samples means so many everywhere.
run 0 render scene.json -o b.exr --integrator path --stats b.json
holds "$(number b.json errorEstimate) > 0 && $(number b.json errorEstimate) <= 0.02"
[ "$(number b.json spp)" = 1024 ] || die 'the most samples of paths'
run 0 render scene.json -o b.exr --integrator path --spp 7 --stats b.json
[ "$(number b.json meanSpp)" = 7.0 ] || die 'as many samples as are asked for'

# Few samples at most: the target is missed, and that is told.
run 0 render scene.json -o b.exr --target-error 0.0001 --spp 16 --stats b.json
said out.txt '(above the target of 0.0001: a tile may end a little above it, and has at most 16 spp)'
holds "$(number b.json errorEstimate) > 0.0001"
run 0 render scene.json -o b.exr --stats b.json
said b.json '"errorEstimate": null'
! grep -aq 'fathom:errorEstimate' b.exr || die 'an error that nobody estimated'

# A render to a time limit ends with a whole image, here at its most samples.
run 0 render scene.json -o b.exr --integrator path --max-time 300 --spp 8 --aov samples,error --stats b.json
[ "$(number b.json meanSpp)" = 8.0 ] || die 'time to spare, and not the most samples'
run 0 render scene.json -o c.exr --integrator path --pattern sobol --spp 8 --aov samples,error
same b.exr c.exr
# Writing is tried for its time, in part and in all; nothing of that is left.
run 0 render scene.json -o r.exr -o r.png -o r.jpg --max-time 5 --spp 4 --aov Z
[ "$(ls -A | grep -c '^\.*r\.')" -eq 3 ] || die 'a file of a rehearsal was left'
refused 2 'too short' render scene.json -o d.exr --max-time 0.000001

# The scene's file may ask for it, and the command line goes over it.
sed 's/"width": 96, "height": 64/"width": 96, "height": 64, "spp": 256, "pattern": "sobol", "targetError": 0.01/' \
    scene.json >asks.json
run 0 render asks.json -o b.exr --exr-float --stats b.json
holds "$(number b.json meanSpp) < 256 && $(number b.json errorEstimate) <= 0.01"
run 0 render asks.json -o b.exr --min-spp 256 --stats b.json
[ "$(number b.json meanSpp)" = 256.0 ] || die '--min-spp'

refused 2 '--target-error: expected off or a number above 0' render scene.json -o d.exr --target-error -1
refused 2 '--target-error: expected off or a number above 0' render scene.json -o d.exr --target-error nan
refused 2 '--max-time: expected off or a number above 0' render scene.json -o d.exr --max-time 0
refused 2 'need --pattern sobol' render scene.json -o d.exr --target-error 0.1 --pattern grid
refused 2 'expected a power of two from 4, such as 1024, found 100' \
    render scene.json -o d.exr --target-error 0.1 --spp 100
refused 2 'min spp: expected a power of two from 4 to spp' render scene.json -o d.exr --max-time 9 --min-spp 5
refused 2 '--min-spp: only with --target-error E or --max-time SECONDS' render scene.json -o d.exr --min-spp 8
