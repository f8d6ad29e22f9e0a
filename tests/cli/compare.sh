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

# FLIP: nothing between equal images; the same from linear values as from those of a screen, but for their rounding to
# bytes: half a step is some 0.3 in L*a*b*, and FLIP grows by 0.95 d^0.7 / 16.5 at most, 0.025.
run 0 compare a.exr a.exr --flip
said out.txt 'FLIP 0 at 67 pixels a degree'
run 1 compare a.exr b.exr --flip
linear=$(sed -n 's/^FLIP \([0-9.]*\) at.*/\1/p' out.txt)
run 1 compare a.png b.png --flip
screen=$(sed -n 's/^FLIP \([0-9.]*\) at.*/\1/p' out.txt)
awk "BEGIN { exit !($linear > 0.05 && $linear - $screen < 0.025 && $screen - $linear < 0.025) }" ||
    die "FLIP $linear between EXR files, $screen between PNG files"
run 1 compare a.png b.png --flip --ppd 20
not_said out.txt "FLIP $screen "
said out.txt 'at 20 pixels a degree'
run 1 compare a.png b.png --flip --quiet
silent out.txt
refused 2 'ppd' compare a.png b.png --flip --ppd 0.5
refused 2 '--ppd: only with --flip' compare a.png b.png --ppd 20
run 0 render scene.json -o id.exr --aov id
run 0 compare id.exr id.exr --flip

run 0 render scene.json -o c.exr --size 48x64
run 1 compare a.exr c.exr
said out.txt 'different sizes: 96x64 and 48x64'
run 1 compare a.exr c.exr --quiet
silent out.txt
run 0 render scene.json -o d.exr --size 96x48
run 1 compare a.exr d.exr
said out.txt 'different sizes: 96x64 and 96x48'
run 1 compare a.exr c.exr --flip
not_said out.txt FLIP
run 0 render scene.json -o c.exr --crop 0,0,50,50
run 0 render scene.json -o d.exr --crop 1,0,51,50
run 1 compare c.exr d.exr
said out.txt 'different crops: at (0,0) of 96x64 and at (1,0) of 96x64'
run 0 render scene.json -o d.exr --crop 0,1,50,51
run 1 compare c.exr d.exr
said out.txt 'different crops: at (0,0) of 96x64 and at (0,1) of 96x64'
for size in 90x64 96x60; do
    run 0 render scene.json -o d.exr --crop 0,0,50,50 --size $size
    run 1 compare c.exr d.exr
    said out.txt "different crops: at (0,0) of 96x64 and at (0,0) of $size"
done
run 0 render scene.json -o c.exr --aov Z
run 1 compare a.exr c.exr
said out.txt 'channel Z is only in the second'
# Infinite depths of the background are equal.
run 0 compare c.exr c.exr
said out.txt 'max 0, RMSE 0'

refused 3 'nothing.exr: No such file' compare a.exr nothing.exr
refused 3 'scene.json: cannot be read as an image' compare scene.json a.exr

# Differences between values for a display and linear ones mean nothing.
run 1 compare a.png a.exr
said err.txt 'only FLIP is a measure of their difference'

# Gray values have no colours to see.
printf 'P5\n2 1\n255\nab' >gray.pgm
printf 'P5\n2 1\n255\nac' >other.pgm
run 1 compare gray.pgm other.pgm
said out.txt '1 of 2 pixels differ'
run 3 compare gray.pgm gray.pgm --flip
said err.txt 'gray.pgm: FLIP needs the channels R, G and B'

# Numbers of one image and numbers of shapes in the other, though the channel is called the same: what stands for its type
# in the head of the file, a whole number, is made a float's.
run 0 render scene.json -o c.exr --aov id
at=$(grep -abo -m 1 'id.instance.V' c.exr | head -n 1 | cut -d : -f 1)
cp c.exr d.exr
printf '\002' | dd of=d.exr bs=1 seek=$((at + 14)) conv=notrunc 2>/dev/null
run 1 compare c.exr d.exr
said out.txt 'channel id.instance.V is of different types'
