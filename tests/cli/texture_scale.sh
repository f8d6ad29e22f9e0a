# Images on surfaces, their normals and grooves look the same in a scene of any size.
# shellcheck disable=SC2086 # options are words
. "$SOURCE/tests/cli/check.inc"
printf 'P6\n2 2\n255\n\377\200\100\100\200\377\200\200\377\300\100\340' >t.ppm
sized() { # factor, file
    /usr/bin/awk -v s="$1" 'function v(x, y, z) { return sprintf("[%.17g, %.17g, %.17g]", x * s, y * s, z * s) }
    BEGIN {
        image = "{\"file\": \"t.ppm\", \"scale\": [3, 3]}"
        print "{\"image\": {\"width\": 48, \"height\": 36}, \"background\": [0.3, 0.4, 0.5],"
        print "\"camera\": {\"eye\": " v(0, 1.5, 4) ", \"target\": " v(0, 0.5, 0) ", \"fovy\": 40},"
        print "\"materials\": {\"floor\": {\"model\": \"metallicRoughness\", \"baseColorTexture\": " image ", \"normalTexture\": " image "},"
        print "\"metal\": {\"model\": \"metallicRoughness\", \"metallic\": 1, \"roughness\": 0.3, \"anisotropy\": 0.8}},"
        print "\"objects\": [{\"type\": \"quad\", \"center\": [0, 0, 0], \"u\": " v(2, 0, 0) ", \"v\": " v(0, 0, -2) ", \"material\": \"floor\"},"
        print "{\"type\": \"sphere\", \"center\": " v(-0.7, 0.5, 0) ", \"radius\": " 0.5 * s ", \"material\": \"metal\"},"
        print "{\"type\": \"mesh\", \"positions\": [" v(0.3, 0, 0) ", " v(1.5, 0, 0.2) ", " v(1.5, 1, 0) "],"
        print "\"uvs\": [[0, 1], [1, 1], [1, 0]], \"indices\": [[0, 1, 2]], \"material\": \"floor\"}]}"
    }' >"$2"
}
options='--spp 4 --aov albedo,N'
sized 1 one.json
run 0 render one.json $options -o one.exr
for power in 31 51 -31 -50; do
    sized "$(awk "BEGIN { printf \"%.17g\", 2 ^ $power }")" other.json
    run 0 render other.json $options -o other.exr
    run 0 compare one.exr other.exr --tolerance 1e-3
    rm other.exr
done
rm one.exr
