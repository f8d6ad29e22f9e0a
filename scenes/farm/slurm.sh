#!/bin/sh
# Renders one image on a Slurm cluster: an array of parts, and a job that merges them when all are done.
# usage: sh slurm.sh SCENE IMAGE PARTS [OPTION of fathom render ...]
# SBATCH_* variables choose partition, time and so on. The folder of IMAGE has to be shared by all nodes, and so has SCENE.
# A task that is preempted, killed, runs out of time or loses its node is put back into the queue and goes on from its
# part. If one fails for good, the merge says which part is missing or not finished: mend the cause, and call this again
# with the same words. Finished parts are kept.
set -eu
[ $# -ge 3 ] || { sed -n '2,7p' "$0" >&2; exit 2; }
scene=$1 image=$2 parts=$3
shift 3
fathom=$(command -v "${FATHOM:-fathom}")
folder=$image.parts
mkdir -p "$folder"

# Slurm sends SIGTERM a minute before the time is up; fathom then ends with 5.
array=$(sbatch --parsable --job-name=fathom --requeue --open-mode=append --signal=TERM@60 --array="1-$parts" \
    --output="$folder/%a.log" "$0.task" "$fathom" "$scene" "$folder" "$@")
# Not afterok: Slurm counts a task as failed that failed once, was requeued and then succeeded.
sbatch --parsable --job-name=fathom-merge --dependency="afterany:$array" \
    --output="$folder/merge.log" "$0.merge" "$fathom" "$image" "$folder"
