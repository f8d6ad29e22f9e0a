# No room for temporary files: $TMPDIR is full, missing, or of a kind that nobody may write to. Each command does without,
# or ends with code 4 and one message; nothing is left. Twice: with a library that has writing fail there, and, as root and
# where mount works, with file systems that are full.
. "$SOURCE/tests/cli/check.inc"

there() { ls -A "$TMPDIR" 2>/dev/null || true; }
# needs_none ARGUMENT…: the command has no need of temporary files.
needs_none() {
    held=$(there)
    full run 0 "$@"
    [ "$(there)" = "$held" ] || die "$*: left in \$TMPDIR: $(there)"
}
# stopped TEXT ARGUMENT…: it has, and says so in a line.
stopped() {
    text=$1
    shift
    before=$(ls -A)
    held=$(there)
    full run 4 "$@"
    [ "$(wc -l <err.txt)" -eq 1 ] || die "$*: expected one line on stderr"
    said err.txt "$text"
    [ "$before" = "$(ls -A)" ] || die "$*: files came or went: $(ls -A)"
    [ "$(there)" = "$held" ] || die "$*: left in \$TMPDIR: $(there)"
}

# without_tmp TEXT: $TMPDIR is of no use; what the benches say of that.
without_tmp() {
    needs_none render scene.json -o a.png
    same a.png good.png
    rm a.png
    stopped "$1" bench render --triangles 1k --size 16x16 --spp 1 --repeats 1 --json g.json
    stopped "$1" bench render scene.json --size 16x16 --spp 1 --repeats 1 --threads 1 --quiet --json r.json
}

write_scene
run 0 render scene.json -o good.png
if [ -z "${IN_EARNEST:-}" ]; then
    # ---- missing, no folder, not to be written to ----
    full() { "$@"; }
    export TMPDIR
    # Not even root may write to /sys; where it is not mounted, as in some roots of other systems, it is a folder like others.
    kernel=
    [ "$(stat -f -c %T /sys 2>/dev/null)" != sysfs ] || kernel=/sys
    for TMPDIR in "$PWD/nowhere" "$PWD/scene.json" $kernel; do
        without_tmp 'expected a folder for temporary files in $TMPDIR'
    done

    # ---- ended on the way ----
    mkdir room
    TMPDIR=$PWD/room
    "$FATHOM" bench render --triangles 10k --repeats 100 --seconds 1000 --quiet >out.txt 2>err.txt &
    bench=$!
    while [ -z "$(find room -name 'fathom-*.glb' -size +0)" ] && kill -0 $bench 2>/dev/null; do sleep 0.05; done
    kill $bench
    code=0
    wait $bench || code=$?
    [ $code -eq 5 ] || die "bench render: ended by a signal: exit code $code, expected 5"
    rmdir room || die "bench render left $(ls room)"

    # ---- full, as a library has it ----
    # Sanitizers want their own library to be the first.
    sanitizer=$(ldd "$FATHOM" | sed -n 's/.*=> \(.*lib[alt]*san\.so[^ ]*\) .*/\1/p' | tr '\n' ' ')
    full() {
        export FAULT_CALL=write FAULT_FILE=no-room FAULT_ERROR=28 FAULT_AFTER=0
        export LD_PRELOAD="$sanitizer$BUILD/tests/faults/disk.so"
        ended=0
        "$@" || ended=$?
        unset LD_PRELOAD
        return $ended
    }
    mkdir no-room
    TMPDIR=$PWD/no-room
    without_tmp 'cannot be written: No space left on device'
    # Rescued pixels do not need it.
    mkdir no-room/here
    cp scene.json no-room/here/
    cd no-room/here
    name=fathom-test-$$
    code=0
    full "$FATHOM" render scene.json -o $name.png >../../out.txt 2>../../err.txt || code=$?
    cd ../..
    [ $code -eq 4 ] || die "no room for the image: exit code $code, expected 4"
    said err.txt "fathom: $name.png: cannot be written: No space left on device"
    not_said err.txt rescue # known before anything is rendered
    rm -r no-room

    # ---- full, in earnest ----
    # The remaining part runs by itself, in a space of mounts of its own.
    if [ "$(id -u)" -eq 0 ] && unshare -m mount -t tmpfs -o size=64k none /mnt 2>/dev/null; then
        mkdir earnest
        (cd earnest && IN_EARNEST=yes unshare -m sh -eu "$SOURCE/tests/cli/full_tmp.sh") || exit 1
        rm -r earnest
    else
        echo 'no mounts here: the library alone had writing fail'
    fi
    exit 0
fi

full() { "$@"; }
# fill FOLDER BYTES: so many bytes are left.
fill() {
    dd if=/dev/zero of="$1/filler" bs=4096 count=$((16 - $2 / 4096)) 2>/dev/null
    [ "$(df --output=avail -B 1 "$1" | tail -n 1)" -eq "$2" ] || die "$1 is not filled as it should be"
}
mkdir no-room
mount -t tmpfs -o size=64k none no-room
fill no-room 0
TMPDIR=$PWD/no-room
without_tmp 'cannot be written: No space left on device'
full refused 4 'fathom: no-room/a.png: cannot be written: No space left on device' render scene.json -o no-room/a.png
# Room for the trial before rendering, not for the image, nor for its pixels beside it: the working folder is next.
rm no-room/filler
fill no-room 8192
run 4 render scene.json -o no-room/a.png --size 192x128
said err.txt 'fathom: no-room/a.png: cannot be written: No space left on device'
said err.txt 'fathom: the pixels are in a.rescue.exr, as scene-linear EXR'
[ "$(ls -A no-room)" = filler ] || die "left on the full disk: $(ls -A no-room)"
rm a.rescue.exr
# The working folder is on that disk as well, and $TMPDIR has room.
mkdir room
TMPDIR=$PWD/room
code=0
(cd no-room && exec "$FATHOM" render ../scene.json -o a.png --size 192x128 >../out.txt 2>../err.txt) || code=$?
[ $code -eq 4 ] || die "the working folder is full: exit code $code, expected 4"
said err.txt "fathom: the pixels are in $PWD/room/a.rescue.exr, as scene-linear EXR"
run 0 render scene.json -o wide.exr --exr-float --size 192x128
same room/a.rescue.exr wide.exr
[ "$(ls -A no-room)" = filler ] || die "left on the full disk: $(ls -A no-room)"
rm room/a.rescue.exr
# No place at all has room. /tmp can only be covered where nothing of the test lies in it.
case $PWD$FATHOM$SOURCE in
*/tmp/*) ;;
*)
    mount -t tmpfs -o size=64k none /tmp
    fill /tmp 8192
    TMPDIR=$PWD/nowhere
    code=0
    (cd no-room && exec "$FATHOM" render ../scene.json -o a.png --size 192x128 >../out.txt 2>../err.txt) || code=$?
    [ $code -eq 4 ] || die "no room anywhere: exit code $code, expected 4"
    said err.txt 'fathom: the pixels are lost: they could be written neither next to that file nor in the working folder, $TMPDIR or /tmp'
    [ "$(ls -A no-room)$(ls -A /tmp)" = fillerfiller ] || die 'something is left on a full disk'
    umount /tmp
    ;;
esac
umount no-room
