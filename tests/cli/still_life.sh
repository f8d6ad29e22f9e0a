# scenes/still-life: its script makes all files that the scene names, and it renders without a warning.
if ! /usr/bin/python3 -c 'import numpy, PIL' 2>/dev/null; then
    echo 'skipped: python3-numpy or python3-pil is not installed'
    exit 0
fi
. "$SOURCE/tests/cli/check.inc"
/usr/bin/python3 -B "$SOURCE/scenes/still-life/make.py" made
run 0 info made/still-life.json
said out.txt 'problems  none'
run 0 render made/still-life.json --size 64x36 --spp 4 -q -o a.png
not_said err.txt 'warning'
# Without its images it looks otherwise: all are in view.
for image in wood glaze peel leaf cover linen plaster pages; do
    cp "made/$image.png" kept.png
    cp made/brushed.png "made/$image.png"
    run 0 render made/still-life.json --size 64x36 --spp 4 -q -o b.png
    differ a.png b.png
    mv kept.png "made/$image.png"
done
