# fathom bench growth and bench/growth.sh at small size; no time is judged.
. "$SOURCE/tests/cli/check.inc"
run 0 help bench growth
awk 'length($0) > 80 { exit 1 }' out.txt || die 'the help of bench growth is wider than 80 columns'
refused 2 '--triangles N,N is missing' bench growth
refused 2 '--triangles: expected a whole number from 1 to' bench growth --triangles 1G
refused 3 'none.json' bench growth --triangles 1k --with none.json
echo '{' >bad.json
refused 3 'bad.json:' bench growth --with bad.json
echo '{ "bench": "trace", "runs": [] }' >bad.json
refused 3 'bad.json: expected what bench growth --json wrote' bench growth --with bad.json
echo '{ "runs": [] }' >bad.json
refused 3 'bad.json: expected what bench growth --json wrote' bench growth --with bad.json
refused 2 'same file' bench growth --triangles 1k --json a.txt --csv a.txt
code=0
TMPDIR=$PWD/nowhere "$FATHOM" bench growth --triangles 1k >out.txt 2>err.txt || code=$?
[ $code -eq 4 ] || die "no folder for files: exit code $code"
said err.txt 'expected a folder for temporary files in $TMPDIR'

# Sizes in any order, in two runs; one of them anew.
mkdir tmp
export TMPDIR=$PWD/tmp
run 0 bench growth --triangles 3k,1k --size 64x48 --repeats 2 --json g.json
said out.txt 'render over bare'
run 0 bench growth --triangles 2k,3k --with g.json --size 64x48 --repeats 2 --json all.json --csv all.csv --report growth
rmdir tmp || die 'files are left'
[ "$(sed -n 's/^ *"triangles": \([0-9]*\),$/\1/p' all.json | tr '\n' ' ')" = '980 2000 2880 ' ] || die 'sizes'
for key in fileBytes bvhBytes bvhPeakBytes readSeconds buildSeconds cpu wall rays renderCpuSeconds bareCpuSeconds \
    renderToBare millionRaysPerCpuSecond fits read build exponent half scale sizes all; do
    said all.json "\"$key\": "
done
[ "$(grep -c '"sizes": 3' all.json)" -eq 5 ] || die 'five fits of three sizes'
[ "$(grep -c '"heavy": null' all.json)" -eq 5 ] || die 'no heavy sizes'
[ "$(grep -vc '^#' all.csv)" -eq 4 ] || die 'a header and three rows'
awk -F, '!/^#/ { if (n++ && NF != columns) exit 1; columns = NF }' all.csv || die 'rows of different length'
for plot in 'Reading and building' 'One sample a pixel, by one thread' 'The render phase over the bare calls'; do
    said growth/index.html ">$plot<"
done
not_said growth/index.html '<script'
run 0 bench growth --with all.json --quiet --json again.json
runs() { sed -n '/"runs"/,/"fits"/p' "$1"; }
[ "$(runs all.json)" = "$(runs again.json)" ] || die 'nothing is measured, and it is not the same'

# The script: sizes over two runs, and more instanced triangles than 32 bits count.
mkdir tmp
SIZES='1k 2k' REPEATS=1 BILLIONS=430k OPTIONS='--size 64x36 --spp 1' sh "$SOURCE/bench/growth.sh" plots >out.txt ||
    die 'bench/growth.sh'
rmdir tmp || die 'files are left'
[ "$(grep -vc '^#' plots/growth.csv)" -eq 3 ] || die 'a header and two rows'
said plots/index.html 'Reading and building'
each=$(sed -n 's/^triangles \([0-9]*\) in 1 mesh; .*/\1/p' out.txt)
placed=$(sed -n 's/^triangles .*; \([0-9]*\) with instances$/\1/p' out.txt)
[ "$placed" -gt 4294967296 ] && [ "$placed" -eq $((each * 10000)) ] || die "info: $placed placed, $each each"
said out.txt "; 10000 instances, $placed triangles with them"
