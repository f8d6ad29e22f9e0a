# A system that grants little: stack, descriptors, address space, a folder for temporary files, clocks that go
# evenly.
. "$SOURCE/tests/cli/check.inc"
faults=$BUILD/tests/faults
write_scene
run 0 render scene.json -o usual.exr

# A stack of 1 MB does for every command.
small_stack() { (ulimit -s 1024 && run "$@") || exit 1; }
[ -n "$SANITIZE" ] || {
    small_stack 0 render scene.json -o small.exr
    same usual.exr small.exr
    small_stack 0 render scene.json -o small.png --target-error 0.05
    small_stack 0 render scene.json -o traced.exr --tracer bvh
    same usual.exr traced.exr
    small_stack 0 info scene.json
    small_stack 0 compare usual.exr small.exr --flip
    small_stack 0 validate scene.json --rays 3 -q
    small_stack 0 generate forest -t 5k -o forest.glb --quiet
    small_stack 0 bench trace --triangles 1k --rays 64
}

# Descriptors: done, or refused with a message and no file, whatever their number. With fewer than 6 the program's
# libraries cannot be opened. UndefinedBehaviorSanitizer asks by a pipe of its own whether an object can be read, and takes it
# for none where there are no descriptors.
for n in 6 8 12 16 32; do
    [ -z "$SANITIZE" ] || [ $n -ge 16 ] || continue
    rm -f few.exr
    code=0
    (ulimit -n $n && "$FATHOM" render scene.json -o few.exr -q) >out.txt 2>err.txt || code=$?
    case $code in
    0) same usual.exr few.exr ;;
    4) said err.txt 'fathom: ' && [ ! -e few.exr ] || die "$n descriptors: no message, or a file" ;;
    *) die "$n descriptors: exit code $code" ;;
    esac
    ls | grep -q fathom-tmp && die "$n descriptors: a temporary file is left"
done

# Nothing but benches needs a folder for temporary files.
TMPDIR=/nonexistent run 0 render scene.json -o there.png
TMPDIR=/nonexistent run 0 compare usual.exr usual.exr
TMPDIR=/nonexistent run 0 validate scene.json --rays 3 -q

# Clocks. The time of day may leap to and fro. The clock that measures times may leap forward, as after a sleep of
# the machine: then a time limit is up, and the samples are kept.
[ -z "$SANITIZE" ] || exit 0
leaping() { LD_PRELOAD=$faults/clock.so FATHOM_CLOCK=$1 FATHOM_CLOCK_AFTER=$2; export LD_PRELOAD FATHOM_CLOCK FATHOM_CLOCK_AFTER; }
for leap in realtime:-1000000 realtime:1000000; do
    (leaping $leap 0 && run 0 render scene.json -o leap.exr --max-time 60 --target-error 0.5 --stats leap.json) || exit 1
    awk "BEGIN { exit !($(number leap.json total) < 60) }" || die "$leap: it took $(number leap.json total) s"
    (leaping $leap 1 && run 0 render scene.json -o leap.exr) || exit 1
    same usual.exr leap.exr
done
# Libraries read the clock as well while they start, on some systems some hundred times.
for after in 300 600 1200 2400 4800; do
    code=0
    (leaping monotonic:3600 $after
        exec "$FATHOM" render scene.json -o leap.exr --max-time 600 --stats leap.json >out.txt 2>err.txt) || code=$?
    [ $code -eq 2 ] && grep -q 'had its first sample' err.txt || break
done
[ $code -eq 0 ] || die "a clock that leaps: exit code $code, expected 0"
same leap.exr leap.exr
awk "BEGIN { exit !($(number leap.json total) > 3600) }" || die 'the clock did not leap'
# Samples that are given come whatever the clock does, saved on the way and continued as well; nothing is left of that.
rm -f leap.exr leap.part
(leaping monotonic:3600 20 && run 0 render scene.json -o leap.exr --checkpoint leap.part --checkpoint-every 60) || exit 1
same usual.exr leap.exr
run 0 render scene.json -o steady.exr --target-error 0.004 --spp 1024
for after in 15 60; do
    rm -f leap.exr
    code=0
    (leaping monotonic:100000 $after
        exec "$FATHOM" render scene.json -o leap.exr --target-error 0.004 --spp 1024 --checkpoint leap.part --resume \
            --checkpoint-every 0 --stats leap.json >out.txt 2>err.txt) || code=$?
    [ $code -eq 0 ] || die "a clock that leaps beside checkpoints: exit code $code, expected 0"
    [ ! -e leap.part ] || die 'a checkpoint is left'
    same steady.exr leap.exr
done
