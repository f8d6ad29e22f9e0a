# fathom validate --extremes: the grid as table and JSON.
. "$SOURCE/tests/cli/check.inc"

run 0 validate --extremes --rays 4 --power 0 --families camera --json all.json
said out.txt 'scale-triangles'
said out.txt 'extreme cases, all'
said all.json '"extremes": ['
for group in scale-spheres offset-raw sliver grazing-planes tangent ratio-outside planet-part copies-quads \
    overlap-level nested-mirror broken; do
    said all.json "\"group\": \"$group\""
done
for spec in linear:f32 linear:f64 bvh embree embree:user; do
    said all.json "\"spec\": \"$spec\""
done
# Shading against closed forms, and the scene at the Earth's radius.
said out.txt 'error/bound'
for group in mirrors 'light guide' 'critical angle' ior fresnel phong blinn 'light distance' terminator spot earth; do
    said all.json "\"group\": \"$group\""
done
not_said all.json '"ok": false'

# A tracer of one's own, each row by itself; the grid changes the exit code. The page counts the leaks that the terminal counts,
# those of any-hit queries and of extreme cases included.
run 1 validate triangles --extremes --rays 100 --power 0 --families vertex --tracer embree:default \
    --tracer "$BUILD/tests/plugin/culls.so" --failures bad.txt -v --report leaks
leaks=$(sed -n 's/^.* wrong, \([0-9]*\) tracer leaks.*/\1/p' out.txt)
[ "$leaks" -gt 0 ] || die 'expected leaks of Embree in its default mode'
tr -d '\342\200\257' <leaks/index.html | grep -q "; $leaks tracer leaks" || die "the page does not count $leaks leaks"
said out.txt 'a sphere from outside, its radius 1e-06 times'
grep -q '^found: .*culls.so, extreme case scale-triangles 1: wrong: ' out.txt || die 'the library that culls is not found out'
not_said out.txt 'embree:user'

# Its failing rays are asked again in scenes made anew, and fail again.
grep ' wrong .* extreme:scale-triangles:1$' bad.txt | head -n 3 >again.txt
[ "$(wc -l <again.txt)" -eq 3 ] || die 'no failing rays of the grid'
run 1 validate --replay again.txt --tracer "$BUILD/tests/plugin/culls.so"
said out.txt '3 rays, 3 wrong'
sed 's/extreme:scale-triangles:/extreme:none:/' again.txt >none.txt
refused 3 'there is no group of extreme cases "none"' validate --replay none.txt --tracer "$BUILD/tests/plugin/culls.so"

# Nothing of it without being asked.
run 0 validate --rays 20 --power 0 --families camera --json none.json
not_said none.json '"extremes"'
