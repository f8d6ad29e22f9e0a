# fathom generate: every kind and format, the same bytes each time, renderable.
. "$SOURCE/tests/cli/check.inc"

# An OBJ names its library of materials after itself: the same name twice takes two folders.
mkdir one three
for kind in sphere terrain sponge forest; do
    for format in glb ply obj; do
        run 0 generate $kind --triangles 20k -o one/a.$format --threads 1
        said out.txt "one/a.$format: "
        [ $format != glb ] || silent err.txt
        run 0 generate $kind --triangles=20000 -o three/a.$format --threads 3 --quiet
        silent out.txt
        cmp one/a.$format three/a.$format || die "$kind.$format depends on the threads"
    done
    run 0 render one/a.glb --integrator classic -o $kind.png --size 64x64
done
for kind in sphere terrain forest; do
    run 0 generate $kind -t 5k --seed 1 -o a.ply
    run 0 generate $kind -t 5k --seed 2 -o b.ply
    ! cmp -s a.ply b.ply || die "$kind: the seed changes nothing"
done

# About as many triangles as asked for; a closed sphere of 20k comes within 5 %.
run 0 generate sphere -t 20k -o a.glb
cp out.txt triangles.txt
run 0 info a.glb --json
count=$(number out.txt placedTriangles)
said triangles.txt "a.glb: $count triangles, "
[ "$count" -ge 19000 ] && [ "$count" -le 21000 ] || die "asked for 20000 triangles, got $count"
ls -A | grep tmp && die 'a temporary file was left behind'
exit 0
