# Help, versions, and everything that is wrong on the command line.
# shellcheck disable=SC2086 # options are words
. "$SOURCE/tests/cli/check.inc"

run 2
silent out.txt
said err.txt 'Usage: fathom COMMAND'
run 0 --version
grep -qE '^fathom [0-9]+\.[0-9]+\.[0-9]+$' out.txt || die 'the version'
cp out.txt version.txt
run 0 -V
cmp -s out.txt version.txt || die 'fathom -V is not fathom --version'
rm version.txt
for letter in -v --verbose; do
    run 0 --version $letter
    for line in '^fathom [0-9]' '^commit ' '^compiler .*(gcc|[cC]lang)' '^tracer +Embree [34]\.[0-9.]+, [A-Z]' '^shading ' \
        '^images +OpenImageIO [0-9.]+, OpenColorIO [0-9]' '^libraries libpng [0-9].*jansson [0-9].*GMP [0-9]' \
        '^processor .* [0-9]+ threads'; do
        grep -qE "$line" out.txt || die "--version $letter: no line $line"
    done
done
# Farms compare it, and equalise it by $FATHOM_ISA.
[ "$(uname -m)" != x86_64 ] || FATHOM_ISA=sse2 "$FATHOM" --version -v | grep -q '^tracer .*, SSE' ||
    die "--version -v does not know \$FATHOM_ISA"
refused 2 '--version: expected nothing after it, found "foo"' --version foo
refused 2 '-V: expected nothing after it, found "foo"' -V -v foo
run 0 -h render
said out.txt 'Usage: fathom render'
for arguments in --help -h help 'help help'; do
    run 0 $arguments
    said out.txt 'Usage: fathom'
    silent err.txt
done
for command in render merge info generate convert texture compare validate bench help; do
    run 0 help
    said out.txt "  $command "
    run 0 help $command
    said out.txt "Usage: fathom $command"
    cp out.txt help.txt
    run 0 $command --help
    cmp -s out.txt help.txt || die "fathom $command --help is not fathom help $command"
    said out.txt '-h, --help '
    for arguments in '-h' 'nothing -h' '--zebra --spp -h' '-h --zebra'; do
        [ $command != help ] || continue
        run 0 $command $arguments
        cmp -s out.txt help.txt || die "fathom $command $arguments is not fathom help $command"
    done
    run 0 help $command -h
    cmp -s out.txt help.txt || die "fathom help $command -h is not fathom help $command"
    awk 'length($0) > 80 { exit 1 }' out.txt || die "the help of $command is wider than 80 columns"
done
for what in trace render error; do
    run 0 help bench $what
    cp out.txt help.txt
    run 0 bench $what nothing -h
    cmp -s out.txt help.txt || die "fathom bench $what -h is not fathom help bench $what"
done
# Every option is in the help.
run 0 help render
for option in --output --size --spp --pattern --crop --threads --seed --max-depth --min-weight --epsilon --no-terminator-fix --no-photons \
    --leave-out-below --tracer --aov --exposure --view --display --ocio --exr-float --background --block-width --tile-size --quiet \
    --verbose --stats --part --split; do
    said out.txt " $option"
done
# It names the words that the command line takes for 0.
tr -s ' \n' ' ' <out.txt >help.txt
for text in 'off: every pixel gets --spp samples' 'auto: 4. (auto)' 'auto: the offset follows from error bounds'; do
    said help.txt "$text"
done
# The help of merge, which shares options, names none that merge lacks.
run 0 help merge
not_said out.txt '--frames'
not_said out.txt textures
rm -f help.txt

refused 2 'unknown command "rendr"; did you mean "render"?; see fathom help' rendr
refused 2 'unknown command "xyzzy"; see fathom help' xyzzy
refused 2 'unknown command "a.glb"; fathom render FILE -o IMAGE renders a file; see fathom help' a.glb
refused 2 'expected a command before "--spp"' --spp 4
refused 2 'unknown command "nothing"' help nothing
refused 2 'at most one command' help render info

refused 2 'SCENE is missing; see fathom help render' render
refused 2 '-o IMAGE is missing; see fathom help render' render scene.json
refused 2 'unexpected argument "b.json"; the file to write follows -o; see' render a.json b.json -o a.png
refused 2 'unknown option --szie; did you mean --size?; see fathom help render' render a.json -o a.png --szie 3x3
refused 2 '--quiet and --verbose exclude each other' render a.json -o a.png -q -v

# option, wrong value, what is said; unit/args.c has more forms
while IFS='|' read -r option value text; do
    refused 2 "$option: $text" render a.json -o a.png "$option=$value"
    said err.txt "found \"$value\""
    said err.txt '; see fathom help render'
done <<'TABLE'
--size|1280|expected WIDTHxHEIGHT, each from 1 to 65536
--size|10x70000|expected WIDTHxHEIGHT
--spp|0|expected a whole number from 1 to 65536
--spp|65537|expected a whole number from 1 to 65536
--crop|1,2,3|expected X0,Y0,X1,Y1
--crop|1,2,3,4,5|expected X0,Y0,X1,Y1
--crop|5,0,5,9|expected X0 < X1 and Y0 < Y1
--crop|0,9,5,9|expected X0 < X1 and Y0 < Y1
--crop|0,0,65537,9|expected X0,Y0,X1,Y1
--crop|-1,0,5,9|expected X0,Y0,X1,Y1
--threads|0|expected a whole number from 1 to 1024
--max-depth|1025|expected a whole number from 0 to 1024
--epsilon|0|expected auto or a number above 0
--block-width|2|expected 1|4|8|16
--tile-size|48|expected a whole number from 32 to 65536, a multiple of 32
--tile-size|0|expected a whole number from 32 to 65536
--pattern|random|expected grid|stratified|sobol
--tracer|bvh:f16|tracers of this kind have no option "f16"; expected f32, f64, f128
--tracer|embree:compact:robust|options "compact" and "robust" exclude each other
--exposure|1e3|expected a number from -64 to 64
--background|1,2|expected R,G,B
--background|1,2,1e300|expected R,G,B
--max-time|0|expected off or a number above 0
--min-weight|1|expected a number from 0 to less than 1
--memory-limit|9|expected auto or a whole number from 1000000 to
--seed|18446744073709551616|expected a whole number from 0 to 2^64 - 1
--background|1,2,-3|expected R,G,B
--aov|normals|expected names from alpha,Z,N,P,albedo,id
TABLE
refused 2 '--tracer: no tracer is called "emb"; expected reference, a shared library FILE.so, linear (' render a.json -o a.png --tracer emb
not_said err.txt found
refused 2 '--aov: expected names' render a.json -o a.exr --aov Z,,N
refused 2 '--aov: expected names from alpha,Z,N,P,albedo,id,samples,error,direct,indirect,emission,lightGroups,cryptoObject,cryptoMaterial,motion, or all, or none, found "'"$(printf '%060d' 0)\"" \
    render a.json -o a.exr --aov "$(printf '%070d' 0)"
refused 2 '--ocio: expected FILE, found nothing' render a.json -o a.png --ocio=

refused 2 '--aov: only .exr holds these channels' render a.json -o a.png --aov Z
refused 2 '--aov: .jpg holds no alpha; expected one more -o FILE.png' render a.json -o a.jpg --aov alpha
refused 2 '--aov: only .exr holds these channels' render a.json -o a.jpg --aov alpha,Z

refused 2 'SCENE is missing' info
refused 2 'unknown option --jsn; did you mean --json?; see fathom help info' info a.json --jsn
refused 2 'KIND is missing' generate
refused 2 'expected sphere, terrain, sponge or forest, found "spere"; did you mean sphere?' generate spere -t 9 -o a.glb
refused 2 'IMAGE is missing' texture
refused 2 '-o FILE is missing' texture a.png
refused 2 'ends in .tx, .tif or .tiff' texture "$SOURCE/tests/cli/usage.sh" -o a.png
refused 2 '--texture-memory: expected a whole number from 1000000' render a.glb -o a.png --texture-memory 9
refused 2 '--triangles N is missing' generate sphere -o a.glb
refused 2 '-o FILE is missing' generate sphere --triangles 100
refused 2 'ends in .glb, .ply or .obj, found "a.stl"' generate sphere --triangles 100 -o a.stl
refused 2 '--triangles: expected a whole number from 1 to' generate sphere --triangles 0 -o a.glb
refused 2 'B is missing; see fathom help compare' compare a.exr
refused 2 '--tolerance: expected a number from 0' compare a.exr b.exr --tolerance -1

# A result that cannot be delivered is a failure.
if [ -w /dev/full ]; then
    code=0
    "$FATHOM" help >/dev/full 2>err.txt || code=$?
    [ $code -eq 4 ] || die "help to a full disk: exit code $code, expected 4"
    said err.txt 'standard output cannot be written'
fi
