# Cameras: which one of a file is taken, what it makes of the image's shape, and the automatic one.
. "$SOURCE/tests/cli/check.inc"
# Equal PNG files need no other judge, and no image helper writes them.
export SOURCE_DATE_EPOCH=1700000000

# A triangle and two cameras, one for images twice as wide as high, one that says nothing of it; another orthographic.
write_model() { # name, aspectRatio with a comma
    cat >"$1" <<JSON
{ "asset": { "version": "2.0" },
  "buffers": [ { "byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" } ],
  "bufferViews": [ { "buffer": 0, "byteLength": 36 } ],
  "accessors": [ { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 } ],
  "materials": [ { "doubleSided": true } ],
  "meshes": [ { "primitives": [ { "attributes": { "POSITION": 0 }, "material": 0 } ] } ],
  "cameras": [ { "name": "lens", "type": "perspective", "perspective": { $2 "yfov": 0.8, "znear": 0.1 } },
               { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 9, "znear": 0.1 } } ],
  "nodes": [ { "mesh": 0 }, { "name": "Front", "camera": 0, "translation": [0.4, 0.4, 2] },
             { "name": "Far", "camera": 0, "translation": [0.4, 0.4, 6] }, { "name": "Plan", "camera": 1 } ] }
JSON
}
write_model wide.gltf '"aspectRatio": 2,'
write_model any.gltf ''

# The image has the camera's shape unless its size is given.
run 0 render wide.gltf --integrator classic -o a.png --camera Front --spp 1 --stats a.json
[ "$(number a.json width)x$(number a.json height)" = 1280x640 ] || die 'the shape of the camera'
run 0 render any.gltf --integrator classic -o a.png --camera Front --spp 1 --stats a.json
[ "$(number a.json width)x$(number a.json height)" = 1280x720 ] || die 'no shape'

# With a size aspectRatio changes no pixel; where it cuts something off, that is said.
for size in 64x64 128x64 128x32 40x96; do
    run 0 render wide.gltf --integrator classic -o a.png --camera Front --size $size
    case $size in
    128x*) not_said err.txt warning ;;
    *) said err.txt "% of the camera's view are not seen: its aspectRatio is 2" ;;
    esac
    run 0 render any.gltf --integrator classic -o b.png --camera Front --size $size
    no_messages err.txt
    same a.png b.png
done

# By the name of its node, by number; the first perspective one where none is asked for, and that is said.
run 0 render any.gltf --integrator classic -o a.png --size 64x64 --camera Far
run 0 render any.gltf --integrator classic -o b.png --size 64x64 --camera 1
same a.png b.png
run 0 render any.gltf --integrator classic -o b.png --size 64x64 --camera 0
differ a.png b.png
run 0 render any.gltf --integrator classic -o a.png --size 64x64
said err.txt 'fathom: warning: any.gltf: holds 3 cameras; 0 "Front" is taken'
same a.png b.png
refused 2 'any.gltf: there is no camera "Side"; expected one of 0 "Front", 1 "Far", 2 "Plan" (orthographic)' \
    render any.gltf --integrator classic -o c.png --camera Side
refused 2 '2 cameras are called "lens"' render any.gltf --integrator classic -o c.png --camera lens
run 0 render any.gltf --integrator classic -o c.png --size 64x64 --camera Plan
differ a.png c.png
write_scene
refused 2 'scene.json: has no cameras to choose "Front" from' render scene.json -o c.png --camera Front

# info lists them, and says which is taken.
run 0 info any.gltf --camera Far
said out.txt 'cameras   0 Front (lens)'
said out.txt '          1 Far (lens) <- taken'
said out.txt '          2 Plan, orthographic'
said out.txt 'camera    at (0.4, 0.4, 6)'
run 0 info any.gltf --camera Far --json
said out.txt '"node": "Plan"'
[ "$(grep -c '"taken": true' out.txt)" = 1 ] || die 'info --json: one camera is taken'
run 0 info wide.gltf
said out.txt 'image     1280x640, up to 1024 spp until the error is 0.02'

# The automatic camera looks at CAD's parts from ahead, which is -y, with z up. A file's own camera stays.
run 0 generate sphere --triangles 200 -o ball.ply
run 0 render ball.ply --integrator classic -o a.png --size 32x48 --up y
run 0 render ball.ply --integrator classic -o b.png --size 32x48
same a.png b.png
run 0 render ball.ply --integrator classic -o b.png --size 32x48 --up z
differ a.png b.png
printf 'v 500000 4649000 120\nv 500010 4649000 121\nv 500000 4649010 122\nf 1 2 3\n' >map.obj
run 0 info map.obj
said out.txt 'x and y look like coordinates on a map, where z is up; if so, give --up z'
sed 's/\([0-9]*\) \(464[0-9]*\) \([0-9]*\)/\1 \3 -\2/' map.obj >upright.obj
run 0 info upright.obj
if grep -q 'on a map' out.txt; then die 'y is up, and it is told otherwise'; fi
# It goes around a model.
run 0 render map.obj --integrator classic -o a.png --size 32x48
run 0 render map.obj --integrator classic -o b.png --size 32x48 --azimuth 204
differ a.png b.png
refused 2 '--elevation: expected' render ball.ply --integrator classic -o c.png --elevation 91
run 0 render scene.json -o c.png --size 8x8 --azimuth 5
said err.txt 'fathom: warning: scene.json: has its own camera, so --azimuth and --elevation have no effect'
refused 2 '--up: expected' render ball.ply --integrator classic -o c.png --up x
run 0 render scene.json -o c.png --size 8x8 --up z
said err.txt 'fathom: warning: scene.json: has its own camera'

# 16 samples a pixel for models.
run 0 render ball.ply --integrator classic -o a.png --size 32x48 --stats a.json
[ "$(number a.json spp)" = 16 ] || die '16 samples'
