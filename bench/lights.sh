#!/bin/sh
# A bare floor, and one with balls, under one small light, under ten, and under 99,990 more that lie far away and hardly
# matter: the processor time and the relative error of each, and the cost, which is the time times the squared error, over
# that of the fewer lights.
# usage: BUILD=build/release sh bench/lights.sh [SPP [LIGHTS]]     (default 64, 100000)
set -eu
cd "$(dirname "$0")/.."
fathom=$(cd "${BUILD:-build/release}" && pwd)/bin/fathom
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
exec /usr/bin/python3 -B bench/lights.py "$fathom" "${1:-64}" "${2:-100000}" "$folder"
