# An environment of six files: the image of one strip, kept or copied by conversion, and confined to it.
. "$SOURCE/tests/cli/check.inc"

python3 - <<'PY'
import struct
order = "px nx py ny pz nz".split()
def write(name, width, rows):
    with open(name, "wb") as file:
        file.write(f"PF\n{width} {len(rows)}\n-1.0\n".encode())
        for row in reversed(rows):
            file.write(struct.pack(f"<{3 * width}f", *(c for texel in row for c in texel)))
def face(k):
    return [[(k + x / 8, 6 - k, y / 4) for x in range(8)] for y in range(8)]
for k, name in enumerate(order):
    write(f"sky_{name}.pfm", 8, face(k))
write("strip.pfm", 48, [[texel for k in range(6) for texel in face(k)[y]] for y in range(8)])
PY
printf '{"lights":[{"type":"environment","file":"sky_<FACE>.pfm"}],"objects":[{"type":"sphere","center":[0,0,0],"radius":1}]}' \
    >cube.json
sed 's/sky_<FACE>/strip/' cube.json >strip.json
options='--size 40x30 --spp 16 --exr-float -q'
run 0 render cube.json -o cube.exr $options
run 0 render strip.json -o strip.exr $options
run 0 compare cube.exr strip.exr
run 0 render cube.json -o option.exr --environment 'sky_<FACE>.pfm' --no-floor $options
run 0 compare cube.exr option.exr

run 0 convert cube.json again.json
run 0 render again.json -o again.exr $options
run 0 compare cube.exr again.exr
mkdir inner
run 0 convert cube.json inner/out.json
[ "$(LC_ALL=C ls inner)" = "$(printf 'out-sky-0-%s.pfm\n' nx ny nz px py pz; echo out.json)" ]
run 0 render inner/out.json -o again.exr $options
run 0 compare cube.exr again.exr
# A name with <FACE> in a folder cannot be told by the first file alone: such files are copied, too.
for name in px nx py ny pz nz; do mkdir -p "in/$name"; cp "sky_$name.pfm" "in/$name/sky.pfm"; done
sed 's|sky_<FACE>|in/<FACE>/sky|' cube.json >folders.json
run 0 convert folders.json folders_again.json
run 0 render folders_again.json -o again.exr $options
run 0 compare cube.exr again.exr

mkdir outside
mv sky_nz.pfm outside
ln -s outside/sky_nz.pfm sky_nz.pfm
run 0 render cube.json -o link.exr $options
mkdir scene
for name in px nx py ny pz; do cp "sky_$name.pfm" scene; done
ln -s ../outside/sky_nz.pfm scene/sky_nz.pfm
cp cube.json scene
run 3 render scene/cube.json -o link.exr $options
said err.txt 'lights[0].file'
