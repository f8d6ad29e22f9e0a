# A file that is truncated or changed while it is rendered. The library $plugin strikes it at the moment that
# $TRUNCATE_WHEN names, in the way of $TRUNCATE_HOW. The pixels of a file that has changed are no image: the
# program says so, ends with code 3, and saves them next to it.
. "$SOURCE/tests/cli/check.inc"
plugin=$BUILD/tests/plugin/truncates.so
export TRUNCATE TRUNCATE_WHEN TRUNCATE_HOW=cut

# Four tiles of 32 calls each. At the hundredth call two threads have finished one, so that there is something
# to save.
render_tiles() {
    run "$@" --integrator classic --size 64x64 --spp 4 --threads 2 --quiet --tracer "$plugin"
}

# rescued TEXT: the last render failed with the text, said where its pixels are, and left nothing else.
rescued() {
    silent out.txt
    [ "$(wc -l <err.txt)" -eq 2 ] || die 'expected two lines on stderr'
    said err.txt "$1"
    said err.txt 'fathom: the pixels rendered so far, some of which may be wrong, are in a.rescue.exr, as scene-linear'
    [ ! -e a.exr ] && [ ! -e b.png ] && [ ! -e a.json ] || die 'an image of a file that is another now'
}

for extension in ply glb; do
    TRUNCATE_WHEN=build TRUNCATE=ball.$extension
    run 0 generate sphere --triangles 2k -o ball.$extension
    refused 3 "fathom: ball.$extension: was truncated while it was read: 0 bytes are left of " \
        render ball.$extension -o a.exr -o b.png --integrator classic --size 16x16 --tracer "$plugin" --stats a.json
    TRUNCATE_WHEN=late
    run 0 generate sphere --triangles 2k -o ball.$extension
    render_tiles 3 render ball.$extension -o a.exr -o b.png --stats a.json
    rescued "fathom: ball.$extension: was truncated while it was read: 0 bytes are left of "
    rm a.rescue.exr
    TRUNCATE_WHEN=trace
    # The answers that the truncated scene gave are no verdict either.
    run 0 generate sphere --triangles 100 -o ball.$extension
    refused 3 "fathom: ball.$extension: was truncated while it was read" \
        validate ball.$extension --tracer "$plugin" --rays 10 --sample 0 --json a.json
    run 0 generate sphere --triangles 100 -o ball.$extension
    run 3 bench render ball.$extension --tracer "$plugin" --size 16x16 --spp 1 --repeats 1 --json a.json
    said err.txt "fathom: ball.$extension: was truncated while it was read"
    [ ! -e a.json ] || die 'results of a truncated scene'

    run 0 generate sphere --triangles 100 -o ball.$extension
    TRUNCATE_WHEN=never
    render_tiles 0 render ball.$extension -o good.exr --exr-float
    TRUNCATE_WHEN=late
    # Another byte somewhere: nobody knows which pixels it is in.
    TRUNCATE_HOW=write
    render_tiles 3 render ball.$extension -o a.exr
    rescued "fathom: ball.$extension: was changed while it was read; try again when nothing writes to it"
    run 0 compare a.rescue.exr good.exr --tolerance 1
    rm a.rescue.exr
    TRUNCATE_HOW=cut
done
