# fathom bench: that it measures, what it writes; no time is judged.
. "$SOURCE/tests/cli/check.inc"
write_scene

run 2 bench
run 0 help bench
said out.txt 'Usage: fathom bench'
for what in trace render error; do
    run 0 help bench $what
    cp out.txt help.txt
    run 0 bench $what --help
    cmp -s out.txt help.txt || die "fathom bench $what --help is not fathom help bench $what"
    awk 'length($0) > 80 { exit 1 }' out.txt || die "the help of bench $what is wider than 80 columns"
done
rm help.txt
refused 2 'unknown command "trac"; did you mean "trace"?; see fathom help bench' bench trac
refused 2 'unknown command "xyzzy"; see fathom help bench' help bench xyzzy
refused 2 'SCENE is missing; expected it or --triangles' bench render
refused 2 '--triangles: expected a whole number from 1 to' bench render --triangles 1G
refused 3 'none.json' bench render none.json
refused 2 '--spp: expected a whole number from 1 to 65536' bench render scene.json --spp 1,,4
refused 2 '--threads: expected at most 8 numbers' bench render scene.json --threads 1,1,1,1,1,1,1,1,1
run 0 bench -h
said out.txt 'Usage: fathom bench'
refused 2 'spp: the pattern is n x n' bench render scene.json --spp 1,5
refused 2 'no tracer is called "xyzzy"' bench render scene.json --tracer xyzzy
refused 2 'same file' bench render scene.json --json a.txt --csv a.txt
refused 4 'its folder does not exist' bench render scene.json --json no/a.json

# The render phase: everything in all three forms.
run 0 bench render scene.json --spp 1,4 --threads 1,2 --repeats 2 --json r.json --csv r.csv --report render
said out.txt 'all of the render phase:'
for key in bench fathom commit date cpu processors kernels compiler flags embree load scene runs spp seconds read build plan \
    render write rays speeds ceiling renderToBare tracedToBare median low high; do
    said r.json "\"$key\": "
done
[ "$(grep -c '"spp": ' r.json)" -eq 2 ] || die 'expected two runs'
[ "$(number r.json camera)" -eq $((96 * 64)) ] || die 'one camera ray a pixel'
# The rays asked again are those of the render: camera, mirrored; shadows.
camera=$(number r.json camera) mirrored=$(number r.json reflection) shadow=$(number r.json shadow)
[ "$(number r.json closestRays)" -eq $((camera + mirrored)) ] || die 'closest-hit rays'
[ "$(number r.json anyRays)" -eq "$shadow" ] || die 'shadow rays'
[ "$(grep -vc '^#' r.csv)" -eq 5 ] || die 'expected a header and four rows'
awk -F, '!/^#/ { if (n++ && NF != columns) exit 1; columns = NF }' r.csv || die 'rows of different length'
run 0 bench render scene.json --integrator path --spp 4 --threads 1 --repeats 1 --quiet --json r.json
[ "$(number r.json closestRays)" -gt "$(number r.json camera)" ] || die 'expected paths that go on'
refused 2 '--integrator: expected classic|path' bench render scene.json --integrator photons
said render/index.html 'Against the bare calls'
not_said render/index.html '<script'

# Every tracer, scenes by file and by number.
refused 2 'SCENE is missing; expected it or --triangles' bench trace
refused 2 'no tracer is called "xyzzy"' bench trace scene.json --tracer xyzzy
refused 2 '--triangles: expected a whole number' bench trace --triangles 1k,x
run 0 bench trace scene.json --triangles 500,1k --rays 500 --repeats 2 --seconds 0.001 --json t.json --csv t.csv \
    --report trace
for spec in embree:1 embree:4 embree:8 embree:16 embree:raw:16 embree:user:16 bvh linear; do
    [ "$(grep -c "\"spec\": \"$spec\"" t.json)" -eq 3 ] || die "expected $spec once for each scene"
done
for key in triangles primitives tracer buildSeconds buildCpuSeconds bvhBytes rates set query coherent rays met \
    millionRaysPerSecond millionRaysPerCpuSecond; do
    said t.json "\"$key\": "
done
[ "$(grep -c '"set": ' t.json)" -eq $((4 * $(grep -c '"spec": ' t.json))) ] || die 'four kinds of rays for each tracer'
[ "$(grep -vc '^#' t.csv)" -eq $((1 + $(grep -c '"set": ' t.json))) ] || die 'a row for each rate'
awk -F, '!/^#/ { if (n++ && NF != columns) exit 1; columns = NF }' t.csv || die 'rows of different length'
said trace/index.html 'By triangle count'
[ "$(grep -c '<svg' trace/index.html)" -ge 6 ] || die 'six plots'
not_said trace/index.html '<script'

# Alone, a plug-in; a name with a comma stays one field.
printf 'v -1 -1 0\nv 1 -1 0\nv 0 1 0.5\nf 1 2 3\n' >'a, b.obj'
run 0 bench trace 'a, b.obj' --tracer "$BUILD/tests/plugin/culls.so" --rays 64 --repeats 1 --csv p.csv
said p.csv '"a, b.obj"'
run 0 bench trace 'a, b.obj' --tracer bvh --rays 64 --repeats 1 --threads 2 --quiet
silent out.txt

# Rays go on from what the camera sees.
sed 's/"target": .0, 0.7, 0./"target": [0, 5, 9]/' scene.json >sky.json
refused 3 'sky.json: the camera sees nothing; expected hits to send further rays from' bench trace sky.json --tracer bvh
mv 'a, b.obj' 'a "b".obj'
run 0 bench trace 'a "b".obj' --tracer bvh --rays 64 --repeats 1 --csv p.csv
said p.csv '"a ""b"".obj"'

# A tracer without a bare form has no ratio.
run 0 bench render scene.json --spp 1 --threads 1 --repeats 1 --size 32x32 --tracer bvh --json b.json
said out.txt 'no bare calls'
said b.json '"ceiling": null'
# Nor has a scene that is not in Embree's: calls on nothing take no time.
printf '{ "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 } ] }' >ball.json
run 0 bench render ball.json --spp 1 --threads 1 --repeats 1 --size 32x32 --json b.json
said out.txt 'no bare calls'
said b.json '"ceiling": null'

# Generated meshes of several sizes and several tracers: a run for each, and exponents; no file is left.
mkdir tmp
TMPDIR=$PWD/tmp
export TMPDIR
run 0 bench render --triangles 3k,1k --size 64x48 --spp 1 --threads 1 --repeats 2 --tracer embree:low --tracer embree:medium \
    --json g.json --csv g.csv --report growth
said out.txt 'render over bare'
rmdir tmp || die 'files are left'
unset TMPDIR
[ "$(sed -n 's/^ *"triangles": \([0-9]*\),$/\1/p' g.json | tr '\n' ' ')" = '2880 2880 980 980 ' ] || die 'sizes'
for key in fileBytes bvhBytes bvhPeakBytes readSeconds buildSeconds cpu wall fits of exponent half scale sizes; do
    said g.json "\"$key\": "
done
[ "$(grep -c '"sizes": 2' g.json)" -eq 10 ] || die 'five fits of two sizes for each tracer'
[ "$(grep -vc '^#' g.csv)" -eq 5 ] || die 'a header and four rows'
awk -F, '!/^#/ { if (n++ && NF != columns) exit 1; columns = NF }' g.csv || die 'rows of different length'
for plot in Reading Building 'The render phase over the bare calls'; do said growth/index.html ">$plot<"; done

# bench/growth.sh at small size: every size, and more instanced triangles than 32 bits count.
SIZES='1k,2k' REPEATS=1 BILLIONS=430k OPTIONS='--size 64x36 --spp 1' sh "$SOURCE/bench/growth.sh" plots >out.txt ||
    die 'bench/growth.sh'
[ "$(grep -vc '^#' plots/growth.csv)" -eq 3 ] || die 'a header and two rows'
said plots/index.html '>Reading<'
each=$(sed -n 's/^triangles \([0-9]*\) in 1 mesh; .*/\1/p' out.txt)
placed=$(sed -n 's/^triangles .*; \([0-9]*\) with instances$/\1/p' out.txt)
[ "$placed" -gt 4294967296 ] && [ "$placed" -eq $((each * 10000)) ] || die "info: $placed placed, $each each"
said out.txt "; 10000 instances, $placed triangles with them"
