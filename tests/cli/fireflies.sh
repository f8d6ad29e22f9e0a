# --fireflies reweight writes a second image next to each first one, which stays the same; so does merging parts.
. "$SOURCE/tests/cli/check.inc"

printf '{ "image": { "width": 64, "height": 48, "spp": 16 }, "background": [1, 1, 1],
  "camera": { "eye": [0, 0, 9], "target": [0, 0, 0], "fovy": 30 },
  "materials": { "lamp": { "kd": [0, 0, 0], "ke": [1e5, 1e5, 1e5] } },
  "objects": [ { "type": "sphere", "center": [0, 1, 0], "radius": 0.05, "material": "lamp" },
    { "type": "sphere", "center": [1, -1, 0], "radius": 0.01, "material": "lamp" },
    { "type": "sphere", "center": [-1, -1, 0], "radius": 0.01, "material": "lamp" } ] }' >scene.json

run 0 render scene.json -o plain.exr
run 0 render scene.json -o out.exr -o out.png --fireflies reweight --stats out.json
said out.txt 'out.exr, out.png, out.reweighted.exr, out.reweighted.png: 64x48'
said out.json '"out.reweighted.png"'
same plain.exr out.exr
run 1 compare out.exr out.reweighted.exr
grep -qa 'reweighted after Zirr' out.reweighted.exr || die 'the header does not say what was done'
grep -qa 'kept; a second image' out.exr || die 'the header of the first image says nothing'
[ -s out.reweighted.png ] || die 'the PNG has no second image'

for k in 1 2; do run 0 render scene.json -o $k.part --part $k/2 --fireflies reweight; done
run 0 merge 1.part 2.part -o merged.exr
said out.txt 'merged.exr, merged.reweighted.exr: 64x48'
same merged.exr out.exr
same merged.reweighted.exr out.reweighted.exr

# No place for it, or one that is taken.
refused 2 'expected a file' render scene.json -o - --fireflies reweight
refused 2 'b.reweighted.exr: --fireflies reweight writes b.exr there' \
    render scene.json -o b.exr -o b.reweighted.exr --fireflies reweight
refused 2 'expected a file' merge 1.part 2.part -o exr:-
refused 2 'c.reweighted.exr: --fireflies reweight writes c.exr there' merge 1.part 2.part -o c.exr -o c.reweighted.exr
refused 2 '--fireflies: expected keep|reweight' render scene.json -o b.exr --fireflies clamp
