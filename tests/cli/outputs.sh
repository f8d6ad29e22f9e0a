# Outputs appear whole or not at all, and what cannot be written is said before anything is rendered.
. "$SOURCE/tests/cli/check.inc"
write_scene

# Several outputs of one render.
run 0 render scene.json -o one.exr -o two.png -o three.jpg -o four.tiff --stats stats.json
said out.txt 'one.exr, two.png, three.jpg, four.tiff: 96x64'
for file in one.exr two.png three.jpg four.tiff stats.json; do [ -s $file ] || die "$file is missing"; done
[ "$(ls -A | wc -l)" -eq 8 ] || die "something was left behind: $(ls -A)"
for file in one.exr two.png three.jpg four.tiff; do same $file $file; done
rm one.exr two.png three.jpg four.tiff stats.json out.txt err.txt

# An output that is there is replaced; one that cannot be made leaves it as it was.
echo old >a.png
run 0 render scene.json -o a.png
same a.png a.png
echo old >a.png
refused 3 'nothing.json: No such file' render nothing.json -o a.png
[ "$(cat a.png)" = old ] || die 'a failed render touched the output'
rm a.png

refused 4 'no/folder/a.png' render scene.json -o no/folder/a.png
mkdir folder.png
refused 4 'folder.png' render scene.json -o folder.png
refused 4 'folder.png' render scene.json -o a.exr --stats folder.png
refused 4 'no/stats.json' render scene.json -o a.exr --stats no/stats.json
rmdir folder.png
refused 2 'unknown image extension "bmp"' render scene.json -o a.bmp
refused 2 'unknown image extension ""' render scene.json -o a
long=$(printf '%01000d/%01000d/%01000d/%01000d' 0 0 0 0)
refused 4 "$long/a.png: cannot be written: its folder: File name too long" render scene.json -o "$long/a.png"
long=$(printf '%0252d' 0)
refused 4 "$long.png: cannot be written: File name too long" render scene.json -o "$long.png"
refused 2 'a.jpg: 65536 x 1 pixels; JPEG holds at most' render scene.json -o a.exr -o a.jpg --size 65536x1
refused 4 'no/a.glb' generate sphere --triangles 100 -o no/a.glb

# One name for two things, however it is spelled.
refused 2 'a.png: the same file is named twice' render scene.json -o a.png -o a.png
refused 2 'the same file is named twice' render scene.json -o a.png -o ./a.png
refused 2 'the same file is named twice' render scene.json -o a.png -o "$PWD/a.png"
refused 2 'the same file is named twice' render scene.json -o a.png --stats a.png
refused 2 'scene.json: is the input' render scene.json -o a.png --stats scene.json
refused 2 'is the input' render scene.json -o a.png --stats ./scene.json
ln -s scene.json link.json
refused 2 'link.json: is the input' render scene.json -o a.png --stats link.json
rm link.json
mkdir folder
run 0 render scene.json -o a.png -o folder/a.png
same a.png folder/a.png
rm -r folder a.png

# A file that the scene names is no output either, which shows while it is read; a checkpoint may be both.
run 0 generate sphere -t 20 -o ball.obj
printf '{ "image": { "integrator": "classic" }, "objects": [ { "type": "mesh", "file": "ball.obj" } ] }' >mesh.json
cat ball.obj ball.mtl >before.txt
for file in ball.obj ball.mtl; do
    clash="$file: is input and output at once; expected another output"
    refused 2 "fathom: mesh.json:1: objects[0].file: $clash" render mesh.json -o a.png --stats $file
    refused 2 "$clash" render mesh.json -o a.png --checkpoint ./$file --resume
    refused 2 "$clash" validate mesh.json --rays 1 --json $file
    refused 2 "$clash" bench trace mesh.json --rays 64 --csv $file
done
cat ball.obj ball.mtl | cmp - before.txt
rm ball.obj ball.mtl mesh.json before.txt

# Bad input: one line, code 3, no output. The readers' own tests know every message; here each kind comes through.
printf '{ "objects": [\n  { "type": "sphere", "radius": -1 }\n] }\n' >bad.json
refused 3 'bad.json:2: objects[0].radius' render bad.json -o a.png
printf '{ "objects": [ }\n' >bad.json
refused 3 'bad.json:1' render bad.json -o a.png
printf '{ "objects": [] }\n' >bad.json
refused 3 'no geometry' render bad.json -o a.png
printf '{ "objects": [\n { "type": "generate", "kind": "sphere", "triangles": 1e11 } ] }' >bad.json
refused 3 'bad.json:2: objects[0]: generate sphere: triangles' render bad.json -o a.png
printf '{ "camera": { "eye": [0, 0, 1e20], "target": [0, 0, 0] },
  "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 } ] }' >bad.json
refused 3 'bad.json: camera: it stands 1e+20 from the scene' render bad.json -o a.png
refused 3 'bad.json: camera: it stands 1e+20 from the scene' info bad.json
printf 'v 0 0 0\nv 1 0 0\nf 1 2 2\n' >bad.obj
refused 3 'bad.obj: the scene holds no geometry with an area' render bad.obj --integrator classic -o a.png
refused 3 'bad.obj: the scene holds no geometry with an area' info bad.obj
printf 'v 0 0 0\nv 1 0 0\nf 1 2 3\n' >bad.obj
refused 3 'bad.obj:3' render bad.obj --integrator classic -o a.png
printf 'glTF' >bad.glb
refused 3 'bad.glb' render bad.glb --integrator classic -o a.png
: >bad.ply
refused 3 'bad.ply: the file is empty' render bad.ply --integrator classic -o a.png
refused 3 'scene.txt' render scene.txt -o a.png
refused 3 'no extension' render scene -o a.png
mkdir folder.json
refused 3 'folder.json: is a folder' render folder.json -o a.png
rmdir folder.json

# A folder that may not be written to; root may write anywhere.
if [ "$(id -u)" -ne 0 ]; then
    mkdir closed
    chmod 555 closed
    refused 4 'closed/a.png' render scene.json -o closed/a.png
    chmod 755 closed
    rmdir closed
fi

# A full disk: what is there stays, nothing half comes.
if [ "$(id -u)" -eq 0 ] && mkdir full && mount -t tmpfs -o size=16k none full 2>/dev/null; then
    code=0
    "$FATHOM" render scene.json -o full/a.tif -o b.png --size 512x512 >out.txt 2>err.txt || code=$?
    left=$(ls -A full)
    umount full
    [ $code -eq 4 ] || die "a full disk: exit code $code, expected 4"
    said err.txt 'full/a.tif: cannot be written'
    [ -z "$left" ] || die "a full disk: $left was left behind"
    same b.png b.png
fi

# A file that is a mount of its own, as containers have them, cannot be replaced: known before anything is rendered.
if [ "$(id -u)" -eq 0 ] && : >mounted.png && mount --bind mounted.png mounted.png 2>/dev/null; then
    code=0
    "$FATHOM" render scene.json -o mounted.png >out.txt 2>err.txt || code=$?
    umount mounted.png
    [ $code -eq 4 ] || die "a file that is mounted: exit code $code, expected 4"
    said err.txt 'mounted.png: cannot be written: Device or resource busy'
    [ ! -e mounted.rescue.exr ] || die 'a file that is mounted: it was rendered'
fi
rm -f mounted.png

# Odd names.
run 0 render scene.json -o 'a name with spaces.png' --stats 'ä.json'
said 'ä.json' '"a name with spaces.png"'
cp scene.json ./-scene.json
run 0 render -o a.png -- -scene.json

# An image that no memory holds is refused before anything is traced for it: 51 GB for its colours alone.
if [ "$(awk '/MemAvailable/ { print $2 }' /proc/meminfo)" -lt 50000000 ]; then
    refused 4 'render a smaller image or a crop' render scene.json -o a.exr --size 65536x65536 --quiet
fi

# Standard output: the same image as in a file, with what is said to people on stderr.
write_scene
run 0 render scene.json -o a.exr -o a.png
for format in png exr jpg tif; do
    "$FATHOM" render scene.json -o $format:- >b.$format 2>err.txt || die "$format to standard output"
    said err.txt "stdout.$format: 96x64"
    [ $format = jpg ] || [ $format = tif ] || same a.$format b.$format
done
"$FATHOM" render scene.json -o c.exr -o - --stats s.json -q >b.png || die 'PNG to standard output, beside a file'
same a.png b.png
same a.exr c.exr
said s.json '"stdout.png"'
"$FATHOM" render scene.json -o exr:- --aov Z -v 2>err.txt | cat >b.exr
said err.txt 'tracer '
run 1 compare b.exr a.exr
said out.txt 'channel Z is only in the first'
"$FATHOM" render scene.json -o c.png --stats - >b.json 2>err.txt || die 'statistics to standard output'
said err.txt 'c.png: 96x64'
[ -n "$(number b.json peakMemoryBytes)" ] || die 'statistics to standard output'
"$FATHOM" bench trace scene.json --rays 64 --repeats 1 --csv - >b.csv 2>err.txt || die 'CSV to standard output'
head -n 1 b.csv | grep -q '^# fathom bench trace' || die 'CSV to standard output'
for arguments in 'render scene.json -o c.png --stats -' 'bench trace scene.json --rays 64 --repeats 1 --json -' \
    'validate scene.json --rays 10 --json -'; do
    # shellcheck disable=SC2086
    "$FATHOM" $arguments 2>err.txt | python3 -m json.tool >/dev/null || die "$arguments: not JSON"
done
rm b.* c.* s.json
refused 2 'standard output is named twice' render scene.json -o - -o exr:-
refused 2 'standard output is named twice' render scene.json -o - --stats -
refused 2 'standard output is named twice' bench trace scene.json --json - --csv -
refused 2 'bmp:-: unknown image extension' render scene.json -o bmp:-
refused 3 'nothing.json: No such file' render nothing.json -o -
# Nothing stays in the folder for temporary files.
mkdir temporary
TMPDIR=$PWD/temporary "$FATHOM" render scene.json -o - -q >b.png
TMPDIR=$PWD/temporary "$FATHOM" render nothing.json -o - >out.txt 2>&1 && die 'a scene that is not there'
rmdir temporary || die 'a temporary file was left behind'
TMPDIR=$PWD/nowhere
export TMPDIR
refused 4 'expected a folder for temporary files in $TMPDIR' render scene.json -o -
unset TMPDIR
if [ -w /dev/full ]; then
    code=0
    "$FATHOM" render scene.json -o - >/dev/full 2>err.txt || code=$?
    [ $code -eq 4 ] || die "an image to a full disk: exit code $code, expected 4"
    said err.txt 'standard output cannot be written: No space left'
    said err.txt 'the pixels are in stdout.rescue.exr'
    run 0 compare a.exr stdout.rescue.exr --tolerance 0.001
fi
if command -v script >/dev/null; then
    script -qec "'$FATHOM' render scene.json -o -" /dev/null </dev/null >tty.txt && die 'an image to a terminal'
    said tty.txt 'standard output is a terminal; expected a pipe or a file'
fi

# Interrupted: what there is goes to standard output, too, and no file is left.
mkdir temporary
TMPDIR=$PWD/temporary
export TMPDIR
"$FATHOM" render scene.json -o - --size 640x480 --pattern sobol --spp 65536 --log json >b.png 2>err.txt &
render=$!
while ! grep -q '"phase": "render"' err.txt && kill -0 $render 2>/dev/null; do sleep 0.05; done
kill $render
code=0
wait $render || code=$?
[ $code -eq 5 ] || die "interrupted: exit code $code, expected 5"
said err.txt 'interrupted; the unfinished image is written to stdout.png'
run 0 compare b.png b.png
rmdir temporary || die "interrupted: left $(ls temporary)"
unset TMPDIR

# The image helper is a part of the installation: without it the machine lacks something, and the message says what.
mkdir alone
cp "$FATHOM" alone/fathom
expect 4 alone/fathom render scene.json -o d.tif
said err.txt 'fathom: image helper: fathom/fathom-image was found neither next to'
said err.txt 'install Fathom again, or write .exr'
alone/fathom render scene.json -o d.png -o d.exr >out.txt 2>err.txt || die 'PNG and EXR need no helper'
alone/fathom --version -v >out.txt
said out.txt 'images    EXR and PNG alone: image helper: '
rm -r alone
