# Every small scene renders with Embree and with the reference tracer, and the two images are equal to the last bit, in
# colour and in every further channel: where candidates tie, at edges that triangles share or where surfaces touch, both
# let the same arithmetic decide. Small images, since the reference tracer asks every primitive for every ray; smaller
# still where everything runs many times slower.
#
# One exception: on which side of an edge a ray passes is decided in float, by Embree with sums and by the reference
# intersector on corners that are off by some units of the distance; into an instance Embree also carries the ray with
# roundings of its own. Where an edge is closer than that they may differ, and nothing in Embree's answer tells
# (embree_settle.c). At 320x240 this happens to 5 of the 691,200 camera rays of 23-generated-meshes, which has by far the
# most edges, in 4 pixels: exact arithmetic sides with Embree in 3 and with the reference in 2. One shadow ray of
# 22-mesh-file differs, and none of any other scene. So 0.1 are expected of the 15,552 here, and two pixels (chance
# 0.006) would hardly be an accident: one may differ, and only where there are instances.
size=${FATHOM_SLOW:+24x18}
size=${size:-48x36}

render() { # scene, tracer
    "$FATHOM" render "$1" --quiet --size "$size" --aov all --exr-float --tracer "$2" --stats "$2.json" \
        -o "$(basename "$1" .json).$2.exr"
}

differing() { # name: how many pixels
    "$FATHOM" compare "$1.embree.exr" "$1.reference.exr" >"$1.txt" || true
    sed -n 's/.* \([0-9]*\) of [0-9]* pixels differ.*/\1/p' "$1.txt"
}

scenes=0
for scene in "$SOURCE"/scenes/example.json "$SOURCE"/scenes/tour/*.json; do
    name=$(basename "$scene" .json)
    render "$scene" embree &
    render "$scene" reference
    wait $!
    most=1
    grep -q '"instances": 0,' embree.json && most=0
    test "$(differing "$name")" -le "$most" ||
        { echo "$name: Embree and the reference tracer differ: $(cat "$name.txt")"; exit 1; }
    scenes=$((scenes + 1))
done
test "$scenes" -ge 20

# The judge can tell: two scenes that differ in nothing but the fix of the shadow terminator.
! "$FATHOM" compare 18-terminator-fix.embree.exr 19-terminator-fix-off.embree.exr >terminator.txt
grep -q '[1-9][0-9]* of [0-9]* pixels differ' terminator.txt
