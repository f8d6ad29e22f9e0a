# Installs, moves the installation elsewhere, and uses it as an outside project would: through CMake's
# find_package and through pkg-config. $SOURCE, $BUILD, $CC, $CMAKE, $SANITIZE come from CTest; the working
# directory is the test's own.
set -eu
rm -rf first moved outside-cmake outside outside.exr
mkdir first

fail() {
    echo "install: $*" >&2
    exit 1
}

"$CMAKE" --install "$BUILD" --prefix "$PWD/first" >install.log || { cat install.log; fail "cmake --install failed"; }
mv first moved
prefix=$PWD/moved
libdir=$(dirname "$(find "$prefix" -name 'libfathom.so' | head -n 1)")
[ -n "$libdir" ] || fail "libfathom.so was not installed"

for file in include/fathom/fathom.h bin/fathom share/fathom/fathom.schema.json; do
    [ -s "$prefix/$file" ] || fail "$file was not installed"
done
[ -s "$libdir/fathom/fathom_image.so" ] || fail "fathom_image.so was not installed"
[ -x "$libdir/fathom/fathom-image" ] || fail "fathom-image was not installed"
[ -s "$libdir/fathom/fathom_image.parts" ] || fail "fathom_image.parts was not installed"
for header in "$SOURCE"/include/fathom/*.h; do
    cmp -s "$header" "$prefix/include/fathom/${header##*/}" || fail "$header was not installed as it is"
done
# Nothing of the machine it was built on.
if grep -rIlF -e "$BUILD" -e "$SOURCE" "$prefix/include" "$libdir" "$prefix/share"; then
    fail "the files above name the build folder"
fi

"$prefix/bin/fathom" --version | grep -q '^fathom [0-9]' || fail "the program does not run"

flags=${SANITIZE:+-fsanitize=$SANITIZE}
# The generator that Fathom was configured with is there; make may not be.
generator=$(sed -n 's/^CMAKE_GENERATOR:INTERNAL=//p' "$BUILD/CMakeCache.txt")
"$CMAKE" -G "$generator" -S "$SOURCE/tests/install" -B outside-cmake -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_C_COMPILER="$CC" \
    -DCMAKE_C_FLAGS="$flags" >cmake.log 2>&1 || { cat cmake.log; fail "find_package failed"; }
"$CMAKE" --build outside-cmake >cmake.log 2>&1 || { cat cmake.log; fail "the CMake project does not build"; }
./outside-cmake/outside outside.exr >outside.log 2>&1 || { cat outside.log; fail "the CMake project does not run"; }
[ -s outside.exr ] || fail "the CMake project left no image"
rm outside.exr

PKG_CONFIG_PATH=$libdir/pkgconfig
export PKG_CONFIG_PATH
[ "$(pkg-config --modversion fathom)" = "$("$prefix/bin/fathom" --version | cut -d ' ' -f 2)" ] ||
    fail "fathom.pc has another version than the program"
# shellcheck disable=SC2046,SC2086
"$CC" -std=c11 $flags "$SOURCE/tests/example/render_arrays.c" $(pkg-config --cflags --libs fathom) -o outside ||
    fail "the pkg-config project does not build"
LD_LIBRARY_PATH=$libdir ./outside outside.exr >outside.log 2>&1 ||
    { cat outside.log; fail "the pkg-config project does not run"; }
[ -s outside.exr ] || fail "the pkg-config project left no image"

# A later or another major version is not taken for this one.
for wanted in 0.2 1.0; do
    sed "s/find_package(fathom 0.1/find_package(fathom $wanted/" "$SOURCE/tests/install/CMakeLists.txt" >later.txt
    mkdir -p later && mv later.txt later/CMakeLists.txt
    if "$CMAKE" -G "$generator" -S later -B later/build -DCMAKE_PREFIX_PATH="$prefix" >later.log 2>&1; then
        fail "version $wanted was found"
    fi
    grep -q "considered but not accepted" later.log || { cat later.log; fail "version $wanted: another error"; }
    rm -rf later
done
