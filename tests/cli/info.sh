# fathom info: counts, bounds, features, memory, problems.
. "$SOURCE/tests/cli/check.inc"
write_scene

run 0 info scene.json
said out.txt 'scene     ball on a floor'
said out.txt '1 sphere, 1 quad, 0 planes'
said out.txt 'instances 0 of 0 groups'
said out.txt 'lights    1 point, 0 directional, 0 spot, 0 environment'
said out.txt 'bounds    (-3, 0, -3) to (3, 1.6, 3)'
said out.txt 'image     96x64, 1 spp'
said out.txt 'features  spheres, quads, point lights, Phong, mirrors'
said out.txt 'problems  none'
silent err.txt

# No name steers a terminal, neither a scene's nor a file's.
sed 's/ball on a floor/a\\u001b[2Jb\\u009b31m\\n\\u202e/' scene.json >named.json
run 0 info named.json
said out.txt 'scene     a?[2Jb??31m????'
run 0 render named.json -o a.png -v
said out.txt 'scene    a?[2Jb??31m????: 2 primitives'
name=$(printf 'n\033[2J\302\233\n\377')
run 0 render scene.json -o "$name.png"
said out.txt 'n?[2J????.png: 96x64'
run 0 generate sphere -t 20 -o "$name.ply"
said out.txt 'n?[2J????.ply: 20 triangles, 0.9 kB'
rm "$name.png" "$name.ply" a.png named.json
refused 2 'unexpected argument "n?[2J????"' info scene.json "$name"
refused 3 'fathom: n?[2J????.obj: No such file' info "$name.obj"

# A film of every AOV has 18 channels, 4 bytes a pixel each.
cat >aovs.json <<'JSON'
{ "image": { "integrator": "classic", "width": 640, "height": 480, "aovs": ["alpha", "Z", "N", "P", "albedo", "id", "samples"] },
  "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 } ] }
JSON
run 0 info aovs.json --json
[ "$(number out.txt film)" = $((640 * 480 * 18 * 4)) ] || die "film: $(number out.txt film)"

printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n' >mesh.obj
cat >nested.json <<'JSON'
{
  "lights": [],
  "groups": {
    "pair": [ { "type": "mesh", "file": "mesh.obj" }, { "type": "mesh", "file": "mesh.obj", "translation": [0, 0, 5] } ],
    "row": [ { "type": "instance", "of": "pair" }, { "type": "instance", "of": "pair", "translation": [3, 0, 0] } ]
  },
  "objects": [ { "type": "instance", "of": "row" }, { "type": "instance", "of": "row", "translation": [0, 9, 0] },
               { "type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0] } ]
}
JSON
run 0 info nested.json --json
said out.txt '"renderable": true'
[ "$(number out.txt planes)" = 1 ] || die 'planes'
# Two meshes of 2 triangles, in 2 pairs, in 2 rows.
[ "$(number out.txt placedTriangles)" = 16 ] || die "placed triangles: $(number out.txt placedTriangles)"
said out.txt '"nested groups"'
said out.txt 'degenerate'
said out.txt 'every surface is black'
python3 -m json.tool out.txt >/dev/null || die 'not JSON'

# Lights without strength are none.
for light in '"type": "point", "position": [0, 3, 0], "intensity": 0' \
    '"type": "directional", "direction": [0, -1, 0], "color": [0, 0, 0]'; do
    printf '{ "lights": [ { %s } ], "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 } ] }' "$light" >off.json
    run 0 info off.json
    said out.txt 'no light whose intensity and color are above 0, no ambient light and nothing that emits: every surface is black'
    run 0 render off.json -o a.png --size 8x8 --spp 1
    said err.txt 'all that is in view is black: no light reaches it, its materials reflect none, or the camera sees no object or is inside one'
done

# A floor without end has no bounds; light that is blue alone is light; what is cropped away takes no film; shapes that
# Embree cannot reach are a problem, and what gives off light is a feature.
cat >floor.json <<'JSON'
{ "image": { "integrator": "classic", "width": 640, "height": 480, "crop": [10, 20, 30, 60] }, "ambient": [0, 0, 0.5],
  "lights": [ { "type": "spot", "position": [0, 5, 0], "direction": [0, -1, 0], "intensity": 3 } ],
  "objects": [ { "type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0] } ] }
JSON
run 0 info floor.json
not_said out.txt 'bounds'
said out.txt 'lights    0 point, 0 directional, 1 spot'
said out.txt 'features  planes, spot lights, ambient'
said out.txt 'problems  none'
run 0 info floor.json --json
said out.txt '"bounds": null'
[ "$(number out.txt film)" = $((20 * 40 * 3 * 4)) ] || die "film of a crop: $(number out.txt film)"
cat >far.json <<'JSON'
{ "materials": { "lamp": { "ke": [1, 1, 1] }, "paint": { "specular": "blinn", "ks": [0, 0, 0] } },
  "lights": [], "ambient": [0, 0, 0],
  "groups": { "lamps": [ { "type": "sphere", "center": [0, 0, 2e18], "radius": 1e17, "material": "paint" } ] },
  "objects": [ { "type": "instance", "of": "lamps", "material": "lamp", "scale": [1e-9, 1e-9, 1e-9] } ] }
JSON
run 0 info far.json
said out.txt 'features  spheres, instances, emission'
said out.txt 'lights    0 point, 0 directional, 0 spot, 0 environment, 1 emissive shape'
said out.txt 'shapes and triangles beyond 1e+18 from the origin, which Embree leaves out: 1'
not_said out.txt 'every surface is black'
# Under path tracing the background lights the scene, and sums above 1 brighten it.
printf '{ "image": { "integrator": "path" }, "background": [1, 1, 1], "lights": [], "materials": { "g": { "kt": [1, 1, 1] } },
"objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "g" } ] }' >bright.json
run 0 info bright.json
not_said out.txt 'every surface is black'
said out.txt '"g" reflects 50 % more; lower kd (0.5 if not given), ks, kr or kt'
run 0 render bright.json -o a.png --size 8x8 --spp 1
said err.txt 'materials that reflect more light than they receive, so paths get brighter at each hit: 1; "g"'
run 0 render bright.json -o a.png --size 8x8 --spp 1 --integrator classic
not_said err.txt 'brighter'
printf '{ "name": "x", "ambient": [0, 0.1, 0], "lights": [], "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 } ] }' >green.json
run 0 info green.json
said out.txt 'features  spheres, ambient'

# What emits is counted as it is placed, in the material that it gets there.
cat >lamps.json <<'JSON'
{ "materials": { "lamp": { "ke": [1, 1, 1] }, "paint": {} },
  "groups": { "pair": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "lamp" },
                        { "type": "triangle", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]] } ],
              "pairs": [ { "type": "instance", "of": "pair" },
                         { "type": "instance", "of": "pair", "material": "lamp", "translation": [3, 0, 0] } ] },
  "objects": [ { "type": "instance", "of": "pairs" },
               { "type": "instance", "of": "pairs", "material": "paint", "translation": [0, 9, 0] },
               { "type": "instance", "of": "pairs", "translation": [0, 5, 0] } ] }
JSON
run 0 info lamps.json
said out.txt 'lights    0 point, 0 directional, 0 spot, 0 environment, 2 emissive triangles, 4 emissive shapes'
run 0 info lamps.json --json
[ "$(number out.txt emissiveShapes)" = 4 ] || die "emissive shapes: $(number out.txt emissiveShapes)"

# A name that is no UTF-8 is told all the same, in JSON that is.
name=$(printf 'a\377.json')
if cp green.json "$name" 2>/dev/null; then
    run 0 info "$name" --json
    said out.txt '"file": "a?.json"'
    rm "$name"
fi

# Scenes that cannot be rendered are refused with code 3.
printf '{ "objects": [\n  { "type": "sphere", "radius": -1 }\n] }\n' >bad.json
refused 3 'bad.json:2: objects[0].radius' info bad.json
run 3 info bad.json --json
said out.txt '"renderable": false'
said out.txt 'bad.json:2: objects[0].radius'
refused 3 'nothing.glb: No such file' info nothing.glb

# Embree's limits are told in the words of a render; shapes that it leaves out are problems only.
placed() { # radius of the group's sphere, scale
    cat <<JSON
{ "image": { "integrator": "classic" }, "camera": { "eye": [0, 0, 5], "target": [0, 0, 0] }, "ambient": [1, 1, 1],
  "groups": { "g": [ { "type": "sphere", "center": [0, 0, 0], "radius": $1 } ] },
  "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 },
               { "type": "instance", "of": "g", "scale": [$2, $2, $2] } ] }
JSON
}
for scale in 1e-30 1e-16 1e11; do
    placed 1 $scale >placed.json
    refused 3 'placed.json: instance 0, of "g": it s' render placed.json -o a.png --size 8x8 -q
    cp err.txt render.txt
    refused 3 'placed.json: instance 0, of "g": it s' info placed.json
    cmp -s err.txt render.txt || die "info says otherwise than render: $(cat render.txt)"
    run 3 info placed.json --json
    said out.txt '"renderable": false'
    run 0 render placed.json -o a.png --size 8x8 -q --tracer reference
done
placed 1e10 1e9 >placed.json
run 0 info placed.json
said out.txt 'instances beyond 1e+18 from the origin, which Embree leaves out: 1'
run 0 render placed.json -o a.png --size 8x8
said err.txt 'warning: instances beyond 1e+18 from the origin, which Embree leaves out: 1'

# The estimate of memory against what a render takes: never less, and little more.
run 0 generate sphere --triangles 1M -o big.glb
run 0 info big.glb --json
estimate=$(number out.txt total)
run 0 render big.glb --integrator classic -o big.exr --spp 1 --stats stats.json
peak=$(number stats.json peakMemoryBytes)
[ -n "$SANITIZE" ] || awk "BEGIN { exit !($estimate >= $peak && $estimate <= $peak + 60e6) }" ||
    die "info expects $estimate bytes, the render took $peak"

# Images: tiles of 64 x 64 texels of 4 bytes (100) and of 8 (25, 9, 4) in chunks of 64 KiB, and a chunk for smaller levels.
# A texel of a sky has 20 bytes, and each of the three floats that it is read from is there twice.
{ printf 'P6\n640 640\n255\n' && head -c 1228800 /dev/zero; } >image.ppm
run 0 render big.glb -o sky.exr --size 64x32 --spp 1
cat >images.json <<'JSON'
{ "materials": { "m": { "kdTexture": { "file": "image.ppm" } } },
"lights": [ { "type": "environment", "file": "sky.exr" } ],
"objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m" } ] }
JSON
run 0 info images.json --json
[ "$(number out.txt textures)" -eq $(((25 + 13 + 5 + 2 + 1) * 65536)) ] || die 'the memory of textures'
[ "$(number out.txt environments)" -eq $((64 * 32 * (20 + 2 * 3 * 4))) ] || die 'the memory of an environment'
run 0 info images.json
said out.txt 'textures 3.0, environments 0.1'
# An image that a render would refuse is a problem here as well.
head -c 3 image.ppm >cut.ppm
sed -i s/image.ppm/cut.ppm/ images.json
refused 3 'images.json:1: materials.m.kdTexture.file: cut.ppm: cannot be read as a texture' info images.json
sed -i 's/cut.ppm/image.ppm/; s/sky.exr/sky.png/' images.json
echo >sky.png
refused 3 'images.json:2: lights[0].file: sky.png: expected an image of linear radiance' info images.json

# Parts that a render leaves out, and why; for programs too.
write_scene
run 0 info scene.json
said out.txt 'left out  triangle geometry: there is no mesh'
said out.txt 'instances: all shapes lie in the world'
not_said out.txt 'mirrored and refracted rays'
run 0 info scene.json --json
said out.txt '"what": "watertight repair"'

# The image helper is for images alone, and not for PNG in sRGB.
run 0 info scene.json
said out.txt 'image helper for writing: EXR, and PNG in the built-in sRGB view, are written without it'
OCIO=none.ocio run 0 info scene.json
not_said out.txt 'image helper'
FATHOM_IMAGE_MODULE=/nowhere run 0 render scene.json -o a.png -v
said out.txt 'image helper for writing: EXR, and PNG in the built-in sRGB view, are written without it'
run 0 render scene.json -o a.png --view raw -v
not_said out.txt 'image helper'
run 0 render scene.json -o a.png -o a.tif -v
not_said out.txt 'image helper'
run 0 render scene.json -o a.exr

# A group that is only defined is not seen.
cat >groups.json <<'JSON'
{ "groups": { "placed": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 } ],
"forgotten": [ { "type": "instance", "of": "placed" } ] },
"objects": [ { "type": "instance", "of": "placed" } ] }
JSON
run 0 info groups.json
said out.txt 'groups that no instance places, and no image shows: 1'

# Clouds of points are no meshes.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n' >cloud.obj
run 0 info cloud.obj
said out.txt 'triangles 0 in 0 meshes'
said out.txt 'shapes    3 points in 1 cloud, 0 spheres'

# Keys of scene JSON without effect are problems, each once; those of models, which exporters write, are none, and a
# conversion leaves them out.
run 0 render scene.json -o image.png
useless() {
    printf '{ "materials": { "m": { "model": "metallicRoughness",
"baseColorTexture": { "file": "image.png",
"channel": "g",
"uvSet": 1 },
"normalTexture": { "file": "image.png",
"inverted": true,
"colorSpace": "srgb" },
%s "sheenRoughness": 0.5,
"emissiveStrength": 3,
"clearcoatRoughness": 0.1,
"iridescenceIor": 1.4,
"anisotropyRotation": 1,
"attenuationColor": [1, 0, 0],
"attenuationDistance": 1,
"bumpScale": 2,
"opacityCutoff": 0.5 } },
"objects": [ { "type": "mesh", "material": "m", "positions": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "indices": [[0, 1, 2]],
"uvs": [[0, 0], [1, 0], [0, 1]]%s } ] }' "$1" "$2"
}
# problems FILE: info lists exactly those on standard input.
problems() {
    cat >expected.txt
    run 0 info "$1"
    sed '1,/^problems/d' out.txt | sort -t : -k 2n | diff expected.txt - || die "the problems of $1"
}
no_problems() {
    run 0 info "$1"
    said out.txt 'problems  none'
}
useless '' '' >useless.json
problems useless.json <<'TXT'
  useless.json:3: materials.m.baseColorTexture.channel: it has no effect on this image
  useless.json:4: materials.m.baseColorTexture.uvSet: a mesh with this material has no "uvs1", so each of its triangles shows half the image
  useless.json:6: materials.m.normalTexture.inverted: it has no effect on this image
  useless.json:7: materials.m.normalTexture.colorSpace: expected "linear", because this image holds no colours
  useless.json:8: materials.m.sheenRoughness: it has no effect without "sheenColor"
  useless.json:9: materials.m.emissiveStrength: it has no effect without "emissive"
  useless.json:10: materials.m.clearcoatRoughness: it has no effect without "clearcoat"
  useless.json:11: materials.m.iridescenceIor: it has no effect without "iridescence"
  useless.json:12: materials.m.anisotropyRotation: it has no effect without "anisotropy"
  useless.json:13: materials.m.attenuationColor: it has no effect without "thickness"
  useless.json:13: materials.m.attenuationColor: it has no effect without one of "transmission", "diffuseTransmission"
  useless.json:14: materials.m.attenuationDistance: it has no effect without "thickness"
  useless.json:14: materials.m.attenuationDistance: it has no effect without one of "transmission", "diffuseTransmission"
  useless.json:15: materials.m.bumpScale: it has no effect without "bumpTexture"
  useless.json:16: materials.m.opacityCutoff: it has no effect without one of "opacity", "opacityTexture", "opacities"
TXT
run 0 convert useless.json useless.glb
run 0 info useless.glb
not_said out.txt 'no effect'
run 0 convert useless.glb again.json
run 0 info again.json
not_said out.txt 'no effect'
useless '"sheenColor": [1, 1, 1], "emissive": [1, 1, 1], "clearcoat": 1, "iridescence": 1, "anisotropy": 1, "thickness": 1,
"transmission": 1, "bumpTexture": { "file": "image.png" },' \
    ', "uvs1": [[0, 0], [1, 0], [0, 1]], "colors": [[1, 1, 1], [1, 1, 1], [1, 1, 1]], "opacities": [[1], [1], [0]]' |
    grep -v '"channel"\|"inverted"\|"colorSpace"' | sed 's/"file": "image.png",/"file": "image.png"/; s/^"uvSet"/, &/; s/^"normalTexture.*/& },/' >useful.json
no_problems useful.json
sed 's/"uvs": \[\[0, 0\], \[1, 0\], \[0, 1\]\], //' useful.json >bare.json
run 0 info bare.json
said out.txt 'Texture: a mesh with this material has no "uvs", so each of its triangles shows half the image'
# A lens without a radius has neither blades nor a plane of focus.
cat >lens.json <<'JSON'
{ "camera": { "eye": [0, 0, 5], "target": [0, 0, 0],
"focusDistance": 3,
"blades": 5 },
"objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 } ] }
JSON
run 0 info lens.json
said out.txt 'lens.json:2: camera.focusDistance: it has no effect without one of "lensRadius", "fStop"'
said out.txt 'lens.json:3: camera.blades: it has no effect without one of "lensRadius", "fStop"'
run 0 convert lens.json again.json
no_problems again.json
# Light that is scattered into a volume is absorbed there, too.
sed 's/"transmission": 1/"diffuseTransmission": 1/' useful.json >milk.json
no_problems milk.json
run 0 convert milk.json again.json
said again.json '"attenuationColor"'
said again.json '"attenuationDistance":1'
# Numbers in another unit are problems: degrees, micrometres, the Abbe number itself and millimetres.
cat >units.json <<'JSON'
{ "materials": { "m": { "model": "metallicRoughness", "transmission": 1, "thickness": 1, "anisotropy": 1, "iridescence": 1,
"anisotropyRotation": 45,
"iridescenceThicknessMax": 0.4,
"dispersion": 55 } },
"camera": { "eye": [0, 0, 5], "target": [0, 0, 0], "fStop": 4,
"focalLength": 50 },
  "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m" } ] }
JSON
problems units.json <<'TXT'
  units.json:2: materials.m.anisotropyRotation: expected radians; 45 seems to be in another unit
  units.json:3: materials.m.iridescenceThicknessMax: expected nanometres; 0.4 seems to be in another unit
  units.json:4: materials.m.dispersion: expected 20 divided by the Abbe number; 55 seems to be in another unit
  units.json:6: camera.focalLength: expected units of the scene; 50 seems to be in another unit, because no lens of this focal length focuses as near as 5
TXT
sed 's/"fStop": 4,/"lensRadius": 25 },/; /focalLength/d' units.json >wide.json
run 0 info wide.json
said out.txt 'wide.json:5: camera.lensRadius: expected units of the scene; 25 seems to be in another unit, because the focus is only 5 away'
sed 's/45/-0.79/; s/0.4/400/; s/55/0.36/; s/50/0.05/' units.json >usual.json
no_problems usual.json
# Radians, and colours as bytes. The views of lenses and telescopes, cones of lamps and search lights, small turns and
# probes are in degrees.
cat >radians.json <<'JSON'
{ "camera": { "eye": [0, 0, 5], "target": [0, 0, 0], "lensRadius": 0.1, "blades": 6,
"fovy": 0.6981,
"bladeRotation": 0.5236 },
"materials": { "m": { "kdTexture": { "file": "image.png",
"rotation": 1.5708 } } },
"lights": [ { "type": "spot", "position": [0, 4, 0], "target": [0, 0, 0],
"outerAngle": 0.785 }, { "type": "environment", "file": "sky.pfm",
"rotation": 3.14 } ],
"objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m", "rotate": { "axis": [0, 1, 0],
"angle": -1.57 } },
{ "type": "mesh", "positions": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "indices": [[0, 1, 2]],
"colors": [[255, 0, 0], [0, 9, 0], [0, 0, 1]] } ] }
JSON
printf 'PF\n1 1\n-1.0\n\0\0\200\77\0\0\200\77\0\0\200\77' >sky.pfm
problems radians.json <<'TXT'
  radians.json:2: camera.fovy: expected degrees; 0.6981 seems to be in radians, which are 40 degrees
  radians.json:3: camera.bladeRotation: expected degrees; 0.5236 seems to be in radians, which are 30 degrees
  radians.json:5: materials.m.kdTexture.rotation: expected degrees; 1.5708 seems to be in radians, which are 90 degrees
  radians.json:7: lights[0].outerAngle: expected degrees; 0.785 seems to be in radians, which are 44.98 degrees
  radians.json:8: lights[1].rotation: expected degrees; 3.14 seems to be in radians, which are 179.9 degrees
  radians.json:10: objects[0].rotate.angle: expected degrees; -1.57 seems to be in radians, which are -89.95 degrees
  radians.json:12: objects[1].colors: expected factors, such as 0.5; the numbers seem to be bytes up to 255
TXT
for view in 0.05 0.5 0.8 1 2 45; do
    sed "s/0\.6981,/$view,/; s/0\.5236/15/; s/1\.5708/2/; s/0\.785/1/; s/3\.14/3/; s/-1\.57/5.5/; s/255, 0/2.5, 0/" radians.json >usual.json
    no_problems usual.json
done
# Images of parameters that are 0, images whose inversion has no effect, and keys that need another value. A file has
# 20 warnings at most.
image='{ "file": "image.png" }'
cat >zero.json <<JSON
{ "materials": { "m": { "model": "metallicRoughness",
"emissiveTexture": $image,
"metallicRoughnessTexture": $image,
"transmissionTexture": $image,
"clearcoatTexture": $image,
"clearcoatRoughnessTexture": $image,
"clearcoatNormalTexture": $image,
"sheenColorTexture": $image,
"sheenRoughnessTexture": $image,
"anisotropyTexture": $image,
"iridescenceTexture": $image,
"iridescenceThicknessTexture": $image,
"diffuseTransmissionTexture": $image,
"diffuseTransmissionColorTexture": $image,
"thickness": 1 }, "c": {
"specular": "phong",
"shininess": 5,
"ksTexture": $image,
"shininessTexture": $image,
"keTexture": $image,
"fresnel": true, "ior": 2 },
"d": {}, "e": {} },
"objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m" },
  { "type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "c" } ] }
JSON
problems zero.json <<'TXT'
  zero.json: further warnings are left out
  zero.json:2: materials.m.emissiveTexture: it has no effect without "emissive"
  zero.json:3: materials.m.metallicRoughnessTexture: its blue has no effect without "metallic"
  zero.json:4: materials.m.transmissionTexture: it has no effect without "transmission"
  zero.json:5: materials.m.clearcoatTexture: it has no effect without "clearcoat"
  zero.json:6: materials.m.clearcoatRoughnessTexture: it has no effect without "clearcoat", "clearcoatRoughness"
  zero.json:7: materials.m.clearcoatNormalTexture: it has no effect without "clearcoat"
  zero.json:8: materials.m.sheenColorTexture: it has no effect without "sheenColor"
  zero.json:9: materials.m.sheenRoughnessTexture: it has no effect without "sheenColor", "sheenRoughness"
  zero.json:10: materials.m.anisotropyTexture: it has no effect without "anisotropy"
  zero.json:11: materials.m.iridescenceTexture: it has no effect without "iridescence"
  zero.json:12: materials.m.iridescenceThicknessTexture: it has no effect without "iridescence"
  zero.json:13: materials.m.diffuseTransmissionTexture: it has no effect without "diffuseTransmission"
  zero.json:14: materials.m.diffuseTransmissionColorTexture: it has no effect without "diffuseTransmission"
  zero.json:15: materials.m.thickness: it has no effect without one of "transmission", "diffuseTransmission"
  zero.json:16: materials.c.specular: it has no effect without "ks"
  zero.json:17: materials.c.shininess: it has no effect without "ks"
  zero.json:18: materials.c.ksTexture: it has no effect without "ks"
  zero.json:19: materials.c.shininessTexture: it has no effect without "ks"
  zero.json:20: materials.c.keTexture: it has no effect without "ke"
  zero.json:21: materials.c.fresnel: it has no effect without one of "kr", "kt"
TXT
run 0 convert zero.json again.json
for key in metallicTexture emissive transmission clearcoat sheen anisotropy iridescence diffuse shininess keTexture; do not_said again.json $key; done
cat >one.json <<JSON
{ "materials": { "m": { "model": "metallicRoughness", "metallic": 1,
"transmission": 1,
"baseColorTexture": { "file": "image.png",
"inverted": true }, "roughnessTexture": { "file": "image.png", "inverted": true } },
"d": {}, "e": {} },
"groups": { "g": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1 } ] },
"objects": [ { "type": "instance", "of": "g", "material": "m" } ] }
JSON
problems one.json <<'TXT'
  one.json:2: materials.m.transmission: it has no effect where "metallic" is 1
  one.json:4: materials.m.baseColorTexture.inverted: it has no effect where "baseColor" is 1; with 0 the surface has 1 - image
  one.json:5: materials.d: no object has this material, the first of 2 such
TXT
# Vertices have opacities, so the cutoff stays.
run 0 convert useful.json again.json
said again.json '"opacityCutoff":0.5'
no_problems again.json

# What is there is told as it is: an environment, the layers of a material, motion, a lens, and instances whose shapes are moved.
printf 'PF\n1 1\n-1.0\n\0\0\200\77\0\0\200\77\0\0\200\77' >sky.pfm
cat >layers.json <<'JSON'
{ "materials": { "m": { "model": "metallicRoughness", "clearcoat": 1, "sheenColor": [1, 1, 1], "iridescence": 1, "anisotropy": 0.5,
    "transmission": 0.5, "diffuseTransmission": 0.5, "thickness": 1, "dispersion": 1, "attenuationColor": [1, 0, 0], "attenuationDistance": 1 } },
  "camera": { "eye": [0, 0, 5], "target": [0, 0, 0], "lensRadius": 0.1 },
  "lights": [ { "type": "environment", "file": "sky.pfm" } ],
  "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m",
                 "motion": [ { "time": 0 }, { "time": 1, "translation": [1, 0, 0] } ] } ] }
JSON
run 0 info layers.json
not_said out.txt 'environments are left out'
printf 'PF\n1 1\n-1.0\n\0\0\300\177\0\0\200\77\0\0\200\77' >nan.pfm
sed 's/sky.pfm/nan.pfm/' layers.json >nan.json
refused 3 'nan.pfm: texel (0, 0), counted from the top left, has nan in channel R' info nan.json
sed 's/^{/{ "image": { "integrator": "classic" },/' layers.json >classic.json
run 0 info classic.json
said out.txt 'environments are ignored: only the integrator `path` renders them: 1'
run 0 info layers.json
said out.txt '0 spot, 1 environment'
said out.txt 'materials 1'
said out.txt 'looking along (0, 0, -1)'
said out.txt 'features  spheres, instances, motion, depth of field, environments, GGX, clearcoat, sheen, anisotropy, iridescence, dispersion, diffuse transmission, absorption'
not_said out.txt 'Blinn'
run 0 generate sphere -t 20 -o ball.glb
run 0 info ball.glb
said out.txt 'instances: their shapes are moved to the world'
