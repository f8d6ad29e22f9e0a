# Memory runs out in the program or in a library of its, Embree's among them: exit code 4 and a message, no file;
# or the right result, where what asked could do without. Each place once, of many every so many; tests/oom.sh
# tries all.
. "$SOURCE/tests/cli/check.inc"
write_scene
# A library of the image module ends the process while it is loaded, beside a render without end: so does the render.
ls -A >before.txt
for way in exit abort trap fault; do
    code=0
    FAULT_LOST=$way FATHOM_IMAGE_MODULE=$BUILD/tests/faults/lost.so \
        "$FATHOM" render scene.json -o a.exr --size 4096x4096 --tracer linear:f64 --spp 65536 >out.txt 2>err.txt || code=$?
    [ $code -eq 4 ] || die "a library that ends by $way: exit code $code, expected 4"
    said err.txt 'fathom: image module: a library ended while it was loaded, as they do when they lack memory'
    [ "$(grep -c '^fathom: ' err.txt)" -eq 1 ] || die "$way: expected one message"
    rm err.txt out.txt
    [ "$(ls -A)" = "$(cat before.txt)" ] || die "$way: left behind: $(ls -A)"
done
# The same signals from elsewhere end the program as they always do. Saved, it is known to be rendering.
"$FATHOM" render scene.json -o a.png --size 1024x1024 --tracer linear:f64 --spp 65536 --checkpoint a.part \
    --checkpoint-every 0.1 >out.txt 2>err.txt &
program=$!
while [ ! -e a.part ] && kill -0 $program 2>/dev/null; do sleep 0.05; done
kill -ABRT $program
code=0
wait $program || code=$?
[ $code -eq 134 ] || die "SIGABRT: exit code $code, expected that of the signal"
rm a.part err.txt out.txt
[ "$(ls -A)" = "$(cat before.txt)" ] || die "SIGABRT: left behind: $(ls -A)"
# One that waits for itself does neither, and is waited for no longer than ten seconds; nor does it keep the process from
# leaving.
code=0
FAULT_LOST=hang FATHOM_IMAGE_MODULE=$BUILD/tests/faults/lost.so \
    "$FATHOM" render scene.json -o a.exr --size 4096x4096 --tracer linear:f64 --spp 65536 >out.txt 2>err.txt &
render=$!
FAULT_LOST=hang FATHOM_IMAGE_MODULE=$BUILD/tests/faults/lost.so \
    "$FATHOM" render scene.json -o b.exr --size 16x12 -q >out2.txt 2>err2.txt || code=$?
[ $code -eq 4 ] || die "a library that hangs, and an image that waits for it: exit code $code, expected 4"
code=0
wait $render || code=$?
[ $code -eq 4 ] || die "a library that hangs: exit code $code, expected 4"
said err.txt 'fathom: image module: a library has been waiting for itself for 10 seconds while it was loaded'
said err2.txt 'fathom: image module: a library has been waiting for itself for 10 seconds while it was loaded'
said err2.txt 'b.rescue.exr, as scene-linear EXR'
rm err.txt out.txt err2.txt out2.txt b.rescue.exr
[ "$(ls -A)" = "$(cat before.txt)" ] || die "a library that hangs: left behind: $(ls -A)"
# One that ends the process while it writes rows costs no pixel, but where it calls exit() or does so on its own thread.
run 0 render scene.json -o good.exr --size 16x12 -q
lose_rows() { # WAY CODE WORDS
    code=0
    FAULT_LOST=rows-$1 FATHOM_IMAGE_MODULE=$BUILD/tests/faults/lost.so \
        "$FATHOM" render scene.json -o a.exr --size 16x12 -q >out.txt 2>err.txt || code=$?
    [ $code -eq "$2" ] || die "rows, $1: exit code $code, expected $2"
    said err.txt "$3"
}
lose_rows_and_rescue() {
    lose_rows "$@"
    said err.txt 'are in a.rescue.exr, as scene-linear EXR'
    run 0 compare good.exr a.rescue.exr --tolerance 0.00390625 # halves in the one, floats in the other
    rm a.rescue.exr
}
lose_rows_and_rescue abort 4 'a.exr: cannot be written: a library of the image module failed (SIGABRT), as some do when they'
lose_rows_and_rescue trap 4 'a library of the image module failed (SIGTRAP), as some do when they lack memory'
lose_rows_and_rescue null 4 'a library of the image module failed (SIGSEGV), as some do when they lack memory'
lose_rows_and_rescue fault 70 'a library of the image module failed (SIGSEGV)'
not_said err.txt 'lack memory'
lose_rows exit 4 'fathom: image module: a library ended the process, as some do when they lack memory'
lose_rows thread 4 'fathom: image module: a thread used a null pointer while its libraries worked, as some do when'
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
each -a -s 0/8 "$faults/oom.so" "$FATHOM" info scene.json
# The first requests, while the command line is read.
for number in 1 2 3 4; do
    each -n -s $number/1000000 -c "$FATHOM" -o a.png \
        "$faults/oom.so" "$FATHOM" render scene.json -o a.png --size 16x12 -q --tracer bvh
done
each -s 0/12 "$faults/oom.so" "$FATHOM" validate ball.glb --rays 2 -q
# Embree's and the scheduler's requests, but for those of the image module's libraries.
each -x fathom_image -i libembree -s 1/12 -c "$FATHOM" -o a.exr \
    "$faults/oom.so" "$FATHOM" render scene.json -o a.exr --size 16x12 -q
# While one library is loaded, each place.
run 0 render scene.json -o good.exr --size 16x12 -q
each -i ld-linux -k 'exit code 127' -w a.exr -c "$FATHOM" -r good.exr \
    "$faults/oom.so" env FATHOM_IMAGE_MODULE="$faults/lost.so" "$FATHOM" render scene.json -o a.exr --size 16x12 -q
# While the image module's libraries are loaded: many of them end the process then.
each -i ld-linux -s 3/150 -k 'exit code 127' -c "$FATHOM" -o a.exr \
    "$faults/oom.so" "$FATHOM" render scene.json -o a.exr --size 16x12 -q
# While an image is read: some of it is taken for a broken file, and is not the second time.
each -x ld-linux -i libIlmThread -t "$faults/oom.so" "$FATHOM" compare good.exr good.exr
rm good.exr
# Threads that TBB cannot have.
each -i libtbb -s 1/4 -w b.json "$faults/oom.so" "$FATHOM" bench trace ball.glb --rays 64 --json b.json
# Compressing rows on threads of its own, where OpenEXR forgets that it failed.
each -x ld-linux -i libz.so -c "$FATHOM" -o a.exr \
    "$faults/oom.so" "$FATHOM" render scene.json -o a.exr --size 16x12 -q

# No thread can be had at all: Embree and all of ours do without, with the same answers; OpenImageIO may not.
without_threads() {
    code=0
    LD_PRELOAD=$faults/oom.so FATHOM_OOM=threads "$FATHOM" "$@" >out.txt 2>err.txt || code=$?
}
without_threads validate ball.glb --rays 3 -q
[ $code -eq 0 ] || die "validate without threads: exit code $code"
run 0 render scene.json -o many.exr --size 16x12 --threads 4
without_threads render scene.json -o one.exr --size 16x12 --threads 4 -q
case $code in
0) same many.exr one.exr ;;
4) said err.txt 'fathom: ' && [ ! -e one.exr ] || die 'without threads: no message, or a file' ;;
*) die "render without threads: exit code $code" ;;
esac
