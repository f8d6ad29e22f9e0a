# --stats: every number is there, and the numbers agree with each other.
. "$SOURCE/tests/cli/check.inc"
write_scene

at_least() { awk "BEGIN { exit !($1 >= $2) }" || die "expected $1 >= $2: $3"; }

run 0 render scene.json -o a.exr --spp 4 --stats s.json
cat s.json >out.txt
for key in triangles primitives instances degenerateTriangles read build render write total camera shadow reflection \
    refraction raysPerSecond peakMemoryBytes peakBytes meshBytes bvhBytes filmBytes imageBytes bvhPeakBytes peakToNeeded foreseenBytes \
    threads width height spp; do
    [ -n "$(number s.json $key)" ] || die "--stats: no number $key"
done
said s.json '"interrupted": false'
said s.json '"scene": "ball on a floor"'
said s.json "\"fathom\": \"$("$FATHOM" --version | cut -d ' ' -f 2)\""
grep -qE '"embreeVersion": "[34]\.[0-9.]+"' s.json || die '--stats: embreeVersion'
grep -qE '"isa": "[A-Z]' s.json || die '--stats: isa'
said s.json '"a.exr"'

[ "$(number s.json primitives)" = 2 ] || die 'primitives'
[ "$(number s.json triangles)" = 0 ] || die 'triangles'
[ "$(number s.json camera)" = $((96 * 64 * 4)) ] || die 'camera rays'
[ "$(number s.json refraction)" = 0 ] || die 'refraction rays'
at_least "$(number s.json reflection)" 1 'reflection rays'
at_least "$(number s.json shadow)" 1 'shadow rays'
sum=0
for key in camera shadow reflection refraction; do sum=$((sum + $(number s.json $key))); done
# "total" stands once under rays and once under seconds.
[ "$(sed -n '/"rays": {/,/}/p' s.json | sed -n 's/.*"total": \([0-9]*\).*/\1/p')" = $sum ] || die 'rays.total'
seconds=$(sed -n '/"seconds": {/,/}/p' s.json | sed -n 's/.*"total": \([-+.e0-9]*\).*/\1/p')
at_least "$seconds + 1e-6" "$(number s.json read) + $(number s.json build) + $(number s.json render) + $(number s.json write)" \
    'the parts of the time'
at_least "$(number s.json peakMemoryBytes)" 4000000 'memory'
rate=$(number s.json raysPerSecond)
at_least "$rate * $(number s.json render)" "$sum * 0.999" 'rays/s'
at_least "$sum * 1.001" "$rate * $(number s.json render)" 'rays/s'

# Instances, triangles and degenerate triangles are counted.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n' >mesh.obj
run 0 render mesh.obj --integrator classic -o a.exr --size 32x32 --stats s.json
[ "$(number s.json triangles) $(number s.json degenerateTriangles)" = '2 1' ] || die 'degenerate triangles'
[ "$(grep -c 'fathom: warning: triangles without area that are left out: 1' err.txt)" = 1 ] || die 'one warning'
said s.json '    "triangles without area that are left out: 1"'

python3 -m json.tool s.json >/dev/null || die 'not JSON'

# Parts that were left out, and the shadow rays that were not cast.
write_scene
run 0 render scene.json -o a.exr -v --stats s.json
said out.txt 'left out triangle geometry: there is no mesh'
said s.json '"what": "shading normals"'
not_said s.json 'mirrored'
at_least "$(number s.json unlitShadow)" 1 'shadow rays not cast'

# Shadow rays that would not show are not cast, and no pixel of the file changes by more than a step: 1 / 255, and half
# floats below 1 are at most 2^-11 apart.
sed 's/"lights": \[/"lights": [ { "type": "point", "position": [-2, 9, 3], "intensity": 0.002 },/' scene.json >faint.json
run 0 render faint.json -o a.png -o a.exr --stats s.json
run 0 render faint.json -o b.png --leave-out-below 8bit --stats t.json -v
[ "$(number s.json faintShadow)" = 0 ] || die 'nothing is faint by default'
at_least "$(number t.json faintShadow)" 100 'faint shadow rays'
said out.txt 'faint shadow rays: what they could add'
run 0 compare a.png b.png --tolerance 0.00393
sed -i 's/0.002/0.0001/' faint.json
run 0 render faint.json -o a.exr
run 0 render faint.json -o b.exr --leave-out-below half --stats t.json
at_least "$(number t.json faintShadow)" 100 'faint shadow rays'
run 0 compare a.exr b.exr --tolerance 0.000489
refused 2 'expected no --ocio, --display, --view and no $OCIO' render scene.json -o a.png --leave-out-below 8bit --view Raw
refused 2 '--leave-out-below: expected none|8bit|half' render scene.json -o a.png --leave-out-below 4bit

# The origin of an image: exact in the statistics, without folders in the header, and absent where equal images must be
# equal files.
mkdir folder
cp scene.json "folder/the scene.json"
run 0 render "$PWD/folder/the scene.json" -o folder/a.png --spp=4 --stats s.json
said s.json "\"$PWD/folder/the scene.json\""
said s.json '"--spp=4"'
grep -qE '"commit": ("[0-9a-f]+\+?"|null)' s.json || die 'commit'
fingerprint=$(sed -n 's/.*"sceneFingerprint": "\([0-9a-f]\{16\}\)".*/\1/p' s.json)
[ -n "$fingerprint" ] || die 'fingerprint'
said folder/a.png "fathom render 'the scene.json' -o a.png --spp=4 --stats s.json"
said folder/a.png "$fingerprint"
not_said folder/a.png "$PWD"
run 0 render scene.json -o a.exr --stats t.json
said t.json "$fingerprint"
said a.exr "$fingerprint"
said a.exr 'fathom render scene.json -o a.exr --stats t.json'
sed -i 's/"radius": 0.8/"radius": 0.7/' scene.json
run 0 render scene.json -o a.exr --stats t.json
not_said t.json "$fingerprint"
SOURCE_DATE_EPOCH=1
export SOURCE_DATE_EPOCH
run 0 render scene.json -o a.png
run 0 render scene.json -o b.png --threads 1
cmp a.png b.png || die 'equal images are other files'
unset SOURCE_DATE_EPOCH
