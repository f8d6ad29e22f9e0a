#!/bin/sh
# Installs what is missing of the distribution's packages for building, for making scenes as well ("scenes"), for testing
# as well ("test"), or for testing, fuzzing and static analysis ("clang").
# usage: sh tests/packages.sh build|scenes|test|clang
set -eu

packages="gcc g++ cmake ninja-build pkg-config libembree-dev libopenimageio-dev libopencolorio-dev libjansson-dev libgmp-dev libpng-dev zlib1g-dev libmeshoptimizer-dev libdraco-dev libzstd-dev"
case ${1:-build} in
build) more="" ;;
scenes) more="python3-numpy python3-pil" ;;
*) more="python3-numpy python3-pil libcmocka-dev git clang-format python3-matplotlib libopenmpi-dev openmpi-bin" ;;
esac
[ "${1:-build}" != clang ] || more="$more clang clang-tidy cppcheck libclang-rt-dev llvm"
packages="$packages $more"

stop() {
    echo "fathom set-up: $*" >&2
    exit 1
}

missing=""
command -v dpkg-query >/dev/null || stop "this is no Debian: install the likes of $packages by hand, then build with CMake"
for package in $packages; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

root=""
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || stop "these packages are missing:$missing; install them as root, or install sudo"
    root=sudo
fi
echo "Installing from the distribution:$missing"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! $root apt-get update >"$log" 2>&1; then
    tail -n 5 "$log" >&2
    stop "apt-get update failed: is there a network, and a Debian mirror in /etc/apt/sources.list?"
fi
# shellcheck disable=SC2086 # the list is words
if ! $root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $missing >"$log" 2>&1; then
    tail -n 5 "$log" >&2
    stop "could not be installed:$missing"
fi
