# Files that a file names lie within the folder of the scene that was given, unless --allow-outside says otherwise.
. "$SOURCE/tests/cli/check.inc"
mkdir -p box/models secret
run 0 generate sphere --triangles 20 -o secret/ball.ply
run 0 generate sphere --triangles 20 -o secret/ball.obj
cp secret/ball.ply box/models/ball.ply
cp secret/ball.obj secret/ball.mtl box/
ln -s "$PWD/secret/ball.ply" box/link.ply
ln -s ../secret box/folder
ln -s models/ball.ply box/inner.ply
ln -s box alias
# (0, 0, 0), (1, 0, 0), (0, 1, 0) as floats
printf '\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\077\0\0\0\0\0\0\0\0\0\0\0\0\0\0\200\077\0\0\0\0' >secret/data.bin
cp secret/data.bin box/data.bin
out='leads outside; expected a file in the folder of'
absolute='is an absolute path; expected a file in the folder of'

# scene FILE: box/scene.json shows the mesh.
scene() { printf '{ "image": { "integrator": "classic" }, "objects": [\n  { "type": "mesh", "file": "%s" } ] }\n' "$1" >box/scene.json; }
# everywhere CODE TEXT SCENE: all that read scenes say so.
everywhere() {
    refused 3 "$2" info "$3"
    refused 3 "$2" render "$3" -o a.png --size 16x16
    refused 3 "$2" validate "$3" --rays 1
    for what in trace render error; do
        refused 3 "$2" bench $what "$3"
    done
}

for good in models/ball.ply ./models/../models/ball.ply models//ball.ply inner.ply ball.obj; do
    scene $good
    run 0 info box/scene.json
    run 0 info alias/scene.json
    (cd box && "$FATHOM" info scene.json >/dev/null) || die "$good from its folder"
done

scene ../secret/ball.ply
everywhere 3 "fathom: box/scene.json:2: objects[0].file: \"../secret/ball.ply\" $out box/scene.json, or the option --allow-outside" \
    box/scene.json
for bad in ../secret/ball.ply models/../../secret/ball.ply link.ply folder/ball.ply ../box2/ball.ply; do
    scene "$bad"
    refused 3 "scene.json:2: objects[0].file: \"$bad\" $out" info box/scene.json
    refused 3 "scene.json:2: objects[0].file: \"$bad\" $out" info alias/scene.json
    [ "$bad" = ../box2/ball.ply ] || run 0 info box/scene.json --allow-outside
done
# A missing file is told apart from one that lies outside.
refused 3 'objects[0].file: box/../box2/ball.ply: No such file' info box/scene.json --allow-outside
scene models/none.ply
refused 3 'scene.json:2: objects[0].file: box/models/none.ply: No such file' info box/scene.json
for bad in "$PWD/secret/ball.ply" "$PWD/box/models/ball.ply" /none.ply; do
    scene "$bad"
    refused 3 "scene.json:2: objects[0].file: \"$bad\" $absolute" info box/scene.json
done
scene "$PWD/secret/ball.ply"
run 0 render box/scene.json -o a.png --size 16x16 --allow-outside
run 0 validate box/scene.json --rays 1 --allow-outside
run 0 bench render box/scene.json --size 16x16 --spp 1 --repeats 1 --threads 1 --allow-outside
rm a.png

# glTF: buffers, spelt in any way; the folder is the scene's, not that of the model within it.
gltf() {
    cat >"$1" <<JSON
{ "asset": { "version": "2.0" }, "buffers": [ { "uri": "$2", "byteLength": 36 } ],
  "bufferViews": [ { "buffer": 0, "byteLength": 36 } ],
  "accessors": [ { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 } ],
  "meshes": [ { "primitives": [ { "attributes": { "POSITION": 0 } } ] } ], "nodes": [ { "mesh": 0 } ] }
JSON
}
for bad in ../secret/data.bin ..%2Fsecret/data.bin %2e%2e/secret/data.bin folder/data.bin; do
    gltf box/a.gltf "$bad"
    refused 3 "fathom: box/a.gltf:1: buffers[0].uri: \"" info box/a.gltf
    said err.txt "$out box/a.gltf,"
    run 0 info box/a.gltf --allow-outside
done
gltf box/a.gltf "$PWD/secret/data.bin"
refused 3 "buffers[0].uri: \"$PWD/secret/data.bin\" $absolute" info box/a.gltf
gltf box/models/b.gltf ../data.bin
refused 3 "buffers[0].uri: \"../data.bin\" $out box/models/b.gltf," info box/models/b.gltf
scene models/b.gltf
run 0 info box/scene.json
gltf box/models/b.gltf ../../secret/data.bin
refused 3 "scene.json:2: objects[0].file: box/models/b.gltf:1: buffers[0].uri: \"../../secret/data.bin\" $out" \
    info box/scene.json
gltf box/a.gltf none.bin
refused 3 'fathom: box/a.gltf:1: buffers[0].uri: box/none.bin: No such file' info box/a.gltf

# Images that a material uses: one that is missing or outside is left out and told.
image() {
    gltf box/a.gltf data.bin
    sed -i "s|^{|{ \"images\": [ { \"uri\": \"$1\" } ], \"textures\": [ { \"source\": 0 } ], \"materials\": [ { \"pbrMetallicRoughness\": { \"baseColorTexture\": { \"index\": 0 } } } ],|; s|\"attributes\"|\"material\": 0, \"attributes\"|" \
        box/a.gltf
}
for bad in no%20ne.png ../none.png ../secret/ball.ply '..%5Csecret%5Cball.ply' "$PWD/secret/ball.ply"; do
    image "$bad"
    case $bad in
    *none.png | no*) why='there is no such file that may be read; it is left out' ;;
    *) why='is outside the folder that may be read, and left out; --allow-outside reads it' ;;
    esac
    run 0 info box/a.gltf
    said out.txt 'box/a.gltf: images[0].uri: "'
    said out.txt "$(printf %s "$bad" | tail -c 60)\": $why (1 such)"
done
printf 'newmtl m\nmap_Kd ../secret/ball.ply\n' >box/wood.mtl
printf 'mtllib wood.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n' >box/wood.obj
run 0 info box/wood.obj
said out.txt 'material "m": the image "../secret/ball.ply" is outside the folder that may be read, and left out; --allow-outside reads it'

# MTL libraries: a model is shown without those that may not be read. One of the same name next to it may be.
mv secret/ball.mtl secret/far.mtl
sed 's|^mtllib .*|mtllib ../secret/far.mtl|' secret/ball.obj >box/c.obj
grep -q '^mtllib' box/c.obj || sed -i '1i mtllib ../secret/far.mtl' box/c.obj
line=$(grep -n '^mtllib' box/c.obj | cut -d: -f1)
run 0 info box/c.obj
said out.txt "  box/c.obj:$line: mtllib: \"../secret/far.mtl\" $out"
run 0 info box/c.obj --allow-outside
sed -i "s|^mtllib .*|mtllib none.mtl $PWD/secret/far.mtl|" box/c.obj
run 0 info box/c.obj
said out.txt "c.obj:$line: mtllib: there is no file \"none.mtl\""
said out.txt "c.obj:$line: mtllib: \"$PWD/secret/far.mtl\" $absolute"
sed -i "s|^mtllib .*|mtllib $PWD/secret/ball.mtl|" box/c.obj
run 0 info box/c.obj
! grep -q mtllib out.txt || die "box/ball.mtl is not found"

# A file of rays names scenes as they were typed, and tracers: code is run for the command line alone.
run 1 validate box/models/ball.ply --tracer "$BUILD/tests/plugin/gap.so" --rays 3000 --families edge --failures bad.txt
refused 3 'is a library; a file may not choose what code runs: expected --tracer' validate --replay bad.txt --allow-outside
run 1 validate --replay bad.txt --tracer "$BUILD/tests/plugin/gap.so"
sed "s|box/models/ball.ply|$PWD/secret/ball.ply|" bad.txt >far.txt
refused 3 ": \"$PWD/secret/ball.ply\" is an absolute path" \
    validate --replay far.txt --tracer "$BUILD/tests/plugin/gap.so"
run 1 validate --replay far.txt --tracer "$BUILD/tests/plugin/gap.so" --allow-outside
run 1 validate "$PWD/secret/ball.ply" --replay far.txt --tracer "$BUILD/tests/plugin/gap.so"
