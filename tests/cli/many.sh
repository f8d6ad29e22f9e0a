# A hundred thousand lights and spheres, more than 16 bits count: rendered, and by both tracers to the same bits.
. "$SOURCE/tests/cli/check.inc"

spheres() {
    awk 'BEGIN {
        srand(1)
        print "{ \"camera\": { \"eye\": [0, 0, 30], \"target\": [0, 0, 0], \"fovy\": 40 },"
        print "\"lights\": [ { \"type\": \"point\", \"position\": [0, 50, 50], \"intensity\": 5000 } ], \"objects\": ["
        for (i = 1; i <= 100000; ++i)
            printf "{\"type\":\"sphere\",\"center\":[%.4f,%.4f,%.4f],\"radius\":0.03}%s\n",
                20 * rand() - 10, 20 * rand() - 10, 20 * rand() - 10, i < 100000 ? "," : "] }"
    }'
}

lights() {
    awk 'BEGIN {
        srand(2)
        print "{ \"camera\": { \"eye\": [0, 3, 10], \"target\": [0, 0, 0], \"fovy\": 40 },"
        print "\"objects\": [ { \"type\": \"sphere\", \"center\": [0, 1, 0], \"radius\": 1 },"
        print "{ \"type\": \"quad\", \"center\": [0, 0, 0], \"u\": [5, 0, 0], \"v\": [0, 0, -5] } ], \"lights\": ["
        for (i = 1; i <= 100000; ++i)
            printf "{\"type\":\"point\",\"position\":[%.4f,%.4f,%.4f],\"intensity\":0.001}%s\n",
                10 * rand() - 5, 2 + 4 * rand(), 10 * rand() - 5, i < 100000 ? "," : "] }"
    }'
}

spheres >spheres.json
lights >lights.json
for scene in spheres:64x48 lights:8x6; do
    name=${scene%:*}
    for tracer in embree bvh; do
        run 0 render $name.json --integrator classic -o $name-$tracer.exr --exr-float --tracer $tracer --size ${scene#*:} --stats $tracer.json
    done
    same $name-embree.exr $name-bvh.exr
    # Something is to be seen: shadow rays were cast, to every light from where one was.
    [ "$(number embree.json shadow)" -gt 0 ] || die "$name: no light reached anything"
done
[ "$(number embree.json shadow)" -ge 1000000 ] || die "lights: too few shadow rays: $(number embree.json shadow)"
rm spheres.json lights.json
