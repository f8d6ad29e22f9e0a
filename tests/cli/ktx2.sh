# KTX 2.0 textures: a glTF file that requires Basis Universal, and messages about broken files.
. "$SOURCE/tests/cli/check.inc"

# scene NAME IMAGE-URI MATERIAL: a square that fills the image.
scene() {
    cat >"$1" <<JSON
{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_texture_basisu", "KHR_materials_unlit"], $4
 "buffers": [{"byteLength": 92, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAACAPwAAgD8AAAAAAACAvwAAgD8AAAAAAAAAAAAAgD8AAIA/AACAPwAAgD8AAAAAAAAAAAAAAAAAAAEAAgAAAAIAAwA="}],
 "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32}, {"buffer": 0, "byteOffset": 80, "byteLength": 12}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}, {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"}, {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}],
 "images": [{"uri": "$2"}], "textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}}],
 "materials": [{"extensions": {"KHR_materials_unlit": {}}, "pbrMetallicRoughness": {$3}}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
 "cameras": [{"type": "orthographic", "orthographic": {"xmag": 0.9, "ymag": 0.9, "znear": 0.1, "zfar": 10}}],
 "nodes": [{"mesh": 0}, {"camera": 0, "translation": [0, 0, 2]}], "scenes": [{"nodes": [0, 1]}]}
JSON
}
texture='"baseColorTexture": {"index": 0}'
required='"extensionsRequired": ["KHR_texture_basisu"],'

# 4 x 4 texels of UASTC, of the one colour (51, 102, 204): a block of mode 8, whose code of 5 bits goes before four bytes.
# $1: the transfer function, 2 for sRGB.
write_ktx2() {
    zeros='\000\000\000'
    printf '\253KTX 20\273\r\n\032\n'
    printf "\\000$zeros\\001$zeros\\004$zeros\\004$zeros\\000$zeros\\000$zeros\\001$zeros\\001$zeros\\000$zeros"
    printf "\\150$zeros\\054$zeros\\000$zeros\\000$zeros\\000$zeros\\000$zeros\\000$zeros\\000$zeros"
    printf "\\224$zeros\\000$zeros\\020$zeros\\000$zeros\\020$zeros\\000$zeros"
    printf "\\054$zeros\\000$zeros\\002\\000\\050\\000\\246\\001\\00$1\\000\\003\\003\\000\\000\\020$zeros\\000$zeros"
    printf "\\000\\000\\177\\000\\000$zeros\\000$zeros\\377\\377\\377\\377"
    printf '\167\306\214\371\037\000\000\000\000\000\000\000\000\000\000\000'
}
write_ktx2 2 >blue.ktx2
write_ktx2 1 >linear.ktx2

scene textured.gltf blue.ktx2 "$texture" "$required"
scene plain.gltf blue.ktx2 '"baseColorFactor": [0.03310476657, 0.1328683216, 0.6038273389, 1]' ''
run 0 render textured.gltf -o textured.png --size 16x16 --spp 4 -q
silent err.txt
run 0 render plain.gltf -o plain.png --size 16x16 --spp 4 -q
same textured.png plain.png

# The extension's colours are sRGB, whatever the file says.
scene told.gltf linear.ktx2 "$texture" "$required"
run 0 render told.gltf -o told.png --size 16x16 --spp 4 -q
said err.txt 'told.gltf: images[0]: linear.ktx2: says that its numbers are linear; they are taken as sRGB'
same told.png plain.png

# with_plain GLTF KTX2: a texture that has a plain image, too, of another colour.
with_plain() {
    scene "$1" "$2" "$texture" "$required"
    sed -i 's/"images": \[/&{"uri": "green.ppm"}, /; s/"textures": \[{"extensions": {"KHR_texture_basisu": {"source": 0/"textures": [{"source": 0, "extensions": {"KHR_texture_basisu": {"source": 1/' "$1"
}
printf 'P6\n1 1\n255\n\000\377\000' >green.ppm
scene green.gltf green.ppm '"baseColorFactor": [0, 1, 0, 1]' ''
run 0 render green.gltf -o green.png --size 16x16 --spp 4 -q
with_plain both.gltf blue.ktx2
run 0 render both.gltf -o both.png --size 16x16 --spp 4 -q
silent err.txt
same both.png plain.png

# If the KTX 2.0 image is cut, of an unknown kind, or cannot be unpacked, the plain one is used.
# changed OFFSET BYTE: blue.ktx2 with another byte.
changed() { head -c "$1" blue.ktx2; printf "$2"; tail -c +$(($1 + 2)) blue.ktx2; }
fall_back() {
    with_plain fallen.gltf "$1"
    run 0 render fallen.gltf -o fallen.png --size 16x16 --spp 4 -q
    said err.txt "fallen.gltf: images[1] ($1): cannot be read as a texture: $2"
    said err.txt '; the other image of its texture is used (1 such)'
    same fallen.png green.png
}
head -c 150 blue.ktx2 >cut.ktx2
fall_back cut.ktx2 'level 0 ends early'
changed 44 '\011' >scheme.ktx2
fall_back scheme.ktx2 'the supercompression scheme is 9; expected'
changed 44 '\003' | head -c 96 >head
{ cat head; printf "\\020$zeros\\000$zeros"; tail -c +105 blue.ktx2; } >packed.ktx2
fall_back packed.ktx2 'level 0 cannot be unpacked'
with_plain fallen.gltf missing.ktx2
run 0 render fallen.gltf -o fallen.png --size 16x16 --spp 4 -q
said err.txt 'fallen.gltf: images[1]: cannot be read as a texture: there is no image; the other image of its texture'
same fallen.png green.png
run 0 convert fallen.gltf fallen.glb
not_said fallen.glb KHR_texture_basisu

# Converted, it is still Basis Universal.
run 0 convert textured.gltf copy.glb
said copy.glb '"extensionsRequired":["KHR_texture_basisu"]'
run 0 render copy.glb -o copy.png --size 16x16 --spp 4 -q
same copy.png plain.png

# Elsewhere it is an image as any other.
run 0 texture blue.ktx2 -o blue.tx
cp blue.tx blue.tif
run 0 compare blue.ktx2 blue.tif
refused 3 'cut.ktx2: cannot be read as a texture: level 0 ends early' texture cut.ktx2 -o cut.tx
{ head -c 148 blue.ktx2; printf '\105\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000'; } >broken.ktx2
refused 3 'broken.ktx2: cannot be read as a texture: the data of level 0 is broken' texture broken.ktx2 -o cut.tx
scene broken.gltf broken.ktx2 "$texture" "$required"
refused 3 'images[0]: broken.ktx2: cannot be read as a texture: the data of level 0 is broken' \
    render broken.gltf -o broken.png --size 16x16 --spp 4 -q
