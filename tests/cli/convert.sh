# fathom convert: every format, what is left out is said once, and nothing is left behind.
. "$SOURCE/tests/cli/check.inc"

cp "$SOURCE/scenes/example.obj" in.obj
for format in glb json obj ply; do
    run 0 convert in.obj out.$format
    said out.txt "out.$format: $(awk "BEGIN { printf \"%.1f kB\", $(wc -c <out.$format) / 1e3 }"), written in "
    run 0 convert in.obj out.$format -q
    silent out.txt
    run 0 render out.$format -o $format.png --size 32x32 --spp 4
done
run 0 convert "$SOURCE/scenes/example.json" all.json
silent err.txt
run 0 convert "$SOURCE/scenes/example.json" some.glb
said err.txt 'some.glb: a sphere becomes triangles with smooth normals (4 such)'
said err.txt 'some.glb: a plane has no end, and is left out (1 such)'
said err.txt 'some.glb: the background is left out (1 such)'

rm -f some.glb all.json
refused 2 'OUT: expected a name that ends in .glb, .json, .obj or .ply' convert in.obj out.stl
refused 2 'OUT is missing' convert in.obj
refused 3 'none.obj' convert none.obj a.glb
# The input stays as it is, and so do files that it names.
refused 2 'in.obj: is the input; expected another name for the output' convert in.obj in.obj
refused 2 'in.obj: is the input; expected another name for the output' convert in.obj ./in.obj
# Nor is the library of materials that an .obj names replaced by that of the copy.
printf 'newmtl red\nKd 1 0 0\n' >copy.mtl
cp copy.mtl kept.mtl
printf 'mtllib copy.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >named.obj
refused 2 'copy.mtl: is input and output at once; expected another output' convert named.obj copy.obj
cmp copy.mtl kept.mtl || die 'the library of materials was replaced'
run 0 convert named.obj other.obj
run 0 convert in.obj copy.obj
rm copy.mtl kept.mtl named.obj copy.obj other.obj other.mtl
printf '{ "objects": [ { "type": "mesh", "file": "in.obj" } ] }' >names.json
run 2 convert names.json in.obj
same in.obj "$SOURCE/scenes/example.obj"
# PLY has vertex colours and no materials: where some mesh has colours, those of materials are kept as such.
cat >two.json <<'JSON'
{ "materials": { "red": { "kd": [0.5, 0.25, 0.125] }, "white": { "kd": [1, 1, 1] } }, "objects": [
  { "type": "mesh", "material": "red", "positions": [[0,0,0],[1,0,0],[0,1,0]], "indices": [[0,1,2]] },
  { "type": "mesh", "material": "white", "positions": [[2,0,0],[3,0,0],[2,1,0]], "indices": [[0,1,2]],
    "colors": [[0,1,0],[0,1,0],[0,1,0]] } ] }
JSON
run 0 convert two.json two.ply
run 0 convert two.ply back.json
said back.json '"colors":[[0.5,0.25,0.125],[0.5,0.25,0.125],[0.5,0.25,0.125],[0,1,0],[0,1,0],[0,1,0]]'

# Lights keep their names, through scene JSON and glTF; a glTF light without one has that of its node.
cat >lights.json <<'JSON'
{ "lights": [ { "type": "point", "name": "key", "position": [2, 3, 2] }, { "type": "spot", "name": "\"rim\"", "position": [0, 4, 0], "direction": [0, -1, 0] },
    { "type": "directional", "direction": [-1, -1, 0] } ],
  "objects": [ { "type": "mesh", "positions": [[0,0,0],[1,0,0],[0,1,0]], "indices": [[0,1,2]] } ] }
JSON
run 0 convert lights.json lights.glb
run 0 convert lights.glb back.json
for name in key '\"rim\"'; do said back.json "\"name\":\"$name\""; done
not_said back.json '"type":"directional","name"'
# Nodes of lights turn and move, and do not scale.
grep -a -o '"matrix":[^]]*' lights.glb | cut -d'[' -f2 >matrices.txt
awk -F, '{ for (c = 0; c < 12; c += 4) { s = $(c + 1) ^ 2 + $(c + 2) ^ 2 + $(c + 3) ^ 2; if (s < 0.999999 || s > 1.000001) exit 1 } n++ }
    END { exit n != 3 }' matrices.txt || die 'a light scales its node'
# Opacities of vertices count under the material of the instance.
cat >worn.json <<'JSON'
{ "materials": { "own": { "model": "metallicRoughness" }, "worn": { "model": "metallicRoughness", "baseColor": [0.9, 0.8, 0.7] } },
  "groups": { "pane": [ { "type": "mesh", "material": "own", "positions": [[0,0,0],[1,0,0],[0,1,0]], "indices": [[0,1,2]],
                          "colors": [[1,0,0],[0,1,0],[0,0,1]], "opacities": [[1],[0.2],[0.5]] } ] },
  "objects": [ { "type": "instance", "of": "pane", "material": "worn" } ] }
JSON
run 0 convert worn.json worn.glb
run 0 render worn.json -o worn1.exr --size 32x32 --spp 16
run 0 render worn.glb -o worn2.exr --size 32x32 --spp 16
run 0 compare worn1.exr worn2.exr --tolerance 1e-5
rm worn1.exr worn2.exr
# Vertex colours of unlit surfaces are those of their emission. PLY has only colours.
cat >unlit.json <<'JSON'
{ "materials": { "m": { "model": "metallicRoughness", "baseColor": [0,0,0], "specular": 0, "emissive": [0.75, 0.5, 0.25] } },
  "objects": [ { "type": "mesh", "material": "m", "positions": [[0,0,0],[1,0,0],[0,1,0]], "indices": [[0,1,2]],
                 "colors": [[1,0,0],[0,1,0],[0,0,1]] } ] }
JSON
run 0 render unlit.json -o unlit1.exr --size 32x32 --spp 16 --background 0,0,0
run 0 convert unlit.json unlit.obj
run 0 render unlit.obj -o unlit2.exr --size 32x32 --spp 16 --background 0,0,0
run 0 compare unlit1.exr unlit2.exr --tolerance 1e-5
run 0 convert unlit.json unlit.ply
run 0 convert unlit.ply back.json
said back.json '"colors":[[0.75,0,0],[0,0.5,0],[0,0,0.25]]'
rm unlit1.exr unlit2.exr
# Colours of materials, without any of vertices. One grey needs none.
cat >parts.json <<'JSON'
{ "materials": { "dark": { "kd": [0.25, 0.25, 0.25] } },
  "objects": [ { "type": "mesh", "positions": [[0,0,0],[1,0,0],[0,1,0]], "indices": [[0,1,2]] },
               { "type": "mesh", "material": "dark", "positions": [[0,0,1],[1,0,1],[0,1,1]], "indices": [[0,1,2]] } ] }
JSON
run 0 convert parts.json parts.ply
run 0 convert parts.ply back.json
said back.json '"colors":[[0.5,0.5,0.5],[0.5,0.5,0.5],[0.5,0.5,0.5],[0.25,0.25,0.25],[0.25,0.25,0.25],[0.25,0.25,0.25]]'
sed 's/"material": "dark", //' parts.json >part.json
run 0 convert part.json part.ply
if grep -q 'property float red' part.ply; then die 'one grey is written for each vertex'; fi
# The shape of the image goes with its camera.
printf '{"image": {"width": 480, "height": 640}, "camera": {"eye": [0, 0, 4], "target": [0, 0, 0], "fovy": 40},
"objects": [{"type": "mesh", "positions": [[0,0,0],[1,0,0],[0,1,0]], "indices": [[0,1,2]]}]}' >tall.json
run 0 convert tall.json tall.glb
run 0 info tall.glb
said out.txt '960x1280'
cat >node.gltf <<'JSON'
{ "asset": { "version": "2.0" }, "extensionsUsed": [ "KHR_lights_punctual" ],
  "extensions": { "KHR_lights_punctual": { "lights": [ { "type": "point" } ] } },
  "buffers": [ { "byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" } ],
  "bufferViews": [ { "buffer": 0, "byteLength": 36 } ],
  "accessors": [ { "bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3 } ],
  "meshes": [ { "primitives": [ { "attributes": { "POSITION": 0 } } ] } ],
  "nodes": [ { "mesh": 0 }, { "name": "lamp", "extensions": { "KHR_lights_punctual": { "light": 0 } } } ] }
JSON
run 0 convert node.gltf back.json
said back.json '"name":"lamp"'

# Light groups of all kinds of sources.
cat >groups.json <<'JSON'
{"image":{"width":32,"height":24,"spp":4,"aovs":["lightGroups"]},
"camera":{"eye":[0,2,6],"target":[0,0.7,0],"fovy":40},"background":[0.1,0.2,0.3],"backgroundGroup":"sky",
"lights":[{"type":"point","position":[2,3,2],"intensity":8,"group":"key"},
{"type":"directional","direction":[-1,-1,0],"intensity":0.3,"group":"rim"}],
"materials":{"e":{"model":"metallicRoughness","emissive":[2,1,0.5],"group":"glow"}},
"objects":[{"type":"plane","point":[0,0,0],"normal":[0,1,0]},{"type":"sphere","center":[-1,0.5,0],"radius":0.5,"material":"e"},
{"type":"sphere","center":[1,0.5,0],"radius":0.5,"material":"e","group":"ball"}]}
JSON
run 0 convert groups.json regrouped.json
run 0 render groups.json -o groups.exr --exr-float -q
run 0 render regrouped.json -o regrouped.exr --exr-float -q
run 0 compare groups.exr regrouped.exr
for name in sky key rim glow ball rest; do grep -q "light_$name.R" regrouped.exr || die "there is no light_$name"; done

# Shapes without names keep their mattes, in another order and in groups that the file must name.
cat >nameless.json <<'JSON'
{"camera":{"eye":[0,0,9],"target":[0,0,0],"fovy":40,"shutter":[0,1]},"image":{"width":32,"height":32,"spp":4},
"groups":{"pair":[{"type":"sphere","center":[0,-2,0],"radius":0.5}]},
"objects":[{"type":"sphere","center":[-1,0,0],"radius":0.5},
{"type":"sphere","center":[0,1,0],"radius":0.5,"motion":[{"time":0},{"time":1,"translation":[1,0,0]}]},
{"type":"sphere","center":[1,0,0],"radius":0.5,"translation":[0,-1,0]},
{"type":"instance","of":"pair"},{"type":"instance","of":"pair","name":"second","translation":[2,0,0]}]}
JSON
run 0 convert nameless.json again.json --time 0 --shutter 1
for name in nameless again; do run 0 render $name.json -o $name.exr --aov cryptoObject -q; done
run 0 compare nameless.exr again.exr
rm nameless.exr again.exr

# A model of glass casts no shadow, but it does where an instance makes it solid, as if the mesh were. Where it is
# both, the glass decides.
cat >glass.json <<'JSON'
{"materials":{"glass":{"model":"metallicRoughness","transmission":1,"roughness":0,"thickness":1}},
"objects":[{"type":"sphere","center":[0,1,0],"radius":1,"material":"glass"}]}
JSON
run 0 convert glass.json glass.glb
shadow() { # GROUPS OBJECTS
    printf '{"camera":{"eye":[0,4,10],"target":[0,0.7,0],"fovy":35},"image":{"width":32,"height":16,"spp":4},
"materials":{"red":{"kd":[0.7,0.1,0.1]},"floor":{},"tint":{"model":"metallicRoughness","transmission":1,"roughness":0,
"thickness":1,"baseColor":[1,0.9,0.8]}},"lights":[{"type":"point","position":[2,6,3],"intensity":40}],"groups":{%s},
"objects":[{"type":"plane","point":[0,0,0],"normal":[0,1,0],"material":"floor"},%s]}' "$1" "$2"
}
ball='"ball":[{"type":"mesh","file":"glass.glb"}]'
place='{"type":"instance","of":"ball"'
shadow '' '{"type":"mesh","file":"glass.glb","material":"red","scale":[1,1,1]}' >mesh.json
shadow "$ball" "$place,\"material\":\"red\"}" >solid.json
shadow "$ball,\"outer\":[$place,\"material\":\"tint\"}]" '{"type":"instance","of":"outer","material":"red"}' >outer.json
shadow "$ball" "$place,\"material\":\"tint\"}" >tint.json
shadow "$ball" "$place,\"material\":\"red\"},$place,\"translation\":[-3,0,0]}" >both.json
for name in mesh solid outer tint both; do
    run 0 render $name.json -o $name.exr --exr-float
    run 0 convert $name.json $name-again.json
done
said err.txt 'a mesh that is clear in its file casts no shadow even where an instance makes it solid, because others leave it clear (1 such)'
run 0 compare mesh.exr solid.exr --tolerance 0
run 0 compare mesh.exr outer.exr --tolerance 0
for name in mesh solid outer; do not_said $name-again.json castsShadow; done
for name in tint both; do said $name-again.json '"castsShadow":false'; done
ls -A | grep tmp && die 'a temporary file was left behind'
exit 0
