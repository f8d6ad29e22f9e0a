# Some scenes of tests/light_random.py: path tracing agrees with the reference.
. "$SOURCE/tests/cli/check.inc"
python3 -B "$SOURCE/tests/light_random.py" "$FATHOM" 20 1 0.01 . >out.txt || die 'path tracing differs from the reference'
said out.txt '0 of 20 scenes differ; 0 were refused'
