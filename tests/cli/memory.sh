# --memory-limit: compact structures where only they fit, refusal before anything is built where not even they do.
. "$SOURCE/tests/cli/check.inc"
refused 2 'memory-limit: expected auto or a whole number from 1000000' render ball.glb --integrator classic -o none.exr --memory-limit 10
# Sanitizers hold memory of their own.
[ -z "$SANITIZE" ] || exit 0

run 0 generate sphere -t 1200k -o ball.glb
run 0 render ball.glb --integrator classic -o usual.exr --size 64x48 --memory-limit 8G
not_said err.txt warning

# The foreseen memory is never less than the peak, nor more by as much as the program's share.
foreseen() { # image, most that may be foreseen in vain, further arguments…
    image=$1 vain=$2
    shift 2
    run 0 render ball.glb --integrator classic -o "$image" --size 64x48 --stats m.json "$@"
    peak=$(number m.json peakBytes) all=$(number m.json foreseenBytes)
    [ "$peak" -le "$all" ] || die "$*: $peak bytes at most, $all were foreseen"
    [ "$((all - peak))" -le "$vain" ] || die "$*: only $peak bytes at most, $all were foreseen"
    [ "$(number m.json bvhBytes)" -le "$(number m.json bvhPeakBytes)" ] || die "$*: more is kept than there was at most"
}
for spec in embree:low embree:medium embree:compact:medium; do foreseen seen.exr 60000000 --tracer $spec; done
# Every thread has something under way.
foreseen seen.png 80000000 --threads 32 --size 1280x720 --spp 1
foreseen seen.exr 60000000
needed=$(($(number m.json meshBytes) + $(number m.json bvhBytes) + $(number m.json filmBytes)))
awk "BEGIN { d = $(number m.json peakToNeeded) * $needed / $(number m.json peakBytes) - 1; exit !(d < 1e-6 && d > -1e-6) }" ||
    die 'peakToNeeded'
run 0 render ball.glb --integrator classic -o seen.exr --size 64x48 -v
said out.txt 'times meshes 28.8, BVH '

# 20 MB of program, 2 of threads, 29 of mesh; the usual structures take 125 MB, compact ones 49.
run 0 render ball.glb --integrator classic -o compact.exr --size 64x48 --threads 2 --memory-limit 110M --stats s.json
said err.txt 'warning: the usual acceleration structure would take about 124.9 MB, and '
said err.txt ' MB are left after program, meshes and images: a compact'
[ "$(number s.json peakMemoryBytes)" -le 110000000 ] || die "beyond the limit: $(number s.json peakMemoryBytes)"
run 0 compare usual.exr compact.exr --tolerance 1e-3

refused 4 'out of memory: building takes about 49.2 MB, and' \
    render ball.glb --integrator classic -o none.exr --size 64x48 --threads 2 --memory-limit 60M --quiet

# Who names the structures gets them or nothing.
refused 4 'out of memory: building takes about 124.9 MB' \
    render ball.glb --integrator classic -o none.exr --size 64x48 --threads 2 --memory-limit 110M --tracer embree:medium --quiet
run 0 render ball.glb --integrator classic -o named.exr --size 64x48 --threads 2 --memory-limit 110M --tracer embree:compact
not_said err.txt warning

# Images count, and textures may take less: level 0 has 2048 x 2048 texels of 4 bytes, the smaller ones a third of 8 each.
{ printf 'P6\n2048 2048\n255\n' && head -c 12582912 /dev/zero; } >image.ppm
printf '{"materials": {"m": {"kdTexture": {"file": "image.ppm"}}}, "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m"}]}' >textured.json
refused 4 'building takes about 0.0 MB, and 0.0 MB are left after program, meshes and images, which take 50.0 MB; raise the limit, lower --texture-memory, render on' \
    render textured.json -o none.exr --size 64x48 --threads 2 --memory-limit 45M --quiet
run 0 render textured.json -o seen.exr --size 64x48 --threads 2 --memory-limit 45M --texture-memory 1M --stats s.json
[ "$(number s.json imageBytes)" -le 1000000 ] || die 'imageBytes beyond the limit'
run 0 render textured.json -o seen.exr --size 64x48 --threads 2 --memory-limit 80M --stats s.json
[ "$(number s.json imageBytes)" -ge $((2048 * 2048 * (4 + 2))) ] || die 'imageBytes'
# No ray meets the sphere, so no texel takes memory.
sed 's/^{/{"camera": {"eye": [0, 0, 5], "target": [0, 0, 9]}, "background": [1, 1, 1], /' textured.json >unseen.json
run 0 render unseen.json -o seen.exr --size 64x48 --stats s.json
[ "$(number s.json imageBytes)" -eq 0 ] || die 'imageBytes of an image that is not looked up'
rm seen.exr

run 0 render textured.json -o seen.exr --size 8x8 --spp 1 --tracer bvh --memory-limit 45M
said err.txt 'warning: the memory limit has no effect: only the tracer embree has one'
rm seen.exr

# Every limit, from what nothing fits to what all does, ends with code 4, a line and no file, or with the pixels that there
# are without one, in so much memory; and what fits one limit fits all that are higher.
run 0 generate sphere -t 150k -o ball.glb
run 0 render ball.glb --integrator classic -o usual.exr --size 64x48
run 0 render ball.glb --integrator classic -o usual.png --size 64x48
run 0 render ball.glb --integrator classic -o compact.exr --size 64x48 --tracer embree:compact
limits() { # image, what it is without a limit, limits, further arguments…
    image=$1 whole=$2 tried=$3 fits=no refused=no
    shift 3
    for limit in $tried; do
        code=0
        "$FATHOM" render ball.glb --integrator classic -o "$image" --size 64x48 --threads 2 --memory-limit $limit --stats l.json --quiet "$@" \
            >out.txt 2>err.txt || code=$?
        case $code in
        0)
            fits=yes
            [ "$(number l.json peakMemoryBytes)" -le "${limit%[MG]}$(echo "$limit" | sed 's/.*M/000000/; s/.*G/000000000/')" ] ||
                die "$image: $(number l.json peakMemoryBytes) bytes at most, allowed are $limit"
            now=$whole
            grep -q 'warning: the usual acceleration structure would take' err.txt && now=compact.exr
            case $now$image in
            compact.exr*.png) run 0 compare "$image" "$whole" --tolerance 0.01 ;;
            *) same "$image" "$now" ;;
            esac
            rm "$image" l.json
            ;;
        4)
            refused=yes
            [ $fits = no ] || die "$image: $limit is not enough, though less was"
            [ "$(wc -l <err.txt)" -eq 1 ] || die "$image, $limit: expected one line on stderr"
            said err.txt ': out of memory: building takes about '
            [ ! -e "$image" ] && [ ! -e l.json ] || die "$image, $limit: out of memory, and a file is there"
            ;;
        *) die "$image, $limit: exit code $code, expected 0 or 4" ;;
        esac
    done
    [ $fits$refused = yesyes ] || die "$image: all limits are alike"
}
run 0 render ball.glb --integrator classic -o l.png --size 64x48 --threads 2 --memory-limit 80M
rm l.png
limits l.png usual.png '1M 30M 40M 45M 50M 55M 60M 90M 1G'
limits l.exr usual.exr '1M 50M 70M 120M 1G'
limits l.exr compact.exr '1M 50M 70M 120M' --tracer embree:compact
