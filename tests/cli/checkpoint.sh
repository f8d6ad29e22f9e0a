# --checkpoint, --checkpoint-every, --resume, SIGUSR1: work that survives, and what is refused.
# shellcheck disable=SC2086 # options are words
. "$SOURCE/tests/cli/check.inc"
. "$SOURCE/tests/kill/kill.inc"
write_scene
# Long enough on one thread to be met on its way by a signal: a second of this machine.
spp=100
while :; do
    long="scene.json --size 240x180 --spp $spp --aov all --exr-float"
    begun=$(now)
    run 0 render $long -o whole.exr --threads 1
    awk "BEGIN { exit !($(now) - $begun < 1) }" || break
    spp=$((spp * 4))
done

# Errors are told before anything is rendered.
refused 2 '--resume: only with --checkpoint FILE' render scene.json -o a.exr --resume
refused 2 '--checkpoint-every: only with --checkpoint FILE' render scene.json -o a.exr --checkpoint-every 5
refused 2 '--checkpoint-every: expected a number from 0' \
    render scene.json -o a.exr --checkpoint c --checkpoint-every -1
refused 2 'a.exr: the same file is named twice' render scene.json -o a.exr --checkpoint ./a.exr
refused 2 'scene.json: is the input' render scene.json -o a.exr --checkpoint scene.json --resume
refused 4 'none/c: cannot be written: its folder does not exist' render scene.json -o a.exr --checkpoint none/c
refused 4 'cannot be written: is not a regular file' render scene.json -o a.exr --checkpoint . --resume

phase=render

# SIGUSR1 saves and goes on; SIGTERM saves, writes the image as far as it got, and stops.
{
    start render $long -o a.exr --checkpoint c --threads 1
    kill -STOP $child
    # Nobody writes over what another saves, be it the same render, and before there is anything.
    refused 2 'c: another render saves its work there' render scene.json -o b.exr --checkpoint c --resume -q
    kill -USR1 $child
    kill -CONT $child
    until grep -q 'c: saved at [0-9]* %' err.txt; do
        kill -0 $child 2>/dev/null || die 'it ended before it saved'
        sleep 0.05
    done
    [ -s c ] || die 'SIGUSR1 left no checkpoint'
    kill -TERM $child
    end 5
    said err.txt 'interrupted; the unfinished image is written to a.partial.exr; --resume continues'
    differ whole.exr a.partial.exr
    [ ! -e a.exr ] || die 'a partial image under the name of a finished one'
    [ -s c ] || die 'SIGTERM left no checkpoint'
    [ ! -e c.fathom-lock ] || die 'SIGTERM left a lock'

    # Whoever forgets --resume does not lose it; nor does another render take it.
    cp c kept
    refused 2 'c: the file exists, and may hold hours of work' render $long -o b.exr --checkpoint c
    refused 3 "fathom: c: the checkpoint was saved with --spp $spp, and this render has 256" \
        render $long -o b.exr --checkpoint c --resume --spp 256 --quiet
    refused 3 'saved with the tracer' render $long -o b.exr --checkpoint c --resume --tracer bvh --quiet
    sed 's/0.8, 0.8, 0.8/0.8, 0.8, 0.7/' scene.json >other.json
    refused 3 'saved with a scene of contents' \
        render other.json -o b.exr --size 240x180 --spp $spp --aov all --checkpoint c --resume --quiet
    head -c 5000 kept >cut
    refused 3 'cut: the checkpoint is damaged: its checksum does not fit, or it was cut short' \
        render $long -o b.exr --checkpoint cut --resume --quiet
    cp scene.json scene.copy
    refused 3 'scene.copy: is not a checkpoint' \
        render $long -o b.exr --checkpoint scene.copy --resume --quiet
    cmp c kept

    # An image that cannot be written leaves it where it is.
    [ -n "$SANITIZE" ] || {
        expect 4 env FAULT_CALL=rename FAULT_FILE=b.exr FAULT_ERROR=28 FAULT_AFTER=0 "LD_PRELOAD=$BUILD/tests/faults/disk.so" \
            "$FATHOM" render $long -o b.exr --checkpoint c --resume
        said err.txt 'fathom: c: is kept; --resume continues from what was saved last'
        same whole.exr b.rescue.exr
        rm b.rescue.exr
        [ -s c ] || die 'the checkpoint is gone, and the image could not be written'
        cp kept c
    }

    # It is continued, says so, and goes once the image is there; so does what killed processes left beside it.
    : >c.fathom-tmp1
    : >a.fathom-tmp1.exr
    run 0 render $long -o a.exr --checkpoint c --resume --threads 3 --stats a.json -v
    said out.txt 'resumed after '
    same whole.exr a.exr
    said a.json '"resumed": true'
    awk "BEGIN { exit !($(number a.json resumedSamples) > 0) }" || die 'no sample was resumed'
    [ ! -e c ] && [ ! -e c.fathom-tmp1 ] && [ ! -e a.fathom-tmp1.exr ] && [ ! -e a.partial.exr ] || die 'something was left'
}

# Where there is none it begins, and says so.
run 0 render scene.json -o a.exr --checkpoint c --resume
said err.txt 'fathom: warning: c: there is no checkpoint yet; rendering from the beginning'
run 0 render scene.json -o b.exr
same a.exr b.exr

# Without --checkpoint SIGUSR1 is harmless.
start render $long -o b.exr --threads 1
kill -USR1 $child
until grep -q 'SIGUSR1: nothing is saved without --checkpoint FILE' err.txt; do
    kill -0 $child 2>/dev/null || die 'it ended before it answered'
    sleep 0.05
done
kill -TERM $child
end 5

# With a time limit, the time spent before counts, and no sample is lost.
start render scene.json -o t.exr --size 160x120 --max-time 20 --checkpoint t --aov all
kill -TERM $child
end 5
run 0 render scene.json -o t.exr --size 160x120 --max-time 2 --checkpoint t --resume --aov all --stats t.json
awk "BEGIN { exit !($(number t.json resumedSeconds) > 0) }" || die 'nothing was resumed'
[ ! -e t ] || die 'the checkpoint of a time is left'

# Killed at random moments, many of them while it saves. tests/kill.sh does more.
survive 5 1 400 scene.json --size 160x120 --spp 64 --aov all --exr-float
survive 5 1000 400 scene.json --size 160x120 --target-error 0.004 --spp 1024 --aov all --exr-float
[ "$writing" -gt 0 ] || die 'no kill met a file in the writing'
