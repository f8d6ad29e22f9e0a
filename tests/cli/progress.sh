# Progress: plain lines when stderr is no terminal, a bar on one, nothing when quiet or when it is over at once.
. "$SOURCE/tests/cli/check.inc"
write_scene

# Too short to wait for: nothing.
run 0 render scene.json -o a.exr
silent err.txt

# Long enough, by linear search over some thousand triangles: samples until it takes more than two seconds.
run 0 generate sphere -t 2k -o slow.glb
spp=8
while :; do
    run 0 render slow.glb --integrator classic -o a.exr --size 160x120 --tracer reference --threads 1 --pattern sobol --spp $spp --stats s.json
    seconds=$(number s.json render)
    awk "BEGIN { exit !($seconds > 2) }" && break
    spp=$(awk "BEGIN { n = 2.6 * $spp / ($seconds + 1e-3); print int(n < 2 * $spp ? 2 * $spp : n) }")
done
grep -qE '^fathom: render [0-9]+ %, [0-9.]+ [kM]rays/s, [0-9]+:[0-9][0-9] left$' err.txt || die 'no percent lines'
grep -vqE '^fathom: (render|build) [0-9]+ %(, .*)?$' err.txt && die 'something else on stderr'
[ "$(wc -l <err.txt)" -le 10 ] || die 'more than a line each 10 %'
sed -n 's/^fathom: render \([0-9]*\) %.*/\1/p' err.txt >percents.txt
sort -n -c percents.txt || die 'percents go back'
[ "$(awk '{ print int($1 / 10) }' percents.txt | uniq -d | wc -l)" -eq 0 ] || die 'two lines for the same 10 %'
grep -q "$(printf '[\r\033]')" err.txt && die 'terminal codes in a file'

run 0 render slow.glb --integrator classic -o a.exr --size 160x120 --tracer reference --threads 1 --pattern sobol --spp $spp --quiet
silent err.txt
silent out.txt

# A terminal: script(1) makes one.
command -v script >/dev/null || { echo 'script is not installed: the bar is not tried'; exit 0; }
TERM=xterm
export TERM
bar() {
    script -qec "stty cols $1; '$FATHOM' render slow.glb --integrator classic -o a.exr --size 160x120 --tracer reference --threads 1 --pattern sobol \
        --spp $((spp / 3 + 1)) $2" \
        /dev/null </dev/null >tty.txt
    tr '\r' '\n' <tty.txt | sed "s/$(printf '\033')\\[K//g" >lines.txt
}
# The machine may have become faster meanwhile: a run too short for a bar is made longer, six times at most.
has_bar() { grep -qE '^render +[0-9]+% \[=*>? *\] [0-9.]+ [kM]rays/s, [0-9]+:[0-9][0-9] left$' lines.txt; }
bar 100 ''
for longer in 1 2 3 4 5 6; do
    has_bar && break
    spp=$((spp + spp))
    bar 100 ''
done
has_bar || die 'no bar'
grep -q '^render 100% ' lines.txt || die 'the bar does not end at 100 %'
# Each drawing clears the rest of its line, and the last one is taken away before the result.
grep -q "$(printf '\r\033\\[K')a.exr: 160x120" tty.txt || die 'the bar stays beside the result'
for columns in 40 20 7; do
    bar $columns ''
    awk -v most=$((columns - 1)) '/^(render|build|read|write)/ && length($0) > most { exit 1 }' lines.txt ||
        die "the bar is wider than $columns columns"
    grep -q '^render' lines.txt || die "no bar at $columns columns"
done
bar 100 --quiet
silent tty.txt
TERM=dumb
bar 100 ''
grep -q "$(printf '\033')" tty.txt && die 'escape codes on a dumb terminal'
exit 0
