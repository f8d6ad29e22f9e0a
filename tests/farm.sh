#!/bin/sh
# Parts by GNU parallel, and scenes/farm/slurm.sh against a real slurmctld and slurmd on this machine: an array of four
# parts, of which one is requeued while it renders and one is killed, and the merge. Each must give the image of one
# process.
# Needs root, and Debian's parallel, slurm-wlm and munge; touches neither the machine's own Slurm nor its munge.
# Takes about three minutes: Slurm waits two before it starts a requeued task.
# usage: sh tests/farm.sh [BUILD]     (default: build/release)
set -eu
cd "$(dirname "$0")/.."
source=$PWD
FATHOM=$(cd "${1:-build/release}" && pwd)/bin/fathom
export FATHOM
place=$(mktemp -d)
chmod 755 "$place"
daemons=""
stop() {
    # shellcheck disable=SC2086 # the list is numbers
    [ -z "$daemons" ] || kill $daemons 2>/dev/null || true
    wait
    rm -rf "$place"
}
trap stop EXIT
trap 'exit 1' INT TERM
fail() {
    echo "FAILED: $*" >&2
    tail -n 20 "$place"/*.log "$place"/out/*.parts/*.log >&2 || true
    exit 1
}

mkdir "$place/state" "$place/spool" "$place/out"
cd "$place/out"
scene=$source/scenes/example.json
"$FATHOM" render "$scene" -o one.exr --quiet --size 480x300 --spp 256
parallel --will-cite "$FATHOM" render "$scene" -o {}.part --part {}/4 --quiet --size 480x300 --spp 256 --threads 1 ::: 1 2 3 4
"$FATHOM" merge ./*.part -o parallel.exr --quiet
"$FATHOM" compare one.exr parallel.exr || fail "GNU parallel: the merged image is another one"
rm ./*.part
echo "GNU parallel, 4 parts: the image of one process"

dd if=/dev/urandom of="$place/key" bs=1024 count=1 2>/dev/null
chmod 400 "$place/key"
munged --foreground --force --key-file="$place/key" --socket="$place/socket" --pid-file="$place/munged.pid" \
    --log-file="$place/munged.log" --seed-file="$place/seed" 2>/dev/null &
daemons=$!
cat >"$place/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$(hostname)(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$place/socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
StateSaveLocation=$place/state
SlurmdSpoolDir=$place/spool
SlurmctldPidFile=$place/slurmctld.pid
SlurmdPidFile=$place/slurmd.pid
SlurmctldLogFile=$place/slurmctld.log
SlurmdLogFile=$place/slurmd.log
ReturnToService=2
SchedulerParameters=sched_min_interval=100000,bf_interval=1
KillWait=5
NodeName=$(hostname) NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF="$place/slurm.conf"
slurmctld -D -c >/dev/null 2>&1 &
daemons="$daemons $!"
slurmd -D >/dev/null 2>&1 &
daemons="$daemons $!"
for i in $(seq 100); do
    sinfo -h -o %t 2>/dev/null | grep -q idle && break
    [ "$i" -lt 100 ] || fail "no node became idle"
    sleep 0.2
done

sh "$source/scenes/farm/slurm.sh" "$scene" "$place/out/all.exr" 4 --size 480x300 --spp 256 --threads 1
array=$(squeue -h --name=fathom -o %F | head -n 1)
for i in $(seq 300); do
    [ -s all.exr.parts/1.part ] && [ -s all.exr.parts/2.part ] && break
    [ "$i" -lt 300 ] || fail "no part began"
    sleep 0.1
done
sleep 1
scontrol requeue "${array}_1" || fail "part 1 could not be requeued"
victim=$(pgrep -f "^$FATHOM render .* -o $place/out/all.exr.parts/2.part" | head -n 1) || true
[ -z "$victim" ] || kill -9 "$victim"
for i in $(seq 600); do
    [ -e all.exr ] && [ ! -e all.exr.parts ] && break
    [ "$i" -lt 600 ] || fail "no merged image: $(squeue -h)"
    sleep 0.5
done
"$FATHOM" compare one.exr all.exr || fail "the merged image is another one"
echo "Slurm, an array of 4 parts, part 1 requeued, part 2 ${victim:+killed and requeued}: the image of one process"
