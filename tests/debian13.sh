#!/bin/sh
# Builds and tests on Debian 13 (Embree 4) from any Debian: makes a root with debootstrap, once, and runs
# tests/run.sh release in it on a copy of the committed tree. Needs root. Safe to run again.
# usage: sh tests/debian13.sh [ROOT]     (default: /var/tmp/fathom-debian13)
set -eu
cd "$(dirname "$0")/.."
root=${1:-/var/tmp/fathom-debian13}

stop() {
    echo "fathom debian13: $*" >&2
    exit 1
}
[ "$(id -u)" -eq 0 ] || stop "needs root, for chroot"
if [ ! -x "$root/usr/bin/apt-get" ]; then
    command -v debootstrap >/dev/null || apt-get install -y --no-install-recommends debootstrap >/dev/null ||
        stop "debootstrap is missing and could not be installed"
    echo "Making a Debian 13 root in $root"
    debootstrap --variant=minbase --include=ca-certificates trixie "$root" >"$root.log" 2>&1 ||
        stop "debootstrap failed; its log is $root.log"
fi
mounted=""
leave() {
    for place in $mounted; do umount -l "$root/$place" || true; done
}
trap leave EXIT
for place in proc dev; do
    mountpoint -q "$root/$place" && continue
    mount --rbind "/$place" "$root/$place"
    mount --make-rslave "$root/$place"
    mounted="$mounted $place"
done
cp /etc/resolv.conf "$root/etc/resolv.conf" 2>/dev/null || true
source=/var/tmp/fathom-source
rm -rf "$root$source"
mkdir -p "$root$source"
git archive HEAD | tar -x -C "$root$source"
chroot "$root" env HOME=/root FATHOM_BUILD=/var/tmp/fathom-build sh $source/tests/run.sh release
