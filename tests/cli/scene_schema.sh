# The published schema accepts every scene in scenes/, and judges tests/json/cases.json as the reader does.
if ! python3 -c 'import jsonschema' 2>/dev/null; then
    echo 'skipped: python3-jsonschema is not installed'
    exit 0
fi
find "$SOURCE/scenes" -name '*.json' ! -name fathom.schema.json | sort >scenes.txt
xargs -d '\n' python3 "$SOURCE/tests/json/judge.py" "$SOURCE/scenes/fathom.schema.json" \
    "$SOURCE/tests/json/cases.json" <scenes.txt
