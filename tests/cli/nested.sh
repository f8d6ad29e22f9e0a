# Nesting to a depth of 10,000 has a defined result with a stack of 1 MB, that of threads included.
. "$SOURCE/tests/cli/check.inc"
command -v python3 >/dev/null || die 'python3 is missing; see tests/packages.sh'
python3 - <<'PY'
import json
N = 10000
SPHERE = {"type": "sphere", "center": [0, 0, 0], "radius": 1}


def write(name, document):
    with open(name, "w") as file:
        file.write(document if isinstance(document, str) else json.dumps(document))


def of(group):
    return {"type": "instance", "of": group, "translation": [0, 0, 1e-4]}


chain = {f"g{i}": [of(f"g{i + 1}") if i + 1 < N else SPHERE] for i in range(N)}
write("chain.json", {"objects": [of("g0")], "groups": chain})
chain[f"g{N - 1}"] = [of("g1")]
write("cycle.json", {"objects": [of("g0")], "groups": chain})
for levels in 512, 513, N:
    write(f"children-{levels}.json", '{"objects": [' + '{"type": "group", "children": [' * levels + json.dumps(SPHERE)
          + "]}" * levels + "]}")
# Ways through 250 groups of 100 levels each, back to the first: no search may follow all of it by calls.
deep = {f"g{i}": json.loads('[{"type": "group", "children": ' * 100 + json.dumps([of(f"g{(i + 1) % 250}")]) + "}]" * 100)
        for i in range(250)}
write("winding.json", {"objects": [of("g0")], "groups": deep})
write("arrays.json", '{"name": ' + "[" * N + "]" * N + "}")
nodes = [{"children": [i + 1], "translation": [0, 0, 1e-4]} for i in range(N)] + [{"mesh": 0}]
document = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": nodes,
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}],
            "buffers": [{"byteLength": 36, "uri": "data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]}
write("nodes.gltf", document)
nodes[N] = {"children": [0]}
document["scenes"] = []
write("nodes-cycle.gltf", document)
document["extras"] = 0
write("extras.gltf", json.dumps(document).replace('"extras": 0', '"extras": ' + "[" * N + "]" * N))
PY
# Sanitizers make calls several times as large.
[ -n "${SANITIZE:-}" ] || ulimit -s 1024

for scene in chain.json nodes.gltf children-512.json; do
    run 0 info $scene
    run 0 render $scene -o $scene.exr --size 32x32 -q
    run 0 validate $scene --rays 10 --tracer embree
done
refused 3 'cycle.json:1: groups: groups contain each other in a cycle: "g1" -> "g2"' render cycle.json -o a.exr
refused 3 'winding.json:1: groups: groups contain each other in a cycle: "g0"' render winding.json -o a.exr
refused 3 'children are nested more than 512 levels' render children-513.json -o a.exr
refused 3 'children are nested more than 512 levels' info children-513.json
refused 3 'brackets are nested too deep; expected at most 2048 levels' info children-10000.json
refused 3 'arrays.json:1:2057: brackets are nested too deep' info arrays.json
refused 3 'nodes-cycle.gltf:1: nodes[0].children: leads back to nodes[0]' render nodes-cycle.gltf --integrator classic -o a.exr
refused 3 'brackets are nested too deep' info extras.gltf
