#!/bin/sh
# A floor under ten small lights, alone and with 99,990 more that lie far away and hardly matter: the relative error and
# the processor time of each, and the product of time and squared error over that of the ten alone.
# usage: BUILD=build/release sh bench/lights.sh [SPP [LIGHTS]]     (default 64, 100000)
set -eu
cd "$(dirname "$0")/.."
fathom=$(cd "${BUILD:-build/release}" && pwd)/bin/fathom
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
exec python3 -B bench/lights.py "$fathom" "${1:-64}" "${2:-100000}" "$folder"
