# Broken input: each line of tests/broken/expected.tsv has arguments, the exit code and the message, which may end
# in ... where the rest depends on the libraries that are installed. Where the code is 0, the message is the first
# problem that info lists. Files are made by tests/broken/make.py.
. "$SOURCE/tests/cli/check.inc"
command -v python3 >/dev/null || die 'python3 is missing; see tests/packages.sh'
mkdir files
python3 "$SOURCE/tests/broken/make.py" files
cd files
ls -A >../before.txt

refuse() {
    code=0
    "$FATHOM" "$@" >../out.txt 2>../err.txt </dev/null || code=$?
    found=$(sed 's/^fathom: //' ../err.txt)
    [ "$expected" -ne 0 ] || found=$(sed -n '/^problems/,$s/^  //p' ../out.txt | head -n 1)
    same=no
    case $message in
    *...) [ "${found#"${message%...}"}" = "$found" ] || same=yes ;;
    *) [ "$found" != "$message" ] || same=yes ;;
    esac
    [ $same = yes ] && [ $code -eq "$expected" ] && return
    cd ..
    die "fathom $*: code $code, expected $expected and: $message"
}
# Nothing of it takes memory: 4 GB hold Embree's and the image module's libraries many times over. Sanitizers reserve
# terabytes.
(
    [ -n "${SANITIZE:-}" ] || ulimit -v 4000000
    set -f
    rows=0
    while IFS="$(printf '\t')" read -r arguments expected message; do
        # shellcheck disable=SC2086 # words, by design
        refuse $arguments
        # A render refuses the same as info, in the same words, before there is any file; some of them suffice. A
        # render leaves texture coordinates in their files.
        rows=$((rows + 1))
        case $expected$arguments in
        '3info '*-texture-*) ;;
        '3info '*.*) [ $((rows % 8)) -ne 0 ] || refuse render "${arguments#info }" -o a.png -q ;;
        esac
    done <"$SOURCE/tests/broken/expected.tsv"
    [ $rows -ge 150 ] || die "only $rows lines in expected.tsv"
)
ls -A | diff ../before.txt - || die 'files came or went'

# Pipes, devices and folders are refused at once, whatever they are called. Nobody writes to the pipe, and the device never ends.
cd ..
mkfifo pipe.json pipe.obj pipe.ply pipe.glb
for extension in json obj ply glb gltf; do
    ln -s /dev/zero zero.$extension
    refused 3 "fathom: zero.$extension: is not a regular file; expected one on a disk" info zero.$extension
    mkdir folder.$extension
    refused 3 "fathom: folder.$extension: is a folder, expected a file" info folder.$extension
    ln -s loop.$extension loop.$extension
    refused 3 "fathom: loop.$extension: Too many levels of symbolic links" info loop.$extension
    if [ "$(id -u)" -ne 0 ]; then
        cp files/good.glb closed.$extension
        chmod 000 closed.$extension
        refused 3 "fathom: closed.$extension: Permission denied" info closed.$extension
    fi
done
for extension in json obj ply glb; do
    refused 3 "fathom: pipe.$extension: is not a regular file; expected one on a disk" info pipe.$extension
done
printf '{ "objects": [ { "type": "mesh", "file": "pipe.obj" } ] }' >scene.json
refused 3 'objects[0].file: pipe.obj: is not a regular file' info scene.json

# A terabyte of nothing, with a good beginning or without. Sanitizers have not as many addresses to give.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >good.obj
printf '{ "objects": [] }' | tee good.json >good.gltf
printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n' >good.ply
cp files/good.glb good.glb
for extension in json obj ply glb gltf; do
    # The header of a GLB says where it ends.
    wanted=3
    [ $extension != glb ] || wanted=0
    : >void.$extension
    # Text is looked through for zeros, so its files are small.
    size=1T
    case $extension in obj | ply) size=16M ;; esac
    truncate -s $size void.$extension 2>/dev/null && [ -z "${SANITIZE:-}" ] || continue
    run 3 info void.$extension
    cp good.$extension huge.$extension
    truncate -s $size huge.$extension
    run $wanted info huge.$extension
    rm void.$extension huge.$extension
done
