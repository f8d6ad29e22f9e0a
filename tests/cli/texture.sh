# fathom texture: files that are read again, what is refused, nothing left behind.
. "$SOURCE/tests/cli/check.inc"
write_scene

run 0 render scene.json -o a.png -o a.exr
: >a.fathom-tmp1.tx
run 0 texture a.png -o a.tx
[ ! -e a.fathom-tmp1.tx ] || die 'the file of a killed process is still there'
said out.txt 'a.tx: '
run 0 texture a.exr -o linear.tx --color linear --quiet
silent out.txt
run 0 texture a.exr -o aces.tx --color ACEScg
run 0 texture a.tx -o again.tif
# Level 0 has the bytes of the image.
cp a.tx level.tif
run 0 compare a.png level.tif

refused 3 'scene.json: cannot be read as a texture' texture scene.json -o b.tx
refused 3 'absent.png: ' texture absent.png -o b.tx
refused 2 'no color space "mauve"; expected srgb, linear or one of: "Linear Rec.709"' texture a.png -o b.tx --color mauve
printf '{"materials": {"m": {"kdTexture": {"file": "a.png",\n"colorSpace": "mauve"}}}, "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m"}]}' >mauve.json
refused 3 'mauve.json:2: materials.m.kdTexture.colorSpace: no color space "mauve"; expected srgb, linear or one of: "Linear Rec.709"' \
    render mauve.json -o b.png
# --ocio is the config of textures as well, and a message about a config names it.
cat >user.ocio <<'EOF'
ocio_profile_version: 2
roles: {default: Plain, scene_linear: Plain, aces_interchange: Plain}
displays: {Screen: [!<View> {name: Plain, colorspace: Plain}]}
colorspaces:
  - !<ColorSpace> {name: Plain}
  - !<ColorSpace>
    name: Halved
    to_scene_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}
EOF
sed 's/mauve/Halved/' mauve.json >halved.json
run 0 render halved.json -o b.exr --ocio user.ocio --size 8x8 --spp 4
OCIO=user.ocio run 0 render halved.json -o c.exr --size 8x8 --spp 4
run 0 compare b.exr c.exr
OCIO=none.ocio refused 3 'user.ocio: no color space "mauve"; expected srgb, linear or one of: "Plain", "Halved"' \
    render mauve.json -o b.png --ocio user.ocio
OCIO=none.ocio refused 3 'none.ocio: cannot be read: No such file or directory' \
    texture a.png -o b.tif --color Halved
rm b.exr c.exr
refused 2 'expected a name that ends in .tx, .tif or .tiff' texture a.png -o b.png
refused 2 'a.tx: is the input; expected another name for the output' texture a.tx -o a.tx
head -c 3000 a.png >cut.png
refused 3 'cut.png: cannot be read as a texture' texture cut.png -o b.tx
# A render ends once a ray needs a broken image: this one would take days.
printf '{"materials": {"m": {"kdTexture": {"file": "cut.png"}}}, "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m"}]}' >cut.json
refused 3 'cut.json:1: materials.m.kdTexture.file: cut.png: cannot be read as a texture' \
    render cut.json -o b.png --size 8000x8000 --spp 65536
# Levels 0 and 1 do not fit: 100 tiles of 64 x 64 texels of 4 bytes, and 25 of 8.
{ printf 'P6\n640 640\n255\n' && head -c 1228800 /dev/zero; } >large.ppm
sed 's/cut.png/large.ppm/' cut.json >large.json
TMPDIR=$PWD/none refused 4 'none: cannot hold a temporary file of 2.5 MB for textures: No such file or directory' \
    render large.json -o b.png --texture-memory 1M
# An alpha that the image lacks: of two images of a material, the one that asks for it.
sed 's/"kdTexture": {\([^}]*\)}/"kdTexture": {\1}, "opacityTexture": {\1, "channel": "a"}/; s/cut.png/heights.pgm/g' cut.json >alpha.json
printf 'P5\n2 1\n255\nab' >heights.pgm
run 0 render alpha.json -o b.png --size 8x8 --spp 4
[ "$(grep -c 'alpha.json: materials.m.opacityTexture.channel: heights.pgm has no alpha, so the channel a is 1' err.txt)" = 1 ] ||
    die 'an image without alpha'
# Heights in place of normals: a grey image tilts all normals alike.
printf 'P5\n2 1\n255\nab' >heights.pgm
sed 's/kdTexture/bumpTexture/; s/cut.png/heights.pgm/' cut.json >bump.json
run 0 render bump.json -o b.png --size 8x8 --spp 4
not_said err.txt heights.pgm
sed 's/bumpTexture/normalTexture/' bump.json >normal.json
run 0 render normal.json -o b.png --size 8x8 --spp 4
said err.txt 'normal.json: materials.m.normalTexture.file: heights.pgm: expected normals in three channels, found one; heights make a bump map'
