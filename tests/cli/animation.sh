# Animations, variants and units of models, as options say; frames.
# shellcheck disable=SC2086 # options are words
. "$SOURCE/tests/cli/check.inc"
# Equal PNG files need no other judge, and no image helper writes them.
export SOURCE_DATE_EPOCH=1700000000

# A triangle that moves by half its width in a second, and a camera.
cat >moving.gltf <<JSON
{ "asset": { "version": "2.0" },
  "buffers": [ { "byteLength": 68, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAAA/AAAAAAAAAAA=" } ],
  "bufferViews": [ { "buffer": 0, "byteLength": 36 }, { "buffer": 0, "byteOffset": 36, "byteLength": 8 },
                   { "buffer": 0, "byteOffset": 44, "byteLength": 24 } ],
  "accessors": [ { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 },
                 { "bufferView": 1, "componentType": 5126, "type": "SCALAR", "count": 2 },
                 { "bufferView": 2, "componentType": 5126, "type": "VEC3", "count": 2 } ],
  "meshes": [ { "primitives": [ { "attributes": { "POSITION": 0 } } ] } ],
  "cameras": [ { "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1 } } ],
  "nodes": [ { "mesh": 0 }, { "camera": 0, "translation": [0.4, 0.4, 2] } ],
  "animations": [ { "name": "slide", "samplers": [ { "input": 1, "output": 2 } ],
                    "channels": [ { "sampler": 0, "target": { "node": 0, "path": "translation" } } ] } ] }
JSON
small='--size 48x48 --integrator classic --spp 1'

# At rest, and at each time another image; before the first key and after the last one it rests.
render() { # options, image
    run 0 render moving.gltf $small $1 -o "$2"
}
render '' rest.png
said err.txt 'animations are not played; --time SECONDS poses them: 0 "slide" (1 such)'
render '--time 0' a.png
not_said err.txt animation
same rest.png a.png
render '--animation slide' a.png
same rest.png a.png
render '--time -3' a.png
same rest.png a.png
render '--time 0.5' half.png
differ rest.png half.png
render '--time 1' end.png
differ half.png end.png
render '--time 7' a.png
same end.png a.png
render '--time 0.5 --threads 1' a.png
same half.png a.png
refused 2 'moves what another of the chosen animations moves' render moving.gltf -o a.png --animation slide --animation 0
refused 2 'there is no animation "walk"; expected one of 0 "slide"' render moving.gltf -o a.png --animation walk
write_scene
refused 2 'has nothing that moves, so a time has no effect' render scene.json -o a.png --time 1
refused 2 'has no animations to pose' render scene.json -o a.png --animation walk
refused 2 'has no scenes to choose "walk" from' render scene.json -o a.png --scene walk

# Frames are the images of their times.
run 0 render moving.gltf $small -o 'f.####.png' --frames 0-2 --fps 2 --stats 'f##.json'
same rest.png f.0000.png
same half.png f.0001.png
same end.png f.0002.png
[ "$(number f02.json width)" = 48 ] || die 'a file of statistics for each frame'
run 0 render moving.gltf $small -o 'g#.png' --frames 12 --time 0.5 --fps 24
# The last # counts: folders may have their own.
mkdir 'job#7'
run 0 render moving.gltf $small -o 'job#7/g##.png' --frames 12 --time 0.5 --fps 24
same g12.png 'job#7/g12.png'
same end.png g12.png
# What all frames would say is said once, and stands in the statistics of each.
sed 's|"nodes": \[ {|"nodes": [ { "extensions": { "X_none": {} },|' moving.gltf >odd.gltf
run 0 render odd.gltf $small -o 'w#.png' --frames 0-2 --fps 2 --stats 'w#.json'
[ "$(grep -c 'the extension X_none is ignored' err.txt)" = 1 ] || die 'a warning that each frame repeats'
said w2.json 'the extension X_none is ignored'
# All have the exposure of frame 0, also those that another command renders: here of a lamp that leaves, after which a dim
# one is left.
cat >lamp.json <<JSON
{ "camera": { "eye": [0, 0, 5], "target": [0, 0, 0], "fovy": 40 },
  "materials": { "lamp": { "kd": [0, 0, 0], "ke": [9, 9, 9] }, "dim": { "kd": [0, 0, 0], "ke": [0.5, 0.5, 0.5] } },
  "objects": [ { "type": "quad", "center": [0, 0, -1], "u": [1, 0, 0], "v": [0, 1, 0], "material": "dim" },
               { "type": "quad", "center": [0, 0, 0], "u": [1, 0, 0], "v": [0, 1, 0], "material": "lamp",
                 "motion": [ { "time": 0 }, { "time": 1, "translation": [9, 0, 0] } ] } ] }
JSON
lamp="lamp.json --size 16x16 --spp 4 --fps 1 --exposure auto"
run 0 render $lamp -o 'h#.png' --stats 'h#.stats' --frames 0-1
run 0 render $lamp -o 'i#.png' --stats 'i#.stats' --frames 1-1
[ "$(number h0.stats exposure)" = "$(number h1.stats exposure)" ] || die 'frames of two exposures'
[ "$(number h0.stats exposure)" = "$(number i1.stats exposure)" ] || die 'the frame of another command has its own exposure'
same h1.png i1.png
said out.txt 'exposure -3.3, by frame 0'
run 0 render lamp.json --size 16x16 --spp 4 --exposure auto -o dim.png --stats dim.stats --time 1
[ "$(number h0.stats exposure)" != "$(number dim.stats exposure)" ] || die 'the dim lamp alone has its own exposure'
# Parts of frames keep the exposure of frame 0: the merged images are those of one command.
sed '1s/{ /{ "lights": [], /' lamp.json >parts.json
parts="parts.json --size 16x16 --spp 8 --fps 1 --frames 0-1"
run 0 render $parts -o 't#.png'
for part in 1 2; do
    run 0 render $parts -o "t#.$part.part" --part $part/2
    said out.txt 'exposure -3.3, by frame 0'
done
for frame in 0 1; do
    run 0 merge t$frame.1.part t$frame.2.part -o u$frame.png
    said out.txt ', exposure -3.3'
    same t$frame.png u$frame.png
done
run 0 merge t1.1.part t1.2.part -o u.png --exposure 0
differ t1.png u.png
# The sky behind an object is no part of an image with alpha.
cat >alpha.json <<JSON
{ "camera": { "eye": [0, 0, 5], "target": [0, 0, 0], "fovy": 40 }, "background": [9, 9, 9],
  "materials": { "matt": { "kd": [0.02, 0.02, 0.02] } },
  "objects": [ { "type": "quad", "center": [0, 0, 0], "u": [1, 0, 0], "v": [0, 1, 0], "material": "matt",
                 "motion": [ { "time": 0 }, { "time": 1, "translation": [0.1, 0, 0] } ] } ] }
JSON
alpha="alpha.json --size 32x32 --spp 16 --exposure auto --aov alpha"
run 0 render $alpha -o one.png --stats one.stats --time 0
run 0 render $alpha -o 's#.png' --stats 's#.stats' --frames 0
[ "$(number s0.stats exposure)" = "$(number one.stats exposure)" ] || die "a sequence's alpha has another exposure"
# A black frame 0 tells none, so the first lit frame of each command does: here when the lamp has come in.
sed 's/"ke": \[0.5, 0.5, 0.5\]/"ke": [0, 0, 0]/; s/{ "time": 0 }, { "time": 1, "translation": \[9, 0, 0\] }/{ "time": 0, "translation": [9, 0, 0] }, { "time": 1 }/
     1s/{ /{ "lights": [], /' lamp.json >late.json
late="late.json --size 16x16 --spp 4 --fps 1 --exposure auto"
run 0 render $late -o 'q#.png' --stats 'q#.stats' --frames 0-1
run 0 render $late -o 'r#.png' --stats 'r#.stats' --frames 1
[ "$(number q0.stats exposure)" = 0.0 ] || die 'an exposure by a black frame'
[ "$(number q1.stats exposure)" = "$(number h0.stats exposure)" ] || die 'a black frame keeps its exposure'
[ "$(number r1.stats exposure)" = "$(number h0.stats exposure)" ] || die 'no exposure by the first frame that is lit'
# Without a camera in the file they share one, as do frames that another command renders. The triangle rests in the last
# frames: these are equal. It stands farther away than in an image of its own, because all of its way is in view.
sed 's/"camera": 0, "translation"/"translation"/' moving.gltf >framed.gltf
framed='framed.gltf --size 32x32 --spp 4 --exposure 0'
run 0 render $framed -o 'j#.png' --frames 0-4 --fps 2
run 0 render $framed -o 'k#.png' --frames 2-4 --fps 2
run 0 render $framed -o l.png --time 1
run 0 render $framed -o p.png --time 0
same j2.png j3.png
same j2.png j4.png
same j2.png k2.png
differ j2.png l.png
differ j0.png p.png
# Frames in which a scale of zero hides all are empty, and end nothing. Without a camera, the other frames place it.
growing='AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AACAPwAAgD8='
sed "s|base64,[^\"]*|base64,$growing|; s/\"path\": \"translation\"/\"path\": \"scale\"/" moving.gltf >growing.gltf
run 0 render growing.gltf $small -o 'm#.png' --frames 0-2 --fps 2
said err.txt 'is scaled to nothing, and left out'
sed 's|{ "mesh": 0 }|{ "mesh": 0, "scale": [1e-12, 1e-12, 1e-12] }|' moving.gltf >tiny.gltf
run 0 render tiny.gltf $small -o t.png --time 0
said err.txt 'is scaled to nothing, and left out'
differ m0.png m1.png
same m2.png rest.png
sed 's/"camera": 0, "translation"/"translation"/' growing.gltf >alone.gltf
run 0 render alone.gltf --size 32x32 --spp 4 --exposure 0 -o 'n#.png' --frames 0-2 --fps 2
differ n0.png n1.png
run 0 render alone.gltf --size 32x32 --spp 4 --exposure 0 -o 'o#.png' --frames 0
same n0.png o0.png
run 3 render alone.gltf --size 32x32 -o no.png --time 0
said err.txt 'alone.gltf: everything is hidden or scaled to nothing'
# Such a frame as scene JSON; models hold shapes.
run 0 render growing.gltf $small -o empty.png --time 0
run 0 convert growing.gltf empty.json --time 0
run 0 render empty.json $small -o again.png
same empty.png again.png
run 2 convert growing.gltf no.glb --time 0
said err.txt 'no.glb: the scene holds no shape to write: everything is hidden'
run 3 convert alone.gltf no.json --time 0
said err.txt 'everything is hidden or scaled to nothing'
[ ! -e no.glb ] && [ ! -e no.json ] || die 'a file was written'
refused 2 'expected a name with #### for the number, found "a.png"' render moving.gltf -o a.png --frames 1-3
for out in exr:- -; do
    refused 2 '--frames: standard output is one file; expected a name with #### for the number' \
        render moving.gltf -o $out --frames 1-3
done
for frames in 3-1 -5 1--5 1-1000000 '1- 2' 1-2-3 -; do
    refused 2 "--frames: expected FIRST-LAST with FIRST <= LAST <= 999999, such as 1-24, found \"$frames\"" \
        render moving.gltf -o 'a#.png' --frames "$frames"
done
refused 2 '--fps: only with --frames' render moving.gltf -o a.png --fps 25
refused 2 '-o a.####.png: #### stands for a frame' render moving.gltf -o a.####.png

# An open shutter blurs what moves, as motion in scene JSON does, to the last bit; JSON's own motion too.
sed 's/"animations"/"nothing"/' moving.gltf >still.gltf
cat >moving.json <<JSON
{ "camera": { "eye": [0.4, 0.4, 2], "target": [0.4, 0.4, 1], "d": 1, "h": 0.84558643747632356 },
  "objects": [ { "type": "mesh", "file": "still.gltf",
    "motion": [ { "time": 0 }, { "time": 1, "translation": [0.5, 0, 0] } ] } ] }
JSON
blurred='--size 48x48 --spp 16 --time 0.25 --shutter 0.5'
{
    run 0 render moving.gltf $blurred -o blurred.exr
    run 0 render moving.json $blurred -o json.exr
    run 0 render moving.gltf --size 48x48 --spp 16 --time 0.25 -o a.exr
}
run 0 compare blurred.exr json.exr
run 1 compare blurred.exr a.exr
# A scene's own shutter blurs its models' animations, too.
sed 's/"d": 1/"shutter": [3, 3.5], "d": 1/; s/still.gltf",/moving.gltf" } ] }/; /"motion"/d' moving.json >own.json
run 0 render own.json --size 48x48 --spp 16 --time 0.25 -o a.exr
run 0 compare blurred.exr a.exr
rm ./*.exr
run 0 render moving.json --size 16x16 --spp 1 -o a.png
said err.txt 'moving.json: has motion, but no shutter, so everything stands still at time 0; give the camera a shutter'
# A shutter of no time is still, whatever the file says.
sed 's/"d": 1/"shutter": [0, 0.5], "d": 1/' moving.json >open.json
run 0 render open.json --size 16x16 --spp 4 -o open.png
run 0 render open.json --size 16x16 --spp 4 --shutter 0 -o shut.png
run 0 render open.json --size 16x16 --spp 4 --time 0.25 --shutter 0 -o later.png
differ open.png shut.png
differ shut.png later.png
run 0 render moving.json --size 16x16 --spp 4 --time 0 -o a.png
same a.png shut.png
refused 2 'has nothing that moves, so a shutter has no effect' render still.gltf -o a.png --shutter 1

# A time alone shows motion where it is then: placements, vertices and cameras, to the last bit.
at_time() { # time, x of the ball, y of the triangle's corner, z of the camera
    cat >moves.json <<JSON
{ "camera": { "motion": [ { "time": 0, "eye": [0, 0, 4], "target": [0, 0, 0] }, { "time": 2, "eye": [0, 0, 6], "target": [0, 0, 0] } ], "d": 1, "h": 1 },
  "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 0.5, "motion": [ { "time": 0 }, { "time": 2, "translation": [1, 0, 0] } ] },
               { "type": "mesh", "positions": [[-1, 0, 0], [0, 0, 0], [-1, 1, 0]], "indices": [[0, 1, 2]],
                 "vertexKeys": [ { "time": 0, "positions": [[-1, 0, 0], [0, 0, 0], [-1, 1, 0]] }, { "time": 2, "positions": [[-1, 0, 0], [0, 0, 0], [-1, -1, 0]] } ] } ] }
JSON
    cat >stands.json <<JSON
{ "camera": { "eye": [0, 0, $4], "target": [0, 0, 0], "d": 1, "h": 1 },
  "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 0.5, "translation": [$2, 0, 0] },
               { "type": "mesh", "positions": [[-1, 0, 0], [0, 0, 0], [-1, $3, 0]], "indices": [[0, 1, 2]] } ] }
JSON
    run 0 render moves.json --size 32x32 --spp 4 --time "$1" -o moves.exr
    no_messages err.txt
    run 0 render stands.json --size 32x32 --spp 4 -o stands.exr
    run 0 compare moves.exr stands.exr
    rm moves.exr stands.exr
}
at_time 0.5 0.25 0.5 4.5
at_time 1.5 0.75 -0.5 5.5
at_time 9 1 -1 6

# A model of that time has its vertices there.
run 0 convert moves.json posed.obj --time 0.5
said posed.obj 'v -1 0.5 0'
rm posed.obj posed.mtl

# A file's own shutter opens at that time and stays open as long; frames do the same.
sed 's/"d": 1,/"d": 1, "shutter": [5, 5.5],/' moves.json >own.json
run 0 render own.json --size 32x32 --spp 4 --time 0.5 -o own.exr
run 0 render moves.json --size 32x32 --spp 4 --time 0.5 --shutter 0.5 -o a.exr
run 0 compare own.exr a.exr
run 0 render own.json --size 32x32 --spp 4 --frames 0-1 --fps 2 -o 'own.#.exr'
run 0 compare own.1.exr a.exr
run 1 compare own.0.exr own.1.exr
rm ./*.exr
refused 2 'stands.json: has nothing that moves' render stands.json -o a.png --time 1

# Units scale the scene; an image without lamps looks the same.
run 0 info moving.gltf --unit cm --json
grep -q '0\.01' out.txt || die '--unit cm'
refused 2 'which scales each model by itself' render scene.json -o a.png --unit mm

# The keys alone place a camera, also after conversion.
printf '{"camera": {"fovy": 40, "shutter": [0, 1], "motion": [{"time": 0, "eye": [0, 0, 4], "target": [0, 0, 0]},
{"time": 2, "eye": [1, 0, 5], "target": [0, 0, 0]}]}, "image": {"width": 32, "height": 32, "spp": 4},
"objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1}]}' >keys.json
run 0 convert keys.json keys2.json
run 0 render keys.json -o a.exr
run 0 render keys2.json -o b.exr
run 0 compare a.exr b.exr --tolerance 1e-4
sed 's/"fovy": 40/"lensRadius": 0.1/' keys.json >lens.json
refused 3 'a lens needs "focusDistance" where "motion" places the camera' render lens.json -o c.png
rm keys.json keys2.json lens.json a.exr b.exr

# Keys half a turn or more apart do not turn as their angles say: told once for each object, not below.
spin() { # the angles of three keys; further options
    printf '{"camera": {"eye": [0, 0, 4], "target": [0, 0, 0], "shutter": [0, 1]}, "image": {"width": 8, "height": 8, "spp": 4},
"objects": [{"type": "quad", "center": [0, 0, 0], "u": [1, 0, 0], "v": [0, 1, 0], "motion": [
{"time": 0, "rotate": {"axis": [0, 0, 1], "angle": %s}},
{"time": 0.5, "rotate": {"axis": [0, 0, 2], "angle": %s}},
{"time": 1, "rotate": {"axis": [0, 0, -1], "angle": %s}}]}]}' "$@" >spin.json
}
spin 0 270 -540
run 0 render spin.json -o a.png
[ "$(grep -c 'shorter way' err.txt)" = 1 ] || die 'one warning for each object'
said err.txt 'spin.json:4: objects[0].motion[1].rotate: 270 degrees from the key before, but motion takes the shorter way, here -90;'
spin 0 120 -300
run 0 render spin.json -o a.png
said err.txt 'spin.json:5: objects[0].motion[2].rotate: -180 degrees from the key before'
spin 0 179 -358
run 0 render spin.json -o a.png
no_messages err.txt
# 400 degrees while the shutter is open, in 128 straight pieces: each misses a corner, sqrt 2 from the axis, by
# sqrt 2 (400 / 128 degrees)^2 / 8 = 5.3e-4. The place in the file.
sed 's/{"time": 0.5/{"time": 0.25, "rotate": {"axis": [0, 0, 1], "angle": 100}}, &/
s/{"time": 1/{"time": 0.75, "rotate": {"axis": [0, 0, 1], "angle": 300}}, &/; s/358/400/; s/179/200/' spin.json >far.json
run 0 render far.json -o b.png
said err.txt 'objects[0] moves along a curve that 128 straight pieces miss by up to 0.0005'
rm spin.json far.json
