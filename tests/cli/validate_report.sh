# fathom validate --report DIR: one page, of the figures that --json holds; nothing of others is written over.
. "$SOURCE/tests/cli/check.inc"
write_scene

run 0 validate scene.json --rays 100 --families camera,edge --tracer embree --tracer linear:f64 --report page --json all.json
[ "$(ls -A page | tr '\n' ' ')" = 'index.html results.json ' ] || die 'expected the page and its results'
cmp -s page/results.json all.json || die 'the page and --json have other results'
said page/index.html 'Nothing wrong in 400 rays'
said page/index.html '<code>linear:f64</code>'
said page/index.html '<th scope="row">scene.json</th>'
not_said page/index.html '<script'
# Again into the same folder: the page is ours.
run 0 validate scene.json --rays 50 --families camera --report page/
said page/index.html 'Nothing wrong in 100 rays'

# Failing rays stand on the page as --replay takes them, whatever the scene is called: those of a tracer with a
# deliberate bug.
name='<b> & "one".obj'
printf 'v -1 -1 0\nv 1 -1 0\nv 0 1 0.5\nf 1 2 3\n' >"$name"
culls=$BUILD/tests/plugin/culls.so
run 1 validate "$name" --rays 300 --families uniform --tracer "$culls" --report bad
grep -q '[1-9][0-9]* answers wrong in 300 rays' bad/index.html || die 'wrong answers are not counted'
not_said bad/index.html '<b>'
sed -n 's/^\(<pre>\)*\(.*culls.so uniform .* wrong .*\)$/\2/p' bad/index.html |
    sed 's/&lt;/</g; s/&gt;/>/g; s/&quot;/"/g; s/&amp;/\&/g' >bad.txt
count=$(wc -l <bad.txt)
[ "$count" -gt 0 ] || die 'no failing ray on the page'
run 1 validate --replay bad.txt --tracer "$culls"
said out.txt "$count rays, $count wrong"

# Refused before anything is traced.
mkdir other
echo 'a diary' >other/index.html
refused 4 'other/index.html: is there already and is no report of fathom' validate scene.json --report other
refused 4 'scene.json: is a file; expected a folder' validate scene.json --report scene.json
refused 4 'its folder does not exist' validate scene.json --report no/such
refused 2 'same file' validate scene.json --report page --json page/index.html
[ "$(cat other/index.html)" = 'a diary' ] || die 'the diary is gone'
"$FATHOM" help validate | grep -q -e '--report DIR' || die 'no help'
