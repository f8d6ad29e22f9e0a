# Sourced by the scripts beside it, from the top of the checkout: installs what is missing, builds in release mode and
# sets $fathom, the program, and $out, the folder for images. $FATHOM_BUILD and $FATHOM_OUT put both elsewhere.
build=${FATHOM_BUILD:-$PWD/build}/release
out=${FATHOM_OUT:-$PWD/out}
fathom=$build/bin/fathom

sh tests/packages.sh build
mkdir -p "$build" "$out"
echo "Building Fathom in $build (once; a minute or two)"
log=$build/build.log
if ! cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DFATHOM_TESTS=OFF >"$log" 2>&1 ||
    ! cmake --build "$build" -j "$(nproc)" >>"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "fathom: the build failed; the whole log is $log" >&2
    exit 1
fi
