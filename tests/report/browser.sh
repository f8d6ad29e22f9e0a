# The report's page in headless Chromium: no message on the console, as many marks as the data has numbers, no text
# on another, nothing wider than the window. $MAKE_PAGE writes a page, $FATHOM is the program, $SOURCE the checkout.
. "$SOURCE/tests/cli/check.inc"
here=$SOURCE/tests/report
command -v chromium >/dev/null || die 'chromium is missing: sh tests/packages.sh test installs it'

# browse FILE SIZE: opens the page; its document is in dom.html then, what it said to the console in console.txt.
# A new profile each time, and no sandbox: Chromium has none to offer to root, as whom containers run tests.
browse() {
    profile=$(mktemp -d "$PWD/profile.XXXXXX")
    timeout -s KILL 120 chromium --headless --no-sandbox --disable-gpu --disable-quic --no-first-run \
        --disable-background-networking --disable-component-update --disable-sync --disable-dev-shm-usage \
        --user-data-dir="$profile" --window-size="$2" --enable-logging=stderr --v=0 --dump-dom "file://$PWD/$1" \
        >dom.html 2>log.txt || { tail -n 5 log.txt >&2; die "chromium could not open $1"; }
    rm -rf "$profile"
    grep CONSOLE log.txt >console.txt || true
    grep -q '</html>' dom.html || die "$1: no document"
}

# opens FILE: without a word on the console, wide and narrow; and what probe.js looks at is fine. The probe needs
# leave to run, which the page itself gives no script.
opens() {
    for size in 1280,900 500,900; do
        browse "$1" $size
        [ ! -s console.txt ] || { cat console.txt >&2; die "$1: messages on the console"; }
        sed '/Content-Security-Policy/d; s/^<\/body>$//; s/^<\/html>$//' "$1" >probed.html
        { echo '<script>'; cat "$here/probe.js"; echo '</script></body></html>'; } >>probed.html
        browse probed.html $size
        grep -q '<html[^>]* data-probe="ok"' dom.html ||
            die "$1 at $size: $(sed -n 's/^<html[^>]* data-probe="\([^"]*\)".*/\1/p' dom.html | head -c 2000)"
    done
}

in_page() { grep -o -e "$1" dom.html | wc -l; }
in_data() { grep -c -e "$1" "$here/full.json"; }
equal() { [ "$1" -gt 0 ] && [ "$1" -eq "$2" ] || die "$3: $1 in the page, $2 in the data"; }

# A page with everything, with names that look like markup. One item a line in the data.
"$MAKE_PAGE" "$here/full.json" full
opens full/index.html
tracers=$(sed -n 's/.*"spec": \("[^"]*"\), "tracer".*/\1/p' "$here/full.json" | sort -u | wc -l)
equal "$(in_page '<g class="mark"><title>[^<]*ns a ray')" $((2 * tracers)) 'points, in two plots'
equal "$(in_page '[0-9] rays; median')" "$((2 * tracers))" 'histograms, each with a summary and a caption'
[ "$(in_page 'class="mark bar"')" -gt $((10 * tracers)) ] || die 'histograms have hardly a bar'
equal "$(in_page '</title><rect class="h[0-9]')" "$(in_data '"parameter".*"spec"')" 'cells of heat maps'
equal "$(in_page 'class="mark \(fine\|over\)"')" $(($(in_data '"bound"') + 2)) 'bars of two groups and of the shading cases'
equal "$(in_page '<img ')" "$(in_data '"png"')" images
! grep -q '<script>alert' dom.html || die 'a scene name has become markup'

# Tracers a hundred times as slow: the axis ends at 100×10³, a wide tick at the very edge.
sed 's/"nsPerRay": \(4000\|4800\.0\),/"nsPerRay": 960,/; s/"nsPerRay": \([0-9]*\)[.0-9]*,/"nsPerRay": \100,/' \
    "$here/full.json" >slow.json
"$MAKE_PAGE" slow.json slow
opens slow/index.html

# Results without times, histograms and extremes: the page says what is not there.
"$MAKE_PAGE" "$here/early.json" early
opens early/index.html
[ "$(in_page 'class="absent"')" -ge 5 ] || die 'what is left out is not said'

# What the program itself writes.
run 0 validate --rays 100 --families camera,vertex --report real
opens real/index.html
run 0 bench error "$SOURCE/scenes/tour/26-antialiasing.json" --size 48x32 --max-spp 16 --seeds 2 --report error
opens error/index.html
[ "$(in_page 'samples a pixel: ')" -eq 27 ] || die 'not every pattern and spp is in all three plots'

run 0 bench trace --triangles 500,2k --rays 300 --repeats 2 --seconds 0.001 --quiet --report rates
opens rates/index.html
write_scene
run 0 bench render scene.json --repeats 2 --quiet --report ceiling
opens ceiling/index.html

TMPDIR=$PWD run 0 bench growth --triangles 1k,10k --size 64x48 --repeats 2 --quiet --report sizes
opens sizes/index.html
equal "$(in_page 'triangles: [0-9]')" 10 'points: reading, building, two of rendering, their ratio, of two sizes each'

# This test can fail: a page that asks for something from outside, and one whose labels lie on each other.
sed 's|<main>|<main><img alt="" src="http://localhost:9/x.png">|' early/index.html >asking.html
browse asking.html 1280,900
[ -s console.txt ] || die 'a page that asks for something from outside went unnoticed'
sed '/Content-Security-Policy/d; s/<text class="label" x="[0-9.]*" y="[0-9.]*"/<text class="label" x="200" y="90"/
    s/^<\/body>$//; s/^<\/html>$//' full/index.html >overlapping.html
{ echo '<script>'; cat "$here/probe.js"; echo '</script></body></html>'; } >>overlapping.html
browse overlapping.html 1280,900
grep -q 'data-probe="[^"]*overlap: ' dom.html || die 'labels on each other went unnoticed'
