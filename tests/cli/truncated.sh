# A file that is truncated while it is rendered: said, code 3, no image. The library $plugin cuts it at the moment that
# $TRUNCATE_WHEN names.
. "$SOURCE/tests/cli/check.inc"
plugin=$BUILD/tests/plugin/truncates.so
export TRUNCATE TRUNCATE_WHEN

for extension in ply glb; do
    for TRUNCATE_WHEN in build trace; do
        TRUNCATE=ball.$extension
        run 0 generate sphere --triangles 2k -o ball.$extension
        refused 3 "fathom: ball.$extension: was truncated while it was read: 0 bytes are left of " \
            render ball.$extension -o a.exr -o b.png --size 16x16 --tracer "$plugin" --stats a.json
    done
    # The answers that the truncated scene gave are no verdict either.
    run 0 generate sphere --triangles 100 -o ball.$extension
    refused 3 "fathom: ball.$extension: was truncated while it was read" \
        validate ball.$extension --tracer "$plugin" --rays 10 --sample 0 --json a.json
    run 0 generate sphere --triangles 100 -o ball.$extension
    run 3 bench render ball.$extension --tracer "$plugin" --size 16x16 --spp 1 --repeats 1 --json a.json
    said err.txt "fathom: ball.$extension: was truncated while it was read"
    [ ! -e a.json ] || die 'results of a truncated scene'
done
