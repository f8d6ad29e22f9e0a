# Some scenes of tests/random_same.py: units, brightness, threads and files change no bit.
. "$SOURCE/tests/cli/check.inc"
python3 -B "$SOURCE/tests/random_same.py" "$FATHOM" 4 1 . >out.txt || die 'images differ'
said out.txt '0 of 4 scenes have images that differ'
