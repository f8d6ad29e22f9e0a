# bench/render.sh at small size: a row for each number of lights and samples. No time is judged.
. "$SOURCE/tests/cli/check.inc"
BUILD=$BUILD MESHES=5k SIZE=160x90 SPP="1 4" sh "$SOURCE/bench/render.sh" 1 >out.txt || die 'bench/render.sh'
[ "$(grep -c '^| 5k | [18] | [14] | .* s | [0-9.]* | [0-9.]* (.*) | [0-9.]* |$' out.txt)" = 4 ] ||
    die 'bench/render.sh: 4 rows'
# bench/read.sh builds its program itself.
BUILD=$BUILD TMPDIR=$PWD sh "$SOURCE/bench/read.sh" 1k 1 >out.txt || die 'bench/read.sh'
[ "$(grep -c '^| .*sphere\.\|^| text.ply' out.txt)" = 4 ] || die 'bench/read.sh: 4 rows'
# A scene that is made for path tracing: the options decide before its settings are judged.
printf '{"image": {"width": 8, "height": 8, "spp": 128, "aovs": ["error"]}, "objects": [{"type": "sphere", "center":
[0, 0, 0], "radius": 1}]}' >path.json
run 0 bench render path.json --spp 4 --repeats 2 --seconds 0 --threads 1
said err.txt 'image.aovs: "error" is left out'
sed 's/"spp": 128/"targetError": 0.05/' path.json >error.json
run 0 bench render error.json --spp 1 --integrator path --repeats 2 --seconds 0 --threads 1 --json r.json --csv r.csv
said out.txt '1 spp, path  read'
said r.json '"integrator": "path"'
grep -q 'write_seconds,integrator$' r.csv && grep -q ',path$' r.csv || die 'no integrator in the CSV'
# What moves, with a time for each ray.
moving=$SOURCE/scenes/light/moving-balls.json
run 0 bench render "$moving" --integrator path --size 16x16 --spp 1 --repeats 2 --seconds 0 --threads 1
refused 3 'which the classic integrator, validation, bench trace' bench render "$moving" --size 16x16 --spp 1 --repeats 2
