# Memory runs out in the program or in a library of its, Embree's among them: exit code 4 and a message, no file;
# or the right result, where what asked could do without. Each place once, of many every so many; tests/oom.sh
# tries all.
. "$SOURCE/tests/cli/check.inc"
write_scene
# A library of the image helper ends its process while it is loaded, next to a render that would take for ever: the render ends
# with a message. While rows are written: the pixels go to the rescue file.
ls -A >before.txt
lose() { # WAY CODE WORDS OPTIONS…
    way=$1 expected=$2 words=$3
    shift 3
    expect "$expected" env FAULT_LOST=$way FATHOM_IMAGE_SECONDS=2 "FATHOM_IMAGE_MODULE=$BUILD/tests/faults/lost.so" \
        "$FATHOM" render scene.json -o a.tif "$@"
    said err.txt "$words"
}
for way in exit abort fault; do
    lose $way 4 'a.tif: image helper: the image helper' --size 4096x4096 --tracer linear:f64 --spp 65536
    [ "$(grep -c '^fathom: ' err.txt)" -eq 1 ] || die "$way: expected one message"
    rm err.txt out.txt
    [ "$(ls -A)" = "$(cat before.txt)" ] || die "$way: left behind: $(ls -A)"
done
run 0 render scene.json -o good.exr --size 16x12 -q
for way in exit abort fault thread hang; do
    lose rows-$way 4 'a.tif: cannot be written: the image helper' --size 16x12 -q
    said err.txt 'are in a.rescue.exr, as scene-linear EXR'
    run 0 compare good.exr a.rescue.exr --tolerance 0.00390625 # halves in the one, floats in the other
    rm a.rescue.exr
done
rm err.txt out.txt good.exr
[ "$(ls -A)" = "$(cat before.txt)" ] || die "a library that ends while rows are written: left behind: $(ls -A)"
rm before.txt

# Sanitizers answer requests themselves.
[ -z "$SANITIZE" ] || exit 0
faults=$BUILD/tests/faults
each() {
    "$faults/each" -l bad.txt "$@" >counts.txt 2>err.txt || { cat bad.txt >&2; die "each $*: $(cat counts.txt)"; }
    grep -qv '^0 places' counts.txt || die "each $*: nothing failed"
}
run 0 generate sphere -t 100 -o ball.glb --quiet
: >bad.txt
: >counts.txt

each -t "$faults/oom.so" "$FATHOM" info ball.glb
each -a -s 0/16 "$faults/oom.so" "$FATHOM" info scene.json
# The first requests, while the command line is read.
for number in 1 2 3 4; do
    each -n -s $number/1000000 -c "$FATHOM" -o a.png \
        "$faults/oom.so" "$FATHOM" render scene.json -o a.png --size 16x12 -q --tracer bvh
done
each -s 0/24 "$faults/oom.so" "$FATHOM" validate ball.glb --rays 2 -q
# Embree's and the scheduler's requests.
each -i libembree -s 1/24 -c "$FATHOM" -o a.exr "$faults/oom.so" "$FATHOM" render scene.json -o a.exr --size 16x12 -q
run 0 render scene.json -o good.exr --size 16x12 -q
each -t "$faults/oom.so" "$FATHOM" compare good.exr good.exr
rm good.exr
# Threads that TBB cannot have.
each -i libtbb -s 1/8 -w b.json "$faults/oom.so" "$FATHOM" bench trace ball.glb --rays 64 --json b.json
# No thread can be had at all: Embree and all of ours do without, with the same answers.
without_threads() {
    code=0
    LD_PRELOAD=$faults/oom.so FATHOM_OOM=threads "$FATHOM" "$@" >out.txt 2>err.txt || code=$?
}
without_threads validate ball.glb --rays 3 -q
[ $code -eq 0 ] || die "validate without threads: exit code $code"
run 0 render scene.json -o many.exr --size 16x12 --threads 4
without_threads render scene.json -o one.exr --size 16x12 --threads 4 -q
[ $code -eq 0 ] || die "render without threads: exit code $code"
same many.exr one.exr
