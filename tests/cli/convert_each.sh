# Some scenes of tests/convert_each.py: what a format cannot hold is told.
. "$SOURCE/tests/cli/check.inc"
python3 -B "$SOURCE/tests/convert_each.py" "$FATHOM" 20 3 >out.txt || die 'something is lost silently'
said out.txt 'files differ silently or are refused'
