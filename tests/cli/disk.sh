# A disk that fails under an image loses no pixels, and nothing half is left under the final name.
. "$SOURCE/tests/cli/check.inc"
write_scene
"$FATHOM" render scene.json -o good.exr --exr-float --size 384x256 >/dev/null

# fault CALL FILE ERROR AFTER ARGUMENT…: a render whose disk fails so; it has to end with code 4.
fault() {
    call=$1 file=$2 error=$3 after=$4
    shift 4
    expect 4 env FAULT_CALL=$call FAULT_FILE=$file FAULT_ERROR=$error FAULT_AFTER=$after "LD_PRELOAD=$BUILD/tests/faults/disk.so" \
        "$FATHOM" "$@"
}
# rescued FILE: the pixels are in there, and nothing else came.
rescued() {
    said err.txt "fathom: the pixels are in $1, as scene-linear EXR"
    same "$1" good.exr
    rm "$1"
    [ "$(ls -A)" = "$(printf 'err.txt\ngood.exr\nout.txt\nscene.json')" ] || die "left behind: $(ls -A)"
}

# The sanitizers' own library has to be loaded first of all.
if [ -z "$SANITIZE" ]; then
    for name in a.png a.jpg a.tif a.exr; do
        stem=${name%.*}
        # Input/output error a little after the trial of 4096 bytes that comes before rendering, and later.
        for after in 4200 6000; do
            [ $after = 6000 ] || [ $name = a.png ] || continue
            fault write "$stem.fathom-tmp" 5 $after render scene.json -o $name --size 384x256
            said err.txt "fathom: $name: cannot be written: Input/output error"
            rescued a.rescue.exr
        done
        case $name in a.jpg | a.tif) continue ;; esac
        # The disk's own cache could not be written, as is learnt when waiting for it.
        fault fsync "$stem.fathom-tmp" 5 0 render scene.json -o $name --size 384x256
        said err.txt "fathom: $name: cannot be written: Input/output error"
        rescued a.rescue.exr
        # No space left on device.
        fault rename "$name" 28 0 render scene.json -o $name --size 384x256
        said err.txt "fathom: $name: cannot be written: No space left on device"
        rescued a.rescue.exr
    done
    # Existing files stay, as does a rescued image of an earlier run.
    echo old >a.png
    echo old >a.rescue.exr
    fault write a.fathom-tmp 5 6000 render scene.json -o a.png --size 384x256
    [ "$(cat a.png a.rescue.exr)" = "$(printf 'old\nold')" ] || die 'a file that was there is gone'
    rm a.png a.rescue.exr
    rescued a.rescue-2.exr
    # An image that holds all channels is no worse than a rescued one.
    fault write a.fathom-tmp 5 6000 render scene.json -o a.png -o b.exr --exr-float --size 384x256
    same b.exr good.exr
    [ ! -e a.rescue.exr ] || die 'rescued, though b.exr holds all'
    rm b.exr
    # A folder that is full: the next place is the working folder.
    mkdir folder
    fault write folder/a 28 6000 render scene.json -o folder/a.png --size 384x256
    [ -z "$(ls -A folder)" ] || die "left in the folder: $(ls -A folder)"
    rmdir folder
    rescued a.rescue.exr
    # The longest name there is, which nothing can be added to.
    long=$(printf '%0251d' 0)
    fault rename "$long.png" 28 0 render scene.json -o "$long.png" --size 384x256
    rescued "$(printf '%0227d' 0).rescue.exr"
    # All names beside it are taken, a thousand of them: likewise.
    mkdir folder
    for i in "" $(seq -f -%g 2 1000); do : >"folder/a.rescue$i.exr"; done
    fault write folder/a.fathom-tmp 5 6000 render scene.json -o folder/a.png --size 384x256
    rm -r folder
    rescued a.rescue.exr
    # Several at once, whose disk is full for all: each has its own.
    for i in 1 2 3 4; do
        FAULT_CALL=rename FAULT_FILE=a.png FAULT_ERROR=28 FAULT_AFTER=0 LD_PRELOAD=$BUILD/tests/faults/disk.so \
            "$FATHOM" render scene.json -o a.png --size 384x256 >/dev/null 2>&1 &
    done
    wait
    for name in a.rescue a.rescue-2 a.rescue-3 a.rescue-4; do
        same $name.exr good.exr
        rm $name.exr
    done
    # No place at all: it is said.
    fault write .fathom-tmp 28 4096 render scene.json -o a.png --size 256x256
    said err.txt 'fathom: the pixels are lost: they could be written neither next to that file nor in the working folder, $TMPDIR or /tmp'
    # The other results that are kept in files.
    fault write stats.fathom-tmp 5 4096 bench render scene.json --spp 1 --threads 1 --repeats 1 --quiet --json stats.json
    said err.txt 'stats.json: cannot be written: Input/output error'
    fault write mesh.fathom-tmp 5 100000 generate sphere --triangles 10k -o mesh.glb
    said err.txt 'mesh.glb: cannot be written: Input/output error'
    rm -f out.txt err.txt
    [ "$(ls -A)" = "$(printf 'good.exr\nscene.json')" ] || die "left behind: $(ls -A)"
    # Work that cannot be saved, after two trials of 4096 bytes that went well: that is said, and rendering continues. Whoever
    # stops it then is told that the work is lost.
    FAULT_CALL=write FAULT_FILE=c.fathom-tmp FAULT_ERROR=28 FAULT_AFTER=9000 LD_PRELOAD=$BUILD/tests/faults/disk.so \
        "$FATHOM" render scene.json -o a.png --size 1024x1024 --tracer linear:f64 --spp 65536 --checkpoint c --checkpoint-every 0.1 \
        >out.txt 2>err.txt &
    program=$!
    until grep -q 'fathom: c: cannot be written: No space left on device; rendering continues, and the next save tries again' err.txt; do
        kill -0 $program 2>/dev/null || die 'it ended before it saved'
        sleep 0.05
    done
    kill -TERM $program
    code=0
    wait $program || code=$?
    [ $code -eq 4 ] || die "stopped without its work saved: exit code $code, expected 4"
    said err.txt 'fathom: interrupted; the unfinished image is written, but the work could not be saved to c'
    rm a.partial.png out.txt err.txt
    [ "$(ls -A)" = "$(printf 'good.exr\nscene.json')" ] || die "left behind: $(ls -A)"
    # Known before anything is rendered: no room for a single page.
    fault write a.fathom-tmp 28 0 render scene.json -o a.png
    said err.txt 'fathom: a.png: cannot be written: No space left on device'
    not_said err.txt rescue
fi

# A limit of the shell on the size of files (blocks of 512 or 1024 bytes), of which a signal would tell.
code=0
(ulimit -f 16 && exec "$FATHOM" render scene.json -o a.tif --size 256x256) >out.txt 2>err.txt || code=$?
[ $code -eq 4 ] || die "a limit on files: exit code $code, expected 4"
said err.txt 'a.tif: cannot be written: File too large'
said err.txt 'the pixels are lost'

# Results that nobody takes: a device that is full, a pipe that nobody reads, no stream at all.
if [ -c /dev/full ]; then
    code=0
    "$FATHOM" render scene.json -o a.png >/dev/full 2>err.txt || code=$?
    [ $code -eq 4 ] || die "/dev/full: exit code $code, expected 4"
    said err.txt 'fathom: standard output cannot be written: No space left on device'
    same a.png a.png
    "$FATHOM" render scene.json -o b.png >out.txt 2>/dev/full || die 'a full stderr is no failure'
    same a.png b.png || die 'a full stderr changed the image'
fi
mkfifo pipe
(exec <pipe) &
{ wait; code=0; "$FATHOM" help render 2>err.txt || code=$?; echo $code >code.txt; } >pipe
[ "$(cat code.txt)" -eq 4 ] || die "a closed pipe: exit code $(cat code.txt), expected 4"
said err.txt 'fathom: standard output cannot be written: Broken pipe'
code=0
"$FATHOM" render scene.json -o c.png >&- 2>err.txt || code=$?
[ $code -eq 4 ] || die "a closed stdout: exit code $code, expected 4"
said err.txt 'fathom: standard output cannot be written: Bad file descriptor'
same a.png c.png
"$FATHOM" render scene.json -o d.png --stats d.json <&- >&- 2>&- || true
same a.png d.png
said d.json '"width": 96'

# Two at once under one name: one of the two images, whole.
run 0 render scene.json -o wide.png --size 200x100
run 0 render scene.json -o high.png --size 100x200
for round in 1 2; do
    "$FATHOM" render scene.json -o both.png --size 200x100 >/dev/null 2>&1 &
    first=$!
    "$FATHOM" render scene.json -o both.png --size 100x200 >/dev/null 2>&1 &
    second=$!
    wait $first && wait $second || die 'one of two renders to one name failed'
    "$FATHOM" compare both.png wide.png >/dev/null 2>&1 || same both.png high.png
done
ls -A | grep tmp && die 'a temporary file was left behind'

# A module that is none is found out while the render runs, not at its end.
echo 'no library' >module.so
expect 4 env "FATHOM_IMAGE_MODULE=$PWD/module.so" "$FATHOM" render scene.json -o e.tif --size 2000x2000 --tracer linear:f64 --spp 1024
said err.txt 'fathom: e.tif: image helper: '
[ ! -e e.tif ] || die 'no module: there is an image'
