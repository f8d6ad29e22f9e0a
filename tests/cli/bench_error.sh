# fathom bench error: what it writes, what it refuses; no time is judged.
. "$SOURCE/tests/cli/check.inc"
write_scene

run 0 help bench error
cp out.txt help.txt
run 0 bench error --help
cmp -s out.txt help.txt || die 'fathom bench error --help is not fathom help bench error'
awk 'length($0) > 80 { exit 1 }' out.txt || die 'the help is wider than 80 columns'
rm help.txt
run 0 help bench
said out.txt 'image error against run time'

refused 2 'SCENE is missing; see fathom help bench error' bench error
refused 3 'none.json' bench error none.json
refused 2 '--seeds: expected a whole number from 1 to 100' bench error scene.json --seeds 0
refused 2 '--max-spp' bench error scene.json --max-spp 70000
refused 2 '--ppd' bench error scene.json --ppd 0
refused 2 'no tracer is called "xyzzy"' bench error scene.json --tracer xyzzy
refused 2 'same file' bench error scene.json --json a.txt --csv a.txt
refused 4 'its folder does not exist' bench error scene.json --csv no/a.csv

run 0 bench error scene.json --max-spp 20 --seeds 2 --seed 7 --json e.json --csv e.csv --report page
for text in 'rendering alone is timed' 'two halves of 80 samples' 'pixels that are not finite: 0' 'stratified     16' \
    'RMSE in equal time' 'seconds of CPU time for equal FLIP'; do
    said out.txt "$text"
done
for key in bench fathom commit date machine scene width height seeds build cpuSeconds seconds reference sppOfEach ownError \
    betweenHalves notFinite runs pattern spp seed rays rmse relmse flip curves points belowReference slopes cpu wall \
    slope half equalTime equalError grid stratified sobol error; do
    said e.json "\"$key\": "
done
# Header and three patterns, 1, 4 and 16 samples, seeds 7 and 8; every row whole.
[ "$(grep -vc '^#' e.csv)" -eq 19 ] || die 'expected 18 images'
awk -F, '!/^#/ { if (n++ && NF != columns) exit 1; columns = NF }' e.csv || die 'rows of different length'
[ "$(grep -c '^sobol,16,[78],' e.csv)" -eq 2 ] || die 'seeds are not those asked for'
said page/index.html 'Error against time'
not_said page/index.html '<script'

# Errors depend on samples alone, not on threads or on the tracer that answers.
errors() { sed -n '/^[a-z]*,[0-9]/p' "$1" | cut -d, -f1-3,6-; }
run 0 bench error scene.json --size 32x32 --max-spp 4 --seeds 1 --csv one.csv --quiet --threads 1
silent out.txt
run 0 bench error scene.json --size 32x32 --max-spp 4 --seeds 1 --csv two.csv --quiet --threads 2 --tracer bvh
errors one.csv >one.txt
errors two.csv >two.txt
[ -s one.txt ] || die 'no rows'
cmp -s one.txt two.txt || die 'errors depend on threads or tracer'

# Stated errors: a row for each way of sampling that states some; one scene's classic light has no even ones.
run 0 bench error scene.json --adaptive --size 24x16 --max-spp 16 --reference-spp 16 --seeds 2 --json c.json
for text in 'trusted' 'doubtful' 'alike'; do said out.txt "$text"; done
for key in commit width height seed coverage targetError meanSpp light t values held; do said c.json "\"$key\": "; done
refused 2 '--adaptive: no --csv, --report or --ppd' bench error scene.json --adaptive --size 24x16 --csv c.csv
refused 2 '--adaptive: no --csv, --report or --ppd' bench error scene.json --adaptive --size 24x16 --ppd 20
refused 2 'no tracer is called "nope"' bench error scene.json --adaptive --size 24x16 --tracer nope

# A signal keeps what all patterns have, and says so. The first samples are there in no time, the last ones never.
phase=measure
start bench error scene.json --size 16x16 --max-spp 65536 --seeds 100 --reference-spp 16 --threads 1 --json i.json --csv i.csv
until [ "$(grep -c '"phase": "measure"' err.txt)" -ge 3 ]; do
    kill -0 $child || die 'it ended before it was met'
    sleep 0.05
done
kill -TERM $child
end 5
said err.txt 'interrupted; the results are of '
said out.txt 'the geometric mean of errors'
said i.json '"interrupted": true'
said e.json '"interrupted": false'
for pattern in grid stratified sobol; do
    [ "$(grep -c "^$pattern," i.csv)" -eq "$(grep -c '^grid,' i.csv)" ] || die 'patterns of different length'
done
[ "$(grep -c '^grid,' i.csv)" -ge 1 ] || die 'no rows'

# Before there is an image there is nothing to tell.
start bench error scene.json --size 5000x5000 --max-spp 65536 --json n.json
kill -TERM $child
end 5
said err.txt '"message": "stopped'
silent out.txt
[ ! -e n.json ] || die 'there is a result of nothing'

# A reference that is no better than the images: marked, and in no table.
run 0 bench error scene.json --size 32x32 --max-spp 16 --seeds 1 --reference-spp 1
said out.txt '* closer to the reference than its halves are'
said out.txt 'RMSE in equal time: the patterns have nothing in common here'

# What moves, with a time for each ray.
run 0 bench error "$SOURCE/scenes/light/moving-balls.json" --size 16x16 --max-spp 1 --seeds 1 --reference-spp 4

# One warning of a scene, however often it is rendered.
printf '{"image": {"width": 8, "height": 8}, "lights": [{"type": "point", "position": [0, 0, 0], "intensity": 1}],
"objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]}' >inside.json
run 0 bench error inside.json --adaptive --max-spp 4 --seeds 2 --reference-spp 4
[ "$(grep -c 'lies inside a sphere' err.txt)" = 1 ] || die 'one warning of the light'
