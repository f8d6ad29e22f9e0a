# fathom render --part and fathom merge: many machines make the image of one, whatever happens to them on the way.
# shellcheck disable=SC2086 # options are words
. "$SOURCE/tests/cli/check.inc"
unset SLURM_ARRAY_TASK_ID SLURM_ARRAY_TASK_COUNT SLURM_ARRAY_TASK_MIN SLURM_ARRAY_TASK_STEP
write_scene
scene="scene.json --spp 64 --aov all --pattern sobol"

# Errors are told before anything is read.
refused 2 '--part: expected K/N with 1 <= K <= N <= 65536, such as 3/16, found "0/3"' render none -o a.part --part 0/3
refused 2 '--part: expected K/N' render none -o a.part --part 4/3
refused 2 '--part: expected K/N' render none -o a.part --part 4
refused 2 '--part: only with -o FILE.part' render none -o a.exr --part 1/3
refused 2 '--split: only with -o FILE.part' render none -o a.exr --split tiles
refused 2 '-o a.part: a part must be the only output' render none -o a.part -o a.exr --part 1/3
refused 2 '--checkpoint: a part is its own checkpoint' render none -o a.part --part 1/3 --checkpoint c
refused 2 '-o a.part: --part K/N is missing, and there is no SLURM_ARRAY_TASK_ID' render none -o a.part
refused 4 'none/a.part: cannot be written: its folder does not exist' render scene.json -o none/a.part --part 1/3
refused 2 'fathom: PART is missing' merge -o a.exr
refused 2 'fathom: -o IMAGE is missing' merge a.part
refused 3 'a.part: ' merge a.part -o a.exr
refused 2 'a.exr: is the input' merge a.exr -o a.exr
refused 3 'scene.json: is not a part of an image' merge scene.json -o a.exr
refused 2 'split it by tiles' render scene.json -o a.part --part 1/2 --target-error 0.1 --split samples -q
refused 2 'cannot be split: the clock decides' render scene.json -o a.part --part 1/2 --max-time 9 -q

# The parts of a Slurm array, from 0, from 1, or in steps.
# task ID COUNT MIN STEP PART/COUNT
task() {
    expect 0 env SLURM_ARRAY_TASK_ID=$1 SLURM_ARRAY_TASK_COUNT=$2 SLURM_ARRAY_TASK_MIN=$3 SLURM_ARRAY_TASK_STEP=$4 \
        "$FATHOM" render scene.json -o a.part --stats a.json -q
    [ "$(number a.json index)/$(number a.json count)" = "$5" ] || die "task $1 of $2 is not part $5"
    rm a.part a.json
}
task 0 3 0 1 1/3
task 2 3 0 1 3/3
task 3 3 1 1 3/3
task 8 5 0 4 3/5
SLURM_ARRAY_TASK_ID=9 SLURM_ARRAY_TASK_COUNT=3 SLURM_ARRAY_TASK_MIN=1
export SLURM_ARRAY_TASK_ID SLURM_ARRAY_TASK_COUNT SLURM_ARRAY_TASK_MIN
refused 2 '-o a.part: task 9 is none of an array of 3 tasks from 1 on in steps of 1' render scene.json -o a.part
unset SLURM_ARRAY_TASK_ID SLURM_ARRAY_TASK_COUNT SLURM_ARRAY_TASK_MIN

# The image of all parts is the image of one machine, in every file; a part that is done is not rendered again.
{
    run 0 render $scene -o whole.exr -o whole.png --exr-float
    for part in 1 2 3; do
        run 0 render $scene -o p$part.part --part $part/3
        said out.txt "p$part.part: part $part of 3: 96x64"
    done
    cp p2.part kept
    run 0 render $scene -o p2.part --part 2/3
    cmp p2.part kept
    run 0 merge p*.part -o merged.exr -o merged.png --exr-float
    said out.txt 'merged.exr, merged.png: 96x64, 64.0 spp, of 3 parts'
    same whole.exr merged.exr
    same whole.png merged.png
    refused 3 'p1.part: is one of 3 parts, and missing are: 2' merge p1.part p3.part -o a.exr
    refused 3 'p1.part: is part 1 of 3, and so is p1.part' merge p1.part p1.part -o a.exr
    refused 3 'p2.part: the existing part was rendered with the number 2 of 3' \
        render $scene -o p2.part --part 2/4 -q
    head -c $(($(wc -c <kept) * 2 / 3)) kept >p2.part
    refused 3 'p2.part: part 2 of 3 holds ' merge p1.part p2.part p3.part -o a.exr
    said err.txt 'and then bytes that are damaged or cut off; run the same command again'
    run 0 render $scene -o p2.part --part 2/3 -v
    said out.txt 'resumed after '
    run 0 merge p*.part -o merged.exr --exr-float
    same whole.exr merged.exr
}

# A part keeps the exposure that it is given. Another one is refused, or told if other parts have it.
run 0 render scene.json -o whole.png --exposure 1
run 0 render scene.json -o exposed.part --part 1/1 --exposure 1
run 0 merge exposed.part -o merged.png
same whole.png merged.png
run 0 merge exposed.part -o merged.png --exposure 0
differ whole.png merged.png
refused 3 'exposed.part: the existing part was rendered with the exposure 1, and this render has 2.5' \
    render scene.json -o exposed.part --part 1/1 --exposure 2.5
run 0 render scene.json -o exposed.part --part 1/1
for k in 1 2; do run 0 render scene.json -o e$k.part --part $k/2 --exposure $k; done
run 0 merge e2.part e1.part -o merged.png
said err.txt 'e1.part: was rendered with the exposure 1, and e2.part with 2; the image takes that of part 1'
same whole.png merged.png
rm exposed.part e1.part e2.part

# Another instruction set is another tracer.
FATHOM_ISA=sse2 "$FATHOM" render $scene -o p2.part --part 2/3 -q >out.txt 2>err.txt && [ "$(grep -c avx2 /proc/cpuinfo)" = 0 ] ||
    said err.txt 'p2.part: the existing part was rendered with the tracer Embree'

# A disk that is full: what went before is kept.
[ -n "$SANITIZE" ] || {
    rm p2.part
    expect 4 env FAULT_CALL=write FAULT_FILE=p2.part FAULT_ERROR=28 FAULT_AFTER=$(($(wc -c <kept) / 2)) "LD_PRELOAD=$BUILD/tests/faults/disk.so" \
        "$FATHOM" render $scene -o p2.part --part 2/3 --threads 1
    said err.txt 'p2.part: cannot be written: No space left on device; what was finished before is kept'
    run 0 render $scene -o p2.part --part 2/3
    run 0 merge p*.part -o merged.exr --exr-float
    same whole.exr merged.exr
}

# SIGTERM keeps what is finished.
rm p*.part
phase=render
long="scene.json --size 320x240 --spp 4096"
{
    start render $long -o p1.part --part 1/2 --split tiles --threads 1
    # Nobody else writes to it meanwhile.
    refused 2 'p1.part: another render saves its work there' render $long -o p1.part --part 1/2 --split tiles -q
    kill -TERM $child
    end 5
    said err.txt 'interrupted; what is finished is in p1.part; run the same command again to continue'
}
rm p1.part

# Killed at random moments. tests/kill.sh does more.
. "$SOURCE/tests/kill/kill.inc"
survive_parts 5 1 samples scene.json --size 160x120 --spp 64 --aov all
survive_parts 5 500 tiles scene.json --size 160x120 --target-error 0.01 --spp 1024
