# fathom validate: every shape by default, as table and JSON, with whatever instruction set the run may use.
. "$SOURCE/tests/cli/check.inc"

# The hand-written intersectors and Embree are right on every shape and family, Embree's known faults apart.
run 0 validate --rays 40 --power 1e-5 --seed 7 --json all.json
said out.txt 'embree (Embree'
said out.txt 'reference (reference)'
grep -q '^0 wrong, ' out.txt || die 'no sum'
for scene in spheres quads triangles planes instances boxes squares masks masked-shapes fine; do
    said out.txt "$scene "
    said all.json "\"scene\": \"$scene\""
done
# Here Embree's float loses the near root of a sphere to t_near, and a shape lies before the far one.
run 0 validate masked-shapes --tracer embree:user --rays 200 --power 0 --sample 0
for family in camera uniform edge vertex grazing tangent surface far axis scaled interval \
    tiny bundle lattice ends rendered; do
    said all.json "\"family\": \"$family\""
done
[ "$(number all.json raysPerFamily)" = 40 ] || die 'rays in the JSON'
! grep -q '"wrong": [1-9]' all.json || die 'something is wrong in the JSON'
for key in commit machine cpu compiler date nsPerRay isa any tUlps tRelative position normal uv histogram bins; do
    said all.json "\"$key\": "
done

# Plates a million times as long as wide: errors that slivers allow are no fault of a tracer's.
awk 'BEGIN { for (i = 0; i < 60; ++i) { w = 10 ^ -(i % 5 + 2); x = sin(7 * i); y = cos(5 * i)
    printf "v %.9g %.9g %.9g\nv %.9g %.9g %.9g\nv %.9g %.9g %.9g\n", x, y, sin(i), x + 0.7, y + sin(3 * i), cos(i), x + w, y - w, sin(i) + w
    printf "f -3 -2 -1\n" } }' >plates.obj
run 0 validate plates.obj --power 0 --rays 1000 --tracer bvh --tracer embree:user

# The instruction set of a run is told.
run 0 validate triangles --power 1e-4 --rays 100 --families edge --tracer embree:sse2 --tracer embree:1:avx --tracer linear --json isa.json
grep -q '"isa": "SSE\|"isa": "NEON' isa.json || [ "$(uname -m)" != x86_64 ] || die 'no SSE'

# A heavy mesh is judged by a tree of spheres; a sample by every primitive; both agree, or this fails with 70.
"$FATHOM" generate sphere --triangles 100k -o heavy.glb >/dev/null
run 0 validate heavy.glb --power 1e-4 --rays 100 --sample 5 --tracer bvh --tracer embree
