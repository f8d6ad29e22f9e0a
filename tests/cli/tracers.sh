# Every kind of tracer renders, from words and from shared libraries.
. "$SOURCE/tests/cli/check.inc"
write_scene

# The BVH's answers are those of linear search, and so is the image, in each precision.
for precision in f32 f64; do
    run 0 render scene.json -o linear.exr --exr-float --tracer linear:$precision
    run 0 render scene.json -o bvh.exr --exr-float --tracer bvh:$precision --stats a.json
    same linear.exr bvh.exr
    said a.json "\"tracer\": \"reference BVH, $precision\""
done
run 0 render scene.json -o reference.exr --exr-float --tracer reference
run 0 render scene.json -o linear.exr --exr-float --tracer linear:f32
same linear.exr reference.exr

# The default is Embree, however it is said.
run 0 render scene.json -o base.exr --exr-float
run 0 render scene.json -o a.exr --exr-float --tracer embree
same base.exr a.exr

# Others differ where rounding moves an edge: 1 pixel in 100 at most, and those are few of 6144.
for tracer in linear:f64 embree:user embree:default:raw:4 embree:compact:high; do
    run 0 render scene.json -o a.exr --exr-float --tracer $tracer
    code=0
    "$FATHOM" compare base.exr a.exr --tolerance 1e-4 >out.txt || code=$?
    pixels=$(sed -n 's/.*, \([0-9]*\) of 6144 pixels.*/\1/p' out.txt)
    [ "${pixels:-0}" -le 61 ] || die "$tracer differs in $pixels pixels"
done

# Tracers from outside. A ray that comes from within meets the far side from behind.
plugins=$BUILD/tests/plugin
run 0 generate sphere --triangles 200 -o ball.ply
run 0 render ball.ply --integrator classic -o linear.exr --exr-float --size 48x32 --spp 1 --tracer linear:f64
run 0 render ball.ply --integrator classic -o a.exr --exr-float --size 48x32 --spp 1 --tracer "$plugins/correct.so" --stats a.json
run 0 compare linear.exr a.exr --tolerance 1e-4
said a.json '"tracer": "example: correct"'
run 0 render ball.ply --integrator classic -o b.exr --exr-float --size 48x32 --spp 1 --tracer "$plugins/culls.so"
cp "$plugins/correct.so" near.so
run 0 render ball.ply --integrator classic -o b.exr --exr-float --size 48x32 --spp 1 --tracer near.so
same a.exr b.exr
rm near.so
# A bare model stands on a floor, which is no instance.
run 0 render ball.ply -o c.exr --size 16x16 --spp 1 --tracer "$plugins/correct.so"
rm c.exr
refused 2 'takes only triangles, and the scene has' render scene.json -o c.exr --tracer "$plugins/correct.so"
refused 3 'tracer ./none.so: cannot be loaded' render ball.ply --integrator classic -o c.exr --tracer none.so
mkfifo pipe.so
refused 3 'tracer ./pipe.so: cannot be loaded: is not a regular file' render ball.ply --integrator classic -o c.exr --tracer pipe.so
rm pipe.so
refused 3 'is of version 0; expected 1' render ball.ply --integrator classic -o c.exr --tracer "$plugins/faulty.so"

# $FATHOM_ISA limits the instruction set, and a word that names none is refused, whatever traces.
if [ "$(uname -m)" = x86_64 ]; then
    (export FATHOM_ISA=sse2; run 0 render scene.json -o a.exr --exr-float --tracer embree:avx2 --stats a.json)
    said a.json '"isa": "SSE2"'
fi
for tracer in embree linear; do
    (export FATHOM_ISA=sse9; refused 2 'FATHOM_ISA: expected sse2, sse4.2, avx, avx2 or avx512, found "sse9"' render scene.json -o a.exr --tracer $tracer)
done
