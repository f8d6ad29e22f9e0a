# fathom validate: scenes of one's own, tracers from libraries, failures that can be asked again, runs that are stopped.
. "$SOURCE/tests/cli/check.inc"
write_scene

# A scene of one's own; a row for each family.
run 0 validate scene.json --power 1e-4 --rays 200 --families edge,tangent --tracer linear:f64 -v
said out.txt '  tangent '
not_said out.txt '  camera '
# The nearest hit is judged, though images prefer the side that faces the camera where two sheets nearly touch.
cat >sheets.json <<'EOF'
{ "camera": { "eye": [0, 0, 6], "target": [0, 0, 0] },
  "materials": { "m": { "model": "metallicRoughness", "doubleSided": false } },
  "objects": [ { "type": "quad", "center": [0, 0, 2e-5], "u": [0, 4, 0], "v": [4, 0, 0], "material": "m" },
               { "type": "quad", "center": [0, 0, 0], "u": [4, 0, 0], "v": [0, 4, 0], "material": "m" } ] }
EOF
run 0 validate sheets.json --power 0 --rays 200 --families camera,uniform --tracer linear:f64
# A bound is rounded up: 1 - 0.05^(1/3) is 0.632, 1 - 0.05^(1/203) is 0.0147.
run 0 validate planes --tracer reference --families camera --rays 3 --power 0
said out.txt 'the rate is below 0.64 at 95 %'
run 0 validate planes --tracer reference --families camera --rays 203 --power 0
said out.txt 'the rate is below 0.015 at 95 %'
# Ten times of the rays and of the power, which would be ten million rays here without the limit.
run 0 validate planes --tracer embree --families rendered --rays 1100 --heavy --json heavy.json
[ "$(number heavy.json screened)" = 1100000 ] || die 'heavy: 100 more rays for each of 11,000'
# The same numbers on any thread count.
run 0 validate scene.json --power 1e-4 --rays 1000 --tracer reference --threads 1 --json one.json
run 0 validate scene.json --power 1e-4 --rays 1000 --tracer reference --threads 3 --json three.json
for n in one three; do grep -vE '"(seconds|nsPerRay|threads|date)":' $n.json >$n.txt; done
cmp -s one.txt three.txt || die 'results depend on the number of threads'

run 0 validate triangles --power 0 --rays 20 --families far --tracer linear --json far-figures.json
said far-figures.json '"isa": null'

# A library with a deliberate bug: its wrong answers are found, written, and found again by asking again.
plugins=$BUILD/tests/plugin
run 0 validate triangles --power 1e-3 --rays 100 --tracer "$plugins/correct.so"
run 1 validate triangles --power 0 --rays 100 --tracer "$plugins/gap.so" --families edge,vertex -q
run 1 validate triangles --power 0 --rays 100 --tracer "$plugins/culls.so" --families uniform,edge --failures bad.txt
grep -q 'culls.so \(uniform\|edge\) [0-9]* wrong .*0x.* triangles$' bad.txt || die 'no failing ray'
grep -q 'culls.so \(uniform\|edge\) [0-9]* any-wrong .*0x.* triangles$' bad.txt || die 'no failing any hit'
count=$(grep -c -e ' wrong ' -e ' any-wrong ' bad.txt)
run 1 validate --replay bad.txt --tracer "$plugins/culls.so"
said out.txt "$count rays, $count wrong, $count with the answer that was given"
said out.txt 'any-wrong'
run 1 validate --replay bad.txt --tracer "$plugins/culls.so" --quiet
silent out.txt
run 0 validate --replay bad.txt --tracer reference
said out.txt "$count rays, 0 wrong"
said out.txt ': no longer'
# Lines may end as on any system.
sed 's/$/\r/' bad.txt >windows.txt
run 1 validate --replay windows.txt --tracer "$plugins/culls.so"
said out.txt "$count rays, $count wrong"
# A library is asked about the built-in scenes that it can hold; the others are named.
run 0 validate --tracer "$plugins/correct.so" --rays 2 --families uniform --sample 0 --power 0
said out.txt 'correct.so cannot hold: spheres, quads, planes, instances, squares, masked-shapes'
said out.txt 'the rate is below'
head -n 2 bad.txt | cut -d' ' -f1-9 >broken.txt

# As many rays as one likes; what was done when one has enough is shown and written.
phase=validate
start validate spheres --rays 1e9 --families uniform,far --tracer linear --json part.json
until [ "$(grep -c '"phase": "validate"' err.txt)" -ge 2 ]; do
    kill -0 $child || die 'it ended before it was met'
    sleep 0.05
done
kill -TERM $child
end 5
said out.txt 'spheres '
[ "$(number part.json raysPerFamily)" = 1000000000 ] || die 'rays asked for'
grep -q 'rays/s' err.txt || grep -q 'stopped after' err.txt || die 'nothing about the stop'

# A tracer that needs minutes for a batch of rays does not finish it.
"$FATHOM" generate sphere --triangles 300k -o slow.glb >/dev/null
"$FATHOM" validate slow.glb --families edge --tracer "$BUILD/tests/plugin/correct.so" >out.txt 2>err.txt &
child=$!
sleep 1
kill -TERM $child
end 5
said out.txt 'correct.so: 0 answers wrong in 0 rays judged'

refused 2 '--families: expected names from camera,uniform,' validate --families edges
refused 2 '--rays: expected a whole number from 1' validate --rays 0
refused 2 'unexpected argument "b.json"' validate a.json b.json
refused 2 'xyzzy' validate --tracer xyzzy
refused 3 'nothing.json' validate nothing.json
refused 3 'sphres: expected a file, or a built-in scene: spheres, ' validate sphres
refused 3 'broken.txt:2: not a ray' validate --replay broken.txt
refused 2 'same file' validate --json a.txt --failures a.txt
