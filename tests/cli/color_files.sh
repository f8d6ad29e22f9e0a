# A part and a checkpoint belong to the LUTs that an OpenColorIO config names, not only to the config.
# shellcheck disable=SC2086 # options are words
. "$SOURCE/tests/cli/check.inc"

printf 'P6\n2 1\n255\nabcdef' >a.ppm
cat >scene.json <<'EOF'
{ "materials": { "m": { "kdTexture": { "file": "a.ppm", "colorSpace": "Film" } } },
  "objects": [ { "type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m" } ] }
EOF
sed 's/Film/Plain/' scene.json >plain.json
cat >user.ocio <<'EOF'
ocio_profile_version: 2
search_path: luts
roles: {default: Plain, scene_linear: Plain, aces_interchange: Plain}
displays: {Screen: [!<View> {name: Plain, colorspace: Plain}]}
colorspaces:
  - !<ColorSpace> {name: Plain}
  - !<ColorSpace> {name: Film, to_scene_reference: !<FileTransform> {src: film.spi1d, interpolation: linear}}
EOF
mkdir luts
lut() { printf 'Version 1\nFrom 0.0 1.0\nLength 2\nComponents 1\n{\n 0.0\n %s\n}\n' "$1" >luts/film.spi1d; }
lut 0.5
export OCIO=user.ocio
small='--size 16x16 --spp 16 -q'
long='--size 256x256 --spp 65536 --checkpoint c'

run 0 render scene.json -o film1.part --part 1/2 $small
run 0 render plain.json -o plain1.part --part 1/2 $small
phase=render
start render scene.json -o a.exr $long
kill -TERM $child
end 5

# Other contents, other pixels.
lut 0.25
refused 3 'film1.part: the existing part was rendered' render scene.json -o film1.part --part 1/2 $small
refused 3 'c: the checkpoint was saved with a scene of contents' render scene.json -o a.exr $long --resume -q
run 0 render plain.json -o plain1.part --part 1/2 $small # uses no LUT
run 0 render scene.json -o film2.part --part 2/2 $small
refused 3 'film2.part: ' merge film1.part film2.part -o a.exr

# The same contents in another place.
lut 0.5
mkdir elsewhere
mv luts user.ocio elsewhere
OCIO=elsewhere/user.ocio run 0 render scene.json -o film1.part --part 1/2 $small
