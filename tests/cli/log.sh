# --log json: whatever is said on stderr is one JSON object a line, from every command.
# shellcheck disable=SC2086 # options are words
. "$SOURCE/tests/cli/check.inc"
write_scene

# Each line of err.txt is an object with a time, a level and a message; where python is at hand it is JSON for others.
lines_are_objects() {
    [ -s err.txt ] || die 'nothing on stderr'
    grep -vE '^\{"time": [0-9]+\.[0-9]{3}, "level": "(info|warning|error)", "message": ".*\}$' err.txt && die 'no object'
    python3 -c 'import json, sys; [json.loads(line) for line in sys.stdin]' <err.txt || die 'not JSON'
}
fails() { # code, text, arguments
    wanted=$1
    text=$2
    shift 2
    expect "$wanted" "$FATHOM" "$@"
    lines_are_objects
    said err.txt "$text"
}

fails 2 '"level": "error", "message": "expected a command; see fathom help"' --log json
fails 2 'unknown option --zebra; see fathom help render"}' render a.json --zebra --log json
fails 2 'SCENE is missing' render --log=json
fails 3 'no\"quote\\.json: No such file' render 'no"quote\.json' -o a.png --log json
fails 3 'no??ä.json: No such file' info "$(printf 'no\033\377ä.json')" --log json
for command in compare generate validate 'bench trace' 'bench render'; do
    fails 2 'unknown option --zebra' $command --log json --zebra
done
refused 2 '--log: expected text or json, found "xml"' render scene.json -o a.png --log xml
refused 2 '--log: expected text or json, found nothing' render scene.json -o a.png --log

# Progress: the beginning of each phase at least, with its numbers; nothing but errors and warnings when quiet.
run_log() {
    "$FATHOM" "$@" >out.txt 2>err.txt || die "fathom $*: exit code $?"
}
run_log render scene.json -o a.png --log json
lines_are_objects
for phase in read build render write; do said err.txt "\"phase\": \"$phase\", \"fraction\": "; done
said out.txt 'a.png: 96x64'
run_log render scene.json -o a.png --log json --quiet
silent err.txt

# Every bench tells how far it is, up to the end.
for bench in 'trace scene.json --rays 64 --tracer bvh' 'render scene.json --spp 1' \
    'error scene.json --max-spp 1'; do
    repeats='--repeats 1'
    case $bench in error*) repeats='--seeds 1' ;; esac
    run_log bench $bench $repeats --log json
    lines_are_objects
    said err.txt '"phase": "measure", "fraction": 1.0000'
    run_log bench $bench $repeats --log json --quiet
    silent err.txt
done

# Warnings.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 2\n' >mesh.obj
run_log render mesh.obj --integrator classic -o a.png --size 8x8 --log json --quiet
lines_are_objects
said err.txt '"level": "warning", "message": "'
run_log render mesh.obj --integrator classic -o a.png --size 8x8 --log text --quiet
said err.txt 'fathom: warning: '
