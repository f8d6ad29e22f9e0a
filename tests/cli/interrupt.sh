# Ctrl-C and SIGTERM: stop, keep what is finished as a valid image, exit code 5.
. "$SOURCE/tests/cli/check.inc"
# Small enough to be built long before the signal, however busy the machine; sampled long enough to never end.
run 0 generate sphere -t 20k -o heavy.glb
# stop SIGNAL SECONDS ARGUMENT…: fathom gets the signal after so many seconds; `took` is how long it lived on.
# --foreground sends it once, as a terminal does.
stop() {
    signal=$1
    after=$2
    shift 2
    begin=$(now)
    code=0
    timeout --foreground --preserve-status -s "$signal" "$after" "$FATHOM" "$@" >out.txt 2>err.txt || code=$?
    took=$(awk "BEGIN { print $(now) - $begin - $after }")
}

# That it stops at all: ten seconds are forever. How fast it does is measured by bench/start.sh.
quick() {
    rm -f i.partial.exr i.json
    cp finished.exr i.exr
    stop "$@"
    awk "BEGIN { exit !($took < 10) }" || die "it took $took s to stop"
}

long='heavy.glb -o i.exr --spp 65536'
run 0 render heavy.glb -o finished.exr --size 40x30
for signal in INT TERM; do
    # shellcheck disable=SC2086
    quick $signal 3 render $long --stats i.json
    [ $code -eq 5 ] || die "SIG$signal: exit code $code, expected 5"
    said err.txt 'fathom: interrupted; the image is written as far as it got, to i.partial.exr'
    said out.txt 'interrupted at '
    said i.json '"interrupted": true'
    cmp finished.exr i.exr || die 'the finished image is gone'
    same i.partial.exr i.partial.exr
    grep -qa 'fathom:interrupted' i.partial.exr || die 'the header does not say interrupted'
    grep -qa 'fathom:finished' i.partial.exr || die 'the header does not say how much is done'
done

# Nothing that is written to may be where a partial image goes.
refused 2 'i.partial.exr: an interrupted render puts i.exr there' \
    render heavy.glb -o i.exr --checkpoint i.partial.exr
refused 2 'i.partial.png: an interrupted render puts i.png there' render heavy.glb -o i.png -o i.partial.png
ls -A | grep tmp && die 'a temporary file was left behind'

# timeout without --foreground sends the signal to the process and to its group: twice at once is once.
code=0
# shellcheck disable=SC2086
timeout --preserve-status -s INT 3 "$FATHOM" render $long >out.txt 2>err.txt || code=$?
[ $code -eq 5 ] || die "two signals at once: exit code $code, expected 5"

# A terminal that is closed, of which the shell and the system tell, and the processor's time that is up, of which the
# system tells every second: like Ctrl-C, and no second one is in haste.
for signal in HUP XCPU; do
    rm -f i.partial.exr
    "$FATHOM" render heavy.glb -o i.exr --max-time 20 >out.txt 2>err.txt &
    until grep -q '%' err.txt; do
        kill -0 $! || die 'it ended before it was met'
        sleep 0.05
    done
    kill -$signal $!
    sleep 0.2
    kill -$signal $! 2>/dev/null || true
    code=0
    wait $! || code=$?
    [ $code -eq 5 ] || die "SIG$signal: exit code $code, expected 5"
    said err.txt 'fathom: interrupted; the image is written as far as it got'
    same i.partial.exr i.partial.exr
done

# While it reads or builds there is nothing to save: no output, no file left, code 5.
run 0 generate terrain -t 2M -o large.obj
rm -f i.exr i.partial.exr
stop INT 0.1 render large.obj -o i.exr --stats i2.json
[ $code -eq 5 ] || die "while reading: exit code $code, expected 5"
said err.txt 'fathom: interrupted; nothing was written'
[ ! -e i.exr ] && [ ! -e i.partial.exr ] && [ ! -e i2.json ] || die 'an output of nothing'
rm -f large.obj large.mtl

# While a mesh is made or written: nothing is left.
for after in 0.1 0.6; do
    stop INT $after generate terrain -t 8M -o larger.obj
    [ $code -eq 5 ] || die "generate: exit code $code, expected 5"
    ls -A | grep larger && die 'generate: something was left behind'
done

# A second one ends it on the spot, by the signal itself, and leaves nothing half-written. Large images keep it
# writing for a while after the first. (SIGTERM: a shell has its background jobs ignore SIGINT.)
"$FATHOM" render heavy.glb -o i.png -o i.tif -o i.exr -o j.png --spp 65536 --size 5000x5000 >out.txt 2>err.txt &
sleep 3
kill -TERM $!
sleep 0.4
kill -TERM $!
code=0
wait $! || code=$?
[ $code -eq 143 ] || die "a second signal: exit code $code, expected 143"
ls -A | grep tmp && die 'a second signal: a temporary file was left behind'

# What was started with SIGINT ignored, as a shell starts its background jobs, goes on ignoring it.
spp=1
while :; do
    begin=$(now)
    "$FATHOM" render heavy.glb -o i.exr --size 640x360 --spp $spp >out.txt 2>err.txt &
    sleep 0.7
    alive=yes
    kill -INT $! 2>/dev/null || alive=no
    code=0
    wait $! || code=$?
    [ $code -eq 0 ] || die "an ignored signal: exit code $code, expected 0"
    [ $alive = no ] || break
    spp=$((spp * 4))
done
