# Signals that stop: keep what is finished as a valid image, exit code 5.
# shellcheck disable=SC2086 # options are words
. "$SOURCE/tests/cli/check.inc"
# Small enough to be built long before the signal, however busy the machine; sampled long enough to never end.
run 0 generate sphere -t 20k -o heavy.glb
run 0 render heavy.glb --integrator classic -o finished.exr --size 40x30
long='heavy.glb -o i.exr --spp 65536 --threads 1'

# interrupt SECONDS ARGUMENT…: fathom gets SIGINT after so many seconds, once, as from a terminal. (A shell has its background
# jobs ignore SIGINT, so `start` is of no use here.)
interrupt() {
    after=$1
    shift
    expect 5 timeout --foreground --preserve-status -s INT "$after" "$FATHOM" "$@"
}

# Ctrl-C; the end of a job; a terminal that is closed, which both the shell and the system report; processor time that is up, which
# the system reports every second: the second signal of these two hurries nobody.
for signal in INT TERM HUP XCPU; do
    rm -f i.partial.exr i.json
    cp finished.exr i.exr
    case $signal in
    INT) interrupt 6 render $long --stats i.json ;;
    *)
        phase=render
        start render $long --stats i.json
        kill -$signal $child
        [ $signal = TERM ] || kill -$signal $child 2>/dev/null || true
        end 5
        ;;
    esac
    said err.txt 'interrupted; the unfinished image is written to i.partial.exr'
    said out.txt 'interrupted at '
    not_said out.txt '65536 spp'
    said i.json '"interrupted": true'
    cmp finished.exr i.exr || die 'the finished image is gone'
    same i.partial.exr i.partial.exr
    grep -qa 'fathom:interrupted' i.partial.exr || die 'the header does not say interrupted'
    grep -qa 'fathom:finished' i.partial.exr || die 'the header does not say how much is done'
done

# Nothing that is written to may be where a partial image goes.
refused 2 'i.partial.exr: an interrupted render writes i.exr there' \
    render heavy.glb --integrator classic -o i.exr --checkpoint i.partial.exr
refused 2 'i.partial.png: an interrupted render writes i.png there' render heavy.glb --integrator classic -o i.png -o i.partial.png
ls -A | grep tmp && die 'a temporary file was left behind'

# timeout without --foreground sends the signal to the process and to its group: twice at once is once.
expect 5 timeout --preserve-status -s INT 1 "$FATHOM" render $long

# While it reads there is nothing to save: no output, no file left, code 5.
run 0 generate terrain -t 500k -o large.obj
rm -f i.exr i.partial.exr
phase=read
start render large.obj --integrator classic -o i.exr --stats i2.json
kill -TERM $child
end 5
said err.txt 'interrupted; nothing was written'
[ ! -e i.exr ] && [ ! -e i.partial.exr ] && [ ! -e i2.json ] || die 'an output of nothing'
rm -f large.obj large.mtl

# Between frames: the finished ones are named.
printf '{"camera": {"eye": [0, 0, 4], "target": [0, 0, 0]}, "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1,
"motion": [{"time": 0}, {"time": 9, "translation": [1, 0, 0]}]}]}' >moving.json
"$FATHOM" render moving.json --integrator classic --size 8x8 --spp 1 -o 's#.png' --frames 1-99999 >out.txt 2>err.txt &
child=$!
until [ -e s2.png ]; do
    kill -0 $child || die 'frames: it ended by itself'
    sleep 0.01
done
kill -TERM $child
end 5
not_said err.txt 'nothing was written'
said err.txt 'interrupted; '
rm -f s[0-9]*.png moving.json

# While a mesh is made or written: nothing is left. The signal waits until the program handles it, however long it takes to
# start: bit 14 of the mask, SIGTERM's.
for after in 0 0.5; do
    "$FATHOM" generate terrain -t 8M -o larger.obj >out.txt 2>err.txt &
    child=$!
    until caught=$(sed -n 's/^SigCgt:[^0-9a-f]*........//p' /proc/$child/status) && [ $((0x$caught >> 14 & 1)) -eq 1 ]; do
        kill -0 $child || die 'generate: it ended by itself'
        sleep 0.01
    done
    sleep $after
    kill -TERM $child
    end 5
    ls -A | grep larger && die 'generate: something was left behind'
done

# A second one ends it on the spot, by the signal itself, and leaves nothing half-written. Large images keep it
# writing for a while after the first.
phase=render
start render heavy.glb --integrator classic -o i.png -o i.tif -o i.exr -o j.png --spp 65536 --size 5000x5000
kill -TERM $child
sleep 0.4
kill -TERM $child
end 143
ls -A | grep tmp && die 'a second signal: a temporary file was left behind'

# A program that is started with SIGINT ignored, as a shell starts background jobs, goes on ignoring it.
start render heavy.glb --integrator classic -o i.exr --size 640x360 --spp 16
kill -INT $child
end 0
