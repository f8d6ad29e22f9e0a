# fathom render --mpi: several ranks make the image of one process, and a rank that dies loses nothing that is finished.
# shellcheck disable=SC2086 # options are words
. "$SOURCE/tests/cli/check.inc"
write_scene
if [ ! -e "$BUILD/lib/fathom/fathom_mpi.so" ] || ! command -v mpirun >/dev/null; then
    refused 4 'MPI: this Fathom was built without fathom/fathom_mpi.so' render scene.json -o a.exr --mpi
    echo "skipped: this build has no Open MPI (Debian: libopenmpi-dev, openmpi-bin)"
    exit 77
fi
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
# Sanitizers do not know what MPI and its parts keep; those are not ours.
export ASAN_OPTIONS=detect_leaks=0:detect_odr_violation=0

# ranks CODE COUNT ARGUMENT…: so many ranks of fathom with these arguments.
ranks() {
    wanted=$1 count=$2
    shift 2
    expect "$wanted" mpirun --oversubscribe -n "$count" "$FATHOM" "$@" --mpi --threads 1
}

refused 2 "--mpi: one process renders a part" render scene.json -o a.part --part 1/2 --mpi
for arguments in '--spp 16 --aov all --crop 5,3,90,61' '--integrator path --spp 8' '--target-error 0.02 --spp 64 --aov samples'; do
    run 0 render scene.json $arguments -o one.exr --exr-float
    ranks 0 3 render scene.json $arguments -o all.exr --exr-float
    [ "$(grep -c 'all.exr: ' out.txt)" -eq 1 ] || die 'not one rank alone tells of the image'
    same one.exr all.exr
done
# A rank that renders something else is told of, and there is no image.
code=0
# One command for both ranks: the mpirun of Debian 13 crashes on two commands with ":" between them.
# shellcheck disable=SC2016
mpirun --oversubscribe -n 2 sh -c 'exec "$0" render scene.json -o a.exr --mpi --spp $((1024 + 3072 * OMPI_COMM_WORLD_RANK))' \
    "$FATHOM" >out.txt 2>err.txt || code=$?
[ $code -eq 3 ] || die "another rank's settings: exit code $code, expected 3"
said err.txt 'rank 1 renders with --spp 4096, and rank 0 with 1024'
[ ! -e a.exr ] || die 'an image of two different renders'

# A rank is killed: the job ends, and goes on with another number of ranks.
long="scene.json --size 240x180 --spp 400 --exr-float"
{
    run 0 render $long -o one.exr
    # After a kill the mpirun of Debian 12 sometimes waits for ever for its own lock, with all ranks gone.
    timeout -k 5 200 mpirun --oversubscribe -n 3 sh -c 'echo $$ >pid.$OMPI_COMM_WORLD_RANK; exec "$@"' rank "$FATHOM" render $long -o all.exr --mpi --threads 1 --checkpoint c \
        --checkpoint-every 0.01 --quiet >out.txt 2>err.txt &
    job=$!
    until [ -s c ]; do
        kill -0 $job 2>/dev/null || die 'it ended before it saved'
        sleep 0.02
    done
    kill -9 "$(cat pid.2)"
    code=0
    wait $job || code=$?
    [ $code -ne 0 ] || die 'a job with a rank that was killed ends well'
    [ -s c ] || die 'the checkpoint is gone'
    ranks 0 2 render $long -o all.exr --checkpoint c --resume --stats all.json
    same one.exr all.exr
    [ "$(number all.json resumedSamples)" -gt 0 ] || die 'nothing was resumed'
    [ ! -e c ] || die 'the checkpoint is left'
}

# A rank that cannot open the scene's files gets them from rank 0, and leaves none behind.
mkdir -p shared/meshes elsewhere tmp
printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n-1 0 0\n1 0 0\n0 1 1\n3 0 1 2\n' >shared/meshes/t.ply
run 0 render scene.json --size 32x16 -o shared/sky.exr
sed 's|"objects": \[|"objects": [ { "type": "mesh", "file": "meshes/t.ply" },|; s|"classic"|"path"|
    s|"lights": \[|"lights": [ { "type": "environment", "file": "sky.exr" },|' scene.json >shared/scene.json
run 0 render shared/scene.json --spp 16 -o one.exr --exr-float
there() {
    code=0
    # shellcheck disable=SC2016,SC2086
    TMPDIR=$PWD/tmp mpirun --oversubscribe -n 2 sh -c '[ $OMPI_COMM_WORLD_RANK -eq 0 ] || cd elsewhere; exec "$0" "$@"' \
        "$FATHOM" render "$1" --spp 16 -o all.exr --exr-float --mpi $2 >out.txt 2>err.txt || code=$?
}
there shared/scene.json ''
[ $code -eq 0 ] || die "a rank without the scene's files: exit code $code"
same one.exr all.exr
[ -z "$(ls -A elsewhere)" ] && ! ls -d tmp/fathom-* 2>/dev/null || die 'files of rank 0 are left'
sed 's|meshes/t.ply|../t.ply|' shared/scene.json >shared/outside.json
cp shared/meshes/t.ply t.ply
there shared/outside.json --allow-outside
[ $code -eq 3 ] || die "a file outside of the scene's folder: exit code $code, expected 3"
said err.txt 't.ply: cannot be opened by rank 1, and rank 0 cannot send it; expected a file below the folder of the scene'
! ls -d tmp/fathom-* 2>/dev/null || die 'files of rank 0 are left after a failure'
