# fathom validate --light: closed forms of light as a table and JSON, and a scene against the reference integrator.
. "$SOURCE/tests/cli/check.inc"

run 0 validate --light --light-only sphere --light-error 0.01 --seed 3 --json light.json
said out.txt 'furnace, sphere '
said out.txt 'holds'
not_said out.txt 'broken'
not_said out.txt 'glass slab'
for key in law form verdict p samples channels measured expected standardError freedom level levelOfOne seed machine; do
    said light.json "\"$key\": "
done
[ "$(number light.json seed)" = 3 ] || die 'seed in the JSON'
# A row is of one channel: its numbers agree up to the digits printed, 2 of the error, 7 and 2 decimals of the others, and
# the allowance for rounding.
awk '/holds/ { error = $(NF - 3) * $(NF - 4); off = $(NF - 5) - $(NF - 4); if (off < 0) off = -off
    wrong = off - $(NF - 2) * error; if (wrong < 0) wrong = -wrong
    if (wrong > 0.05 * $(NF - 2) * error + 0.005 * error + 2e-5 * $(NF - 4) + 1e-7) { print; exit 1 } }' out.txt >rows.txt ||
    die "numbers of a row do not agree: $(cat rows.txt)"

# The same numbers on any thread count.
run 0 validate --light --light-only rectangle --light-error 0.01 --threads 1 --json one.json
run 0 validate --light --light-only rectangle --light-error 0.01 --threads 3 --json three.json
for n in one three; do grep -vE '"(seconds|threads|date)":' $n.json >$n.txt; done
cmp -s one.txt three.txt || die 'results depend on the number of threads'

# A scene: both integrators agree; what the reference lacks, it names.
cat >lit.json <<'JSON'
{ "image": { "width": 64, "height": 48, "integrator": "path", "maxDepth": 4 },
  "camera": { "eye": [0, 1, 4], "target": [0, 0.5, 0], "fovy": 50 },
  "background": [0.2, 0.3, 0.4],
  "materials": { "floor": { "kd": [0.7, 0.6, 0.5] }, "lamp": { "kd": [0, 0, 0], "ke": [4, 4, 3] } },
  "lights": [ { "type": "point", "position": [2, 3, 1], "intensity": 2 } ],
  "objects": [ { "type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": "floor" },
               { "type": "sphere", "center": [0.8, 0.5, 0], "radius": 0.5, "material": "lamp" },
               { "type": "sphere", "center": [-0.6, 0.5, 0], "radius": 0.5, "material": "floor" } ] }
JSON
run 0 validate lit.json --light --light-error 0.003 --json scene.json
said out.txt 'path less reference: '
for key in commit date machine difference; do said scene.json "\"$key\": "; done
sed 's/"background"/"ambient": [1, 1, 1], "background"/' lit.json >ambient.json
run 0 validate ambient.json --light --light-error 0.01
[ "$(grep -c 'ambient light is ignored' err.txt)" = 1 ] || die "one warning of ambient light"
sed 's/"lights": \[/&{"type": "environment", "file": "sky.exr"}, /' lit.json >sky.json
run 0 render lit.json -o sky.exr --size 8x4 --spp 1
run 0 validate sky.json --light --light-error 0.01
said out.txt 'path less reference: '
# However large the error, there are enough samples for the test's level: a correct render fails 1 run in 500.
seeds='1 2 3 4 5 6'
[ -z "$SANITIZE" ] || seeds=1
for seed in $seeds; do
    run 0 validate "$SOURCE/scenes/light/moving-balls.json" --light --light-error 0.02 --seed $seed
done
run 2 validate --light --light-only 'no such law'
said err.txt 'no such law'

# What such a run does not take is refused, and files are checked before it.
for option in '--report page' '--failures bad.txt' '--tracer bvh' '--rays 5' '--families edge' '--power 0' --heavy --extremes \
    '--sample 3'; do
    # shellcheck disable=SC2086
    refused 2 "${option%% *}: has no effect with --light" validate --light $option
done
refused 2 '--light-only: has no effect with --light of a SCENE' validate lit.json --light --light-only sphere
refused 2 '--light-only: has no effect without --light' validate --light-only sphere
refused 2 '--light-error: has no effect without --light' validate --light-error 0.1
refused 2 '--json: has no effect with --replay' validate --replay bad.txt --json a.json
refused 2 '--light: has no effect with --replay' validate --replay bad.txt --light
refused 2 'lit.json: is the input' validate lit.json --light --json lit.json
refused 4 'its folder does not exist' validate lit.json --light --json nowhere/a.json
