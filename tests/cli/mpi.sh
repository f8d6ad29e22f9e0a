# fathom render --mpi: several ranks make the image of one process, and a rank that dies loses nothing that is finished.
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
    code=0
    mpirun --oversubscribe -n "$count" "$FATHOM" "$@" --mpi --threads 1 >out.txt 2>err.txt || code=$?
    [ $code -eq "$wanted" ] || die "$count ranks of fathom $*: exit code $code, expected $wanted"
}

refused 2 "--mpi: a part is one process's work" render scene.json -o a.part --part 1/2 --mpi
for arguments in '--spp 16 --aov all --crop 5,3,90,61' '--integrator path --spp 8' '--target-error 0.02 --spp 64 --aov samples'; do
    # shellcheck disable=SC2086
    run 0 render scene.json $arguments -o one.exr --exr-float
    # shellcheck disable=SC2086
    ranks 0 3 render scene.json $arguments -o all.exr --exr-float
    [ "$(grep -c 'all.exr: ' out.txt)" -eq 1 ] || die 'not one rank alone tells of the image'
    same one.exr all.exr
done
# A rank that renders something else is told of, and there is no image.
code=0
mpirun --oversubscribe -n 1 "$FATHOM" render scene.json -o a.exr --mpi --spp 1024 : \
    -n 1 "$FATHOM" render scene.json -o a.exr --mpi --spp 4096 >out.txt 2>err.txt || code=$?
[ $code -eq 3 ] || die "another rank's settings: exit code $code, expected 3"
said err.txt 'rank 1 renders with spp 4096, and rank 0 with 1024'
[ ! -e a.exr ] || die 'an image of two different renders'

# A rank is killed: the job ends, and goes on with another number of ranks.
long="scene.json --size 240x180 --spp 400 --exr-float"
# shellcheck disable=SC2086
{
    run 0 render $long -o one.exr
    mpirun --oversubscribe -n 3 sh -c 'echo $$ >pid.$OMPI_COMM_WORLD_RANK; exec "$@"' rank "$FATHOM" render $long -o all.exr --mpi --threads 1 --checkpoint c \
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
