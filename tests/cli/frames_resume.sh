# --frames with --checkpoint and --resume: frames that an earlier run finished are kept, if they still are what this
# run would write.
# shellcheck disable=SC2086 # options are words
. "$SOURCE/tests/cli/check.inc"
export SOURCE_DATE_EPOCH=1700000000

cat >lamp.json <<JSON
{ "camera": { "eye": [0, 0, 5], "target": [0, 0, 0], "fovy": 40 },
  "materials": { "lamp": { "kd": [0, 0, 0], "ke": [9, 9, 9] }, "dim": { "kd": [0, 0, 0], "ke": [0.5, 0.5, 0.5] } },
  "objects": [ { "type": "quad", "center": [0, 0, -1], "u": [1, 0, 0], "v": [0, 1, 0], "material": "dim" },
               { "type": "quad", "center": [0, 0, 0], "u": [1, 0, 0], "v": [0, 1, 0], "material": "lamp",
                 "motion": [ { "time": 0 }, { "time": 3, "translation": [9, 0, 0] } ] } ] }
JSON
frames='lamp.json --size 16x16 --spp 4 --frames 0-3 --fps 1 --exposure auto --checkpoint c#'
outputs='-o f#.png -o f#.exr --stats f#.json'
run 0 render $frames -o 'whole#.png' -o 'whole#.exr'
[ -z "$(ls c? 2>/dev/null)" ] || die 'records are left after the last frame'

# A run that ends before frame 2, because a folder is in the place of its image.
stop_early() {
    rm -rf f?.* c?
    mkdir f2.png
    run 4 render $frames $outputs "$@"
    rmdir f2.png
    [ -s c0 ] && [ -s c1 ] && [ ! -e c2 ] || die 'no records of the finished frames'
    cp f0.json first.json
}
resume() { # exit code, options
    code=$1
    shift
    run "$code" render $frames $outputs --resume "$@"
}
kept() { said out.txt "$1.png: is kept, as an earlier run finished it"; }
not_kept() { not_said out.txt "$1.png: is kept"; }
all_as_one_run() {
    for i in 0 1 2 3; do
        same whole$i.png f$i.png
        run 0 compare whole$i.exr f$i.exr
    done
    [ -z "$(ls c? 2>/dev/null)" ] || die 'records are left after the last frame'
}

# The exposure of frame 0 is that of all, even if this run does not render it.
stop_early
resume 0
kept f0 && kept f1 && not_kept f2
same first.json f0.json
no_messages err.txt
all_as_one_run

# An image that is altered, or gone, is rendered again, and it alone.
stop_early
printf x >>f1.exr
resume 0
kept f0 && not_kept f1
said err.txt 'c1: the images of this finished frame, or the options to write them, have changed; rendering it again'
all_as_one_run
stop_early
rm f0.json
resume 0 -q
silent out.txt
all_as_one_run

# So it is with other options of writing.
stop_early
resume 0 --exr-float
not_kept f0 && not_kept f1
stop_early --exposure 1
resume 0 --exposure 1
kept f1
stop_early --exposure 1
resume 0 --exposure 2
not_kept f1

# So it is with another config of colours under the same name.
view() { # the factor of the view
    cat >view.ocio <<CONFIG
ocio_profile_version: 2
roles: {default: Plain, scene_linear: Plain, aces_interchange: Plain}
displays: {Screen: [!<View> {name: View, colorspace: View}]}
colorspaces:
  - !<ColorSpace> {name: Plain}
  - !<ColorSpace>
    name: View
    to_scene_reference: !<MatrixTransform> {matrix: [$1, 0, 0, 0, 0, $1, 0, 0, 0, 0, $1, 0, 0, 0, 0, 1]}
CONFIG
}
view 2
stop_early --ocio view.ocio
resume 0 --ocio view.ocio
kept f0 && kept f1
view 4
stop_early --ocio view.ocio
view 2
resume 0 --ocio view.ocio
not_kept f0 && not_kept f1

# And with other contents of a file that the config names.
sed 's/!<MatrixTransform> .*/!<FileTransform> {src: view.spi1d, interpolation: linear}/' view.ocio >lut.ocio
lut() { printf 'Version 1\nFrom 0.0 1.0\nLength 2\nComponents 1\n{\n 0.0\n %s\n}\n' "$1" >view.spi1d; }
lut 0.5
stop_early --ocio lut.ocio
resume 0 --ocio lut.ocio
kept f0 && kept f1
lut 0.25
stop_early --ocio lut.ocio
lut 0.5
resume 0 --ocio lut.ocio
not_kept f0 && not_kept f1

# What renders other pixels is refused, as with checkpoints, and nothing is lost.
stop_early
refused 3 'c0: the checkpoint was saved with --spp 4, and this render has 9' \
    render $frames $outputs --resume --spp 9 -q
refused 2 'c0: the file exists, and may hold hours of work' render $frames $outputs -q
sed 's/0.5, 0.5, 0.5/0.5, 0.5, 0.6/' lamp.json >other.json
refused 3 'c0: the checkpoint was saved with a scene of contents' \
    render other.json ${frames#lamp.json} $outputs --resume -q
cp c1 record
head -c 500 record >c1
refused 3 'c1: the record of a finished image is damaged; remove it to render the image again' \
    render $frames $outputs --resume -q
cp record c1
resume 0
kept f0 && kept f1
all_as_one_run
