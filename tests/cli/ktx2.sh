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
run 0 render textured.gltf -o textured.png --size 16x16 --spp 4
silent err.txt
run 0 render plain.gltf -o plain.png --size 16x16 --spp 4
same textured.png plain.png

# The extension's colours are sRGB, whatever the file says.
scene told.gltf linear.ktx2 "$texture" "$required"
run 0 render told.gltf -o told.png --size 16x16 --spp 4
said err.txt 'told.gltf: images[0]: linear.ktx2: says that its numbers are linear; they are taken as sRGB'
same told.png plain.png

# Converted, it is still Basis Universal.
run 0 convert textured.gltf copy.glb
said copy.glb '"extensionsRequired":["KHR_texture_basisu"]'
run 0 render copy.glb -o copy.png --size 16x16 --spp 4
same copy.png plain.png

# Elsewhere it is an image as any other.
run 0 texture blue.ktx2 -o blue.tx
cp blue.tx blue.tif
run 0 compare blue.ktx2 blue.tif
head -c 150 blue.ktx2 >cut.ktx2
refused 3 'cut.ktx2: cannot be read as a texture: level 0 ends early' texture cut.ktx2 -o cut.tx
{ head -c 148 blue.ktx2; printf '\105\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000'; } >broken.ktx2
refused 3 'broken.ktx2: cannot be read as a texture: the data of level 0 is broken' texture broken.ktx2 -o cut.tx
scene broken.gltf broken.ktx2 "$texture" "$required"
refused 3 'images[0]: broken.ktx2: cannot be read as a texture: the data of level 0 is broken' \
    render broken.gltf -o broken.png --size 16x16 --spp 4
