# Each option of render does what its help says, and nothing else.
# shellcheck disable=SC2086 # options are words
. "$SOURCE/tests/cli/check.inc"
write_scene
# Equal images are equal files.
export SOURCE_DATE_EPOCH=1700000000

run 0 render scene.json -o base.exr --exr-float --stats base.json
said out.txt 'base.exr: 96x64, 1 spp, '
no_messages err.txt
same base.exr base.exr

# The two ways to spell a value, and the last one of an option.
run 0 render --output=a.exr scene.json --exr-float --spp=9 --spp 1
same base.exr a.exr

# These options must not change a pixel.
for option in '--threads 1 --seed 5 --size 96x64' '--threads 3 --tile-size 64' '--tile-size 96 --block-width 1' \
    '--block-width 4 --crop 0,0,96,64 --exposure 3' '--block-width 8 --epsilon auto --max-depth 8'; do
    run 0 render scene.json -o a.exr --exr-float $option
    same base.exr a.exr
done

# These must. PNG files are quicker, because the image helper does not write them.
run 0 render scene.json -o base.png
for option in '--spp 4' '--pattern stratified' '--pattern sobol' '--max-depth 0' '--max-depth 1' '--epsilon 0.4' \
    '--background 1,0,0'; do
    run 0 render scene.json -o a.png $option
    differ base.png a.png
done

# Half floats round to 11 bits; nothing here reaches 64, so the error is at most 64 / 2^12.
run 0 render scene.json -o a.exr
differ base.exr a.exr
run 0 compare base.exr a.exr --tolerance 0.015625

run 0 render scene.json -o a.png --size 48x32 --stats a.json
[ "$(number a.json width)x$(number a.json height)" = 48x32 ] || die '--size'
run 0 render scene.json -o a.png --crop 10,20,40,30 --stats a.json
[ "$(number a.json width)x$(number a.json height)" = 30x10 ] || die '--crop'
[ "$(number a.json camera)" = 300 ] || die '--crop: camera rays'
run 0 render scene.json -o a.png --spp 9 --stats a.json
[ "$(number a.json camera)" = 55296 ] || die '--spp: camera rays'
[ "$(number a.json spp)" = 9 ] || die '--spp'
run 0 render scene.json -o a.png --threads 3 --stats a.json
[ "$(number a.json threads)" = 3 ] || die '--threads'

# A crop shows what the whole shows there: what differs from the whole cropped elsewhere is the place alone.
run 0 render scene.json -o a.png --crop 32,32,64,64
run 0 render scene.json -o b.png --crop 32,32,64,64 --tile-size 64
same a.png b.png

# Seeds: jittered samples follow them, one seed is one image.
run 0 render scene.json -o a.png --pattern sobol --spp 3 --seed 1
run 0 render scene.json -o b.png --pattern sobol --spp 3 --seed 1 --threads 1
run 0 render scene.json -o c.png --pattern sobol --spp 3 --seed 2
same a.png b.png
differ a.png c.png

# The scene's own settings hold until the command line says otherwise.
sed 's/"width": 96, "height": 64/"width": 40, "height": 30, "spp": 4, "aovs": ["Z"]/' scene.json >asks.json
run 0 render asks.json -o a.exr --stats a.json
[ "$(number a.json width) $(number a.json spp)" = '40 4' ] || die 'the settings of the scene'
run 0 render asks.json -o b.exr --aov none
run 1 compare a.exr b.exr
said out.txt 'channel Z is only in the first'
run 0 render asks.json -o a.png
said err.txt 'fathom: warning: asks.json: asks for AOVs that no -o FILE holds, as .exr does; they are left out'
# All 0 is the whole image, also of a scene that has a crop.
sed 's/"width": /"crop": [8, 8, 24, 16], &/' scene.json >cropped.json
run 0 render cropped.json -o a.png --stats a.json
[ "$(number a.json width)x$(number a.json height)" = 16x8 ] || die 'the crop of a scene'
run 0 render cropped.json -o a.png --crop 0,0,0,0
run 0 render scene.json -o b.png
same a.png b.png
refused 2 'crop: expected x0 < x1 <= 40' render asks.json -o a.exr --crop 0,0,41,5
refused 2 'so expected a square number such as 1 or 4, found 3' render scene.json -o a.exr --spp 3

# AOVs by name, in any order, and all of them.
run 0 render scene.json -o a.exr --aov Z,alpha
run 0 render scene.json -o b.exr --aov alpha,z
same a.exr b.exr
run 0 render scene.json -o b.exr --aov alpha --aov Z
same a.exr b.exr
run 0 render scene.json -o b.exr --aov alpha --aov none --aov Z
differ a.exr b.exr
run 0 render scene.json -o a.exr --aov all
# The names of channels stand in the head of the file.
for channel in Z:Z N:N.X P:P.X albedo:albedo.R id:id.instance.V samples:samples.V \
    direct:direct.R indirect:indirect.R emission:emission.R lightGroups:light_rest.R; do
    run 0 render scene.json -o b.exr --aov "${channel%:*}"
    head -c 2000 b.exr | tr '\0' '\n' | grep -axE 'Z|[NP].X|albedo.R|id.instance.V|samples.V|(in)?direct.R|emission.R|light_rest.R' >names.txt || true
    [ "$(cat names.txt)" = "${channel#*:}" ] || die "${channel%:*} is not an AOV of its own: $(cat names.txt)"
done
run 0 render scene.json -o a.png --aov alpha
run 0 render scene.json -o b.png
run 1 compare a.png b.png
said out.txt 'channel A is only in the first'

# All of them leave the background as it is, in both files; only alpha takes it away.
run 0 render scene.json -o c.png -o c.exr --aov all
same b.png c.png
run 0 render scene.json -o d.exr --aov all,alpha
run 1 compare d.exr c.exr
said out.txt 'channel A is only in the first'

# Equal renders are equal files where the time is given, and say so where it is no time.
for kind in exr png jpg tif; do
    run 0 render scene.json -o a.$kind
    run 0 render scene.json -o b.$kind --threads 1
    cmp a.$kind b.$kind || die "equal renders, other $kind"
done
grep -qa '2023:11:14 22:13:20' a.exr || die 'the date is not the one that was given'
grep -qa renderTime a.exr && die 'a time of this render alone'
for wrong in soon -1 1e9 99999999999999; do
    SOURCE_DATE_EPOCH=$wrong
    refused 2 'SOURCE_DATE_EPOCH: expected seconds since 1970' render scene.json -o c.exr
done
unset SOURCE_DATE_EPOCH
run 0 render scene.json -o a.exr
grep -qa renderTime a.exr || die 'no time of the render'

# Colour: display formats only.
run 0 render scene.json -o a.png -o a.exr -o a.jpg -o a.tif
run 0 render scene.json -o b.png -o b.exr -o b.jpg -o b.tif --exposure 1
same a.exr b.exr
for kind in png jpg tif; do differ a.$kind b.$kind; done
same a.png a.tif

# A light that clips is named with the exposure that is taken, or to try if another was given; auto takes that one, too.
sed 's/"intensity": 25/"intensity": 20000/' scene.json >bright.json
run 0 render bright.json -o a.png
said err.txt ' % of the pixels that show objects are white, under a light of intensity 20000, so the exposure is '
exposure=$(sed -n 's/.*the exposure is \([-0-9.]*\);.*/\1/p' err.txt)
run 0 render bright.json -o b.png --exposure 0
said err.txt "try --exposure $exposure, or --exposure auto"
differ a.png b.png
run 0 render bright.json -o b.png --exposure auto --stats b.json
no_messages err.txt
said out.txt "exposure $exposure"
said b.json "\"exposure\": $exposure"
grep -qa 'fathom:exposure' b.png || die 'the exposure is not in the header'
run 0 render bright.json -o c.png --exposure "$exposure"
no_messages err.txt
same b.png c.png
same a.png c.png
run 0 render bright.json -o a.part --part 1/1
run 0 merge a.part -o d.png
said err.txt "so the exposure is $exposure"
same a.png d.png
run 0 render bright.json -o a.exr
no_messages err.txt
# A faint light is not to blame for what others do.
sed 's/"intensity": 25/"intensity": 0.5/; s/^{/{ "ambient": [255, 255, 255],/' scene.json >faint.json
run 0 render faint.json -o c.png
said err.txt ' % of the pixels that show objects are white, so the exposure is '
# In the studio a white model is shown darker, also by merge; a gray one is not.
for white in 1 0.4; do
    printf 'newmtl m\nKd %s %s %s\n' $white $white $white >studio.mtl
    printf 'mtllib studio.mtl\nusemtl m\nv 0 0 0\nv 1 0 1\nv 0 1 0\nv 1 1 1\nf 1 2 4 3\n' >studio.obj
    run 0 render studio.obj -o $white.png --size 32x32 --spp 16
    no_messages err.txt
    said out.txt ', in the studio, '
    if [ $white = 1 ]; then said out.txt ', exposure -0.'; else grep -q exposure out.txt && die 'gray is shown darker'; fi
    run 0 render studio.obj -o 0.png --size 32x32 --spp 16 --exposure 0
    if [ $white = 1 ]; then differ 1.png 0.png; else same 0.4.png 0.png; fi
    run 0 render studio.obj --size 32x32 --spp 16 --part 1/1 -o $white.part
    run 0 merge $white.part -o 0.png
    same $white.png 0.png
done
# An image on a screen is light that no estimate counts: then the file alone lights.
printf 'P6\n1 1\n255\n\377\200\100' >screen.ppm
cat >screen.json <<'JSON'
{ "camera": { "eye": [0, 1, 4], "target": [0, 0.8, 0], "fovy": 50 },
  "materials": { "screen": { "kd": [0, 0, 0], "ke": [5, 5, 5], "keTexture": { "file": "screen.ppm" } }, "matt": { "kd": [0.5, 0.5, 0.5] } },
  "objects": [ { "type": "quad", "center": [0, 0, 0], "u": [3, 0, 0], "v": [0, 0, -3], "material": "matt" },
               { "type": "quad", "center": [0, 1, -1], "u": [1, 0, 0], "v": [0, 0.5, 0], "material": "screen" } ] }
JSON
screen='--size 32x18 --spp 16'
sed 's/"materials"/"lights": [], &/' screen.json >unlit.json
{
    run 0 render screen.json $screen -o a.exr
    said out.txt ', in the studio, '
    run 0 render screen.json $screen -o b.exr --no-studio
    not_said out.txt studio
    run 0 render unlit.json $screen -o c.exr
}
run 1 compare a.exr b.exr
run 0 compare b.exr c.exr --tolerance 0
rm ./?.exr
sed 's/"intensity": 25/"intensity": 0.01/; s/"background": .*/"background": [0, 0, 0],/' scene.json >dark.json
run 0 render dark.json -o a.png
said err.txt 'of the lit pixels are nearly black, below 8 of 255 levels, so the exposure is '
run 0 render dark.json -o b.png --exposure auto
same a.png b.png
sed 's/"lights": .*/"lights": [],/' scene.json >black.json
run 0 render black.json -o a.exr --max-depth 0
said err.txt 'all that is in view is black: the camera sees no object or is inside one, or the scene has no lights'
sed 's/"lights": .*/"lights": [],/; /"background"/d' scene.json >black.json
run 0 render black.json -o a.exr --max-depth 0
said err.txt 'the scene has no lights; give it some, or leave out its empty list of lights, or --no-studio'
# There is no floor, nor a studio, to remove where the scene has its own camera or lights.
run 0 render scene.json -o a.exr --max-depth 0 --no-floor --no-studio
said err.txt 'scene.json: has its own camera, so --no-floor has no effect'
said err.txt 'scene.json: has its own lights, so --no-studio has no effect'
printf '{ "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 } ] }' >bare.json
run 0 render bare.json -o a.exr --size 8x8 --spp 1 --no-floor --no-studio
not_said err.txt 'has no effect'
# A camera that sees nothing is probably a mistake, but not of a crop, nor of one frame of many.
printf '{ "image": { "width": 8, "height": 8, "spp": 4 }, "camera": { "eye": [0, 0, 9], "target": [0, 0, 10] }, "background": [1, 1, 1],
  "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1, "motion": [ { "time": 0 }, { "time": 1, "translation": [1, 0, 0] } ] } ] }' >away.json
run 0 render away.json -o a.exr
said err.txt 'away.json: the image shows only the background: no object is in view, or all look like it'
run 0 render away.json -o a.exr --crop 0,0,4,4
not_said err.txt 'only the background'
run 0 render away.json -o f.#.exr --frames 0-1
not_said err.txt 'only the background'
sed 's/"objects": .*/"objects": [] }/' away.json >none.json
run 0 render none.json -o a.exr
not_said err.txt 'only the background'
# Once for all frames.
printf '{ "image": { "aovs": ["Z"], "spp": 1 }, "camera": { "eye": [0, 0, 9], "target": [0, 0, 0] }, "lights": [], "objects": [
  { "type": "sphere", "center": [0, 0, 0], "radius": 1, "motion": [ { "time": 0 }, { "time": 1, "translation": [1, 0, 0] } ] } ] }' >move.json
run 0 render move.json -o f.#.png --frames 0-2 --fps 24 --size 8x8 --no-floor
for text in 'so --no-floor has no effect' 'asks for AOVs that no -o FILE holds'; do
    [ "$(grep -c -e "$text" err.txt)" = 1 ] || die "not once: $text"
done
refused 2 '--leave-out-below 8bit: needs the exposure' \
    render scene.json -o c.png --leave-out-below 8bit --exposure auto
# What no output takes is refused rather than dropped.
refused 2 '--exr-float: only with -o FILE.exr' render scene.json -o c.png --exr-float
# Half floats end at 65504, and that is told.
printf '{ "image": { "width": 8, "height": 8, "spp": 4 }, "camera": { "eye": [0, 0, 9], "target": [0, 0, 0] },
  "background": [65505, 0, 0], "objects": [] }' >bright.json
run 0 render bright.json -o bright.exr
said err.txt 'bright.json: the .exr shows pixels above 65504 as 65504, the largest half float; --exr-float keeps them'
for option in '-o bright.exr --exr-float' '-o bright.png --exposure 0' '-o bright.exr --background 65504,0,0'; do
    run 0 render bright.json $option
    not_said err.txt 'half float'
done
# Those of dark images have few digits.
for radiance in 0.00005 0.0001; do
    printf '{ "image": { "width": 8, "height": 8, "spp": 4 }, "materials": { "m": { "ke": [%s, 0, 0] } }, "lights": [],
      "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m" } ] }' $radiance >dark.json
    run 0 render dark.json -o dark.exr
    [ $radiance = 0.0001 ] || said err.txt 'dark.json: the .exr has few digits of pixels as dark as these'
    [ $radiance = 0.00005 ] || not_said err.txt 'half floats'
done
for option in view display; do
    refused 2 "--$option: only with an image for the display, such as -o FILE.png" render scene.json -o c.exr --$option x
    refused 2 "--$option: only with an image for the display" merge 0.part -o c.exr --$option x
done
refused 2 '--exposure auto: is for the image' render scene.json -o c.part --part 1/2 --exposure auto
for option in '--exr-float' '--view x'; do
    refused 2 "${option% *}: is for the image, which fathom merge writes" render scene.json -o c.part --part 1/2 $option
done
refused 2 '--exr-float: only with -o FILE.exr' merge 0.part -o c.png --exr-float
refused 2 '--min-weight: only with --integrator classic' render scene.json -o c.png --integrator path --min-weight 0.1
refused 2 '--exposure: expected a number' render scene.json -o c.png --exposure much

printf 'newmtl a\nKd 0.6 0.6 0.6\nd 0\n' >clear.mtl
printf 'mtllib clear.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >clear.obj
run 0 render clear.obj --integrator classic -o a.png
said err.txt 'all surfaces are fully transparent'
# A volume that absorbs shows itself to paths.
printf '{"materials": {"wine": {"model": "metallicRoughness", "transmission": 1, "thickness": 1, "roughness": 0, "ior": 1, "specular": 0,
"attenuationColor": [1, 0.1, 0.1], "attenuationDistance": 0.5}}, "background": [1, 1, 1],
"objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "wine"}]}' >wine.json
run 0 render wine.json -o a.png --size 32x32 --spp 4
no_messages err.txt
run 0 render wine.json -o a.png --size 32x32 --spp 4 --integrator classic
said err.txt 'all surfaces are fully transparent'

refused 2 'No Such View' render scene.json -o c.png --view 'No Such View'
refused 2 'No Such Display' render scene.json -o c.png --display 'No Such Display'
refused 3 'missing.ocio' render scene.json -o c.png --ocio missing.ocio
mkfifo pipe.ocio
refused 3 'pipe.ocio: cannot be read: is not a regular file' render scene.json -o c.png --ocio pipe.ocio
OCIO=/dev/zero refused 3 '($OCIO) /dev/zero: cannot be read: is not a regular file' render scene.json -o c.tif
rm pipe.ocio
run 0 render scene.json -o c.exr --exr-float
same base.exr c.exr

# The facets of a coarse smooth mesh shadow themselves only when asked to.
run 0 generate sphere --triangles 200 -o coarse.glb
run 0 render coarse.glb --integrator classic -o a.png --size 96x64 --spp 1
run 0 render coarse.glb --integrator classic -o b.png --size 96x64 --spp 1 --no-terminator-fix
differ a.png b.png

# The tracers agree but where rounding moves an edge: 1 pixel in 100 at most, and those are few of 6144.
run 0 render scene.json -o a.exr --exr-float --tracer reference --stats a.json
said a.json '"tracer": "reference"'
said base.json '"tracer": "Embree '
code=0
"$FATHOM" compare base.exr a.exr --tolerance 1e-4 >out.txt || code=$?
pixels=$(sed -n 's/.*, \([0-9]*\) of 6144 pixels.*/\1/p' out.txt)
[ "$pixels" -le 61 ] || die "the tracers differ in $pixels pixels"

# How much is said.
run 0 render scene.json -o a.png --quiet
silent out.txt
no_messages err.txt
run 0 render scene.json -o a.png -v
for line in scene tracer seconds rays memory; do grep -q "^$line  " out.txt || die "-v says no $line"; done

# An image of the sky lights a model, and takes the place of a scene's background and environments.
printf 'PF\n4 2\n-1.0\n' >sky.pfm
python3 -c 'import struct, sys
sys.stdout.buffer.write(struct.pack("<24f", *([0.1] * 12 + [0.5, 0.6, 0.9] * 2 + [4, 3, 2] + [0.5, 0.6, 0.9])))' >>sky.pfm
run 0 generate sphere --triangles 2k -o ball.glb
for option in '' '--up z' '--environment-rotation 90'; do
    run 0 render ball.glb -o ball.png --size 64x48 --spp 4 --environment sky.pfm $option
    [ ! -e before.png ] || differ before.png ball.png
    cp ball.png before.png
done
printf '{ "image": { "width": 64, "height": 48, "spp": 4 }, "camera": { "eye": [0, 0, 4], "target": [0, 0, 0] },
  "background": [9, 0, 0], "lights": [%s],
  "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 } ] }' \
    '{ "type": "environment", "file": "sky.pfm", "intensity": 7, "group": "sky" },
     { "type": "environment", "file": "sky.pfm", "group": "second" }' >skies.json
printf '{ "image": { "width": 64, "height": 48, "spp": 4 }, "camera": { "eye": [0, 0, 4], "target": [0, 0, 0] },
  "lights": [ { "type": "environment", "file": "sky.pfm", "rotation": 30 } ],
  "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 } ] }' >one_sky.json
run 0 render skies.json -o a.exr --aov lightGroups --environment sky.pfm --environment-rotation 30
run 0 render skies.json -o a.png --environment sky.pfm --environment-rotation 30
run 0 render one_sky.json -o b.png
same a.png b.png
run 2 render ball.glb -o a.png --environment sky.pfm --background 1,1,1
said err.txt 'environment and --background exclude each other'
run 2 render ball.glb -o a.png --environment-rotation 5
said err.txt 'only with --environment FILE'
run 2 render ball.glb -o a.png --environment sky.pfm --integrator classic
said err.txt 'the classic integrator has no light from images'
run 3 render ball.glb -o a.png --environment no.hdr
said err.txt 'no.hdr'
# Numbers of 8 bits are colours for a display, whatever the format.
printf 'P6\n2 1\n255\nabcdef' >bytes.ppm
run 3 render ball.glb -o a.png --environment bytes.ppm
said err.txt 'bytes.ppm: expected an image of linear radiance (.exr, .hdr, .pfm, .tif); this one has 8 bits'
# What cannot be read only turns out in the render; the scene's line and field are named all the same.
echo no image >cut.pfm
sed 's/sky.pfm/cut.pfm/' one_sky.json >cut_sky.json
for integrator in path reference; do
    run 3 render cut_sky.json -o a.png --integrator $integrator
    said err.txt 'fathom: cut_sky.json:2: lights[0].file: cut.pfm: '
done
run 0 render cut_sky.json -o a.png --environment sky.pfm --spp 1

# A file's own spp and pattern, meant for path tracing, are judged only once the options are applied.
printf '{"image": {"width": 8, "height": 8, "spp": 128}, "objects": [{"type": "sphere", "center": [0, 0, 0],
"radius": 1}]}' >path.json
run 0 render path.json -o a.png --integrator classic --spp 4
run 0 render path.json -o b.png --integrator classic --spp 4 --pattern grid
same a.png b.png
run 0 render path.json -o a.png --integrator classic
run 0 render path.json -o b.png --integrator classic --pattern sobol
same a.png b.png
refused 2 'spp: the pattern is n x n' render path.json -o c.png --integrator classic --pattern grid
refused 2 'spp: the pattern is n x n' render path.json -o c.png --integrator classic --spp 5
