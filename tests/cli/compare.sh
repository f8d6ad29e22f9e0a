# fathom compare: equal, nearly equal, different, not comparable.
. "$SOURCE/tests/cli/check.inc"
write_scene

run 0 render scene.json -o a.exr -o a.png
run 0 render scene.json -o b.exr -o b.png --background 0.2,0.3,0.5
run 0 compare a.exr a.exr
said out.txt 'max 0, RMSE 0, 0 of 6144 pixels differ'
run 1 compare a.exr b.exr
said out.txt 'in B at ('
run 1 compare a.exr b.exr --quiet
silent out.txt
# The background differs by 0.1 of blue, and half floats round by at most 2^-12 there; reflections of it by less.
run 0 compare a.exr b.exr --tolerance 0.1005
run 1 compare a.exr b.exr --tolerance 0.0995
run 1 compare a.png b.png

run 0 render scene.json -o c.exr --size 48x64
run 1 compare a.exr c.exr
said out.txt 'different sizes: 96x64 and 48x64'
run 0 render scene.json -o c.exr --crop 0,0,50,50
run 0 render scene.json -o d.exr --crop 1,0,51,50
run 1 compare c.exr d.exr
said out.txt 'different crops: at (0,0) of 96x64 and at (1,0) of 96x64'
run 0 render scene.json -o c.exr --aov Z
run 1 compare a.exr c.exr
said out.txt 'channel Z is only in the second'
# Infinite depths of the background are equal.
run 0 compare c.exr c.exr
said out.txt 'max 0, RMSE 0'

refused 3 'nothing.exr: No such file' compare a.exr nothing.exr
refused 3 'scene.json: cannot be read as an image' compare scene.json a.exr
