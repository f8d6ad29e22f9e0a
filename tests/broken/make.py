"""Writes the broken inputs of expected.tsv to a folder: python3 make.py FOLDER.

Each is a good file with one thing wrong; what is said about it, and the exit code, stand in expected.tsv."""
import base64, json, os, struct, sys

files = {}


def add(name, content):
    if name in files:
        raise SystemExit(f"{name} is there twice")
    files[name] = content if isinstance(content, bytes) else content.encode()


# ---- scene JSON ----

SPHERE = '{"type": "sphere", "center": [0, 0, 0], "radius": 1}'


def scene(name, text):
    add(f"json-{name}.json", text)


def objects(name, *items):
    scene(name, '{"objects": [\n' + ",\n".join(items) + "\n]}\n")


def beside(name, member):
    """A good scene and one more member, on line 2."""
    scene(name, '{"objects": [' + SPHERE + "],\n" + member + "}\n")


scene("empty", "")
scene("zeros", b"\0" * 300)
scene("not-utf8", b'{"name": "\xff\xfe", "objects": []}')
scene("zero-in-string", '{"name": "a\\u0000b", "objects": []}')
scene("cut", '{"objects": [\n{"type": "sph')
scene("comma-last", '{"objects": [1,\n]}')
scene("nested-objects", '{"a": ' * 10000 + "1" + "}" * 10000)
scene("nested-groups", '{"objects": [' + '{"type": "group", "children": [' * 600 + SPHERE + "]}" * 600 + "]}")
scene("objects-empty", '{"objects": []}')
objects("radius-huge", '{"type": "sphere", "center": [0, 0, 0], "radius": 1e308}')
scene("nested-instances", json.dumps(
    {"objects": [{"type": "instance", "of": "g0"}],
     "groups": {**{f"g{i}": [{"type": "instance", "of": f"g{i + 1}"}] * 10 for i in range(8)}, "g8": [json.loads(SPHERE)]}}))
objects("mesh-position-huge", '{"type": "mesh", "positions": [[0, 0, 0], [1e308, 0, 0], [0, 1, 0]], "indices": [[0, 1, 2]]}')
objects("mesh-file-missing", '{"type": "mesh", "file": "none.obj"}')
objects("mesh-file-folder", '{"type": "mesh", "file": "folder.obj"}')
objects("mesh-file-extension", '{"type": "mesh", "file": "a.stl"}')
objects("mesh-file-empty-name", '{"type": "mesh", "file": ""}')
objects("mesh-file-broken", SPHERE, '{"type": "mesh", "file": "obj-index-beyond.obj"}')
objects("mesh-file-itself", '{"type": "mesh", "file": "json-mesh-file-itself.json"}')
objects("mesh-file-outside", '{"type": "mesh", "file": "../a.obj"}')
objects("mesh-file-absolute", '{"type": "mesh", "file": "/a.obj"}')
objects("material-unknown", '{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "gold"}')
objects("group-unknown", '{"type": "instance", "of": "tree"}')
objects("frame-crooked", '{"type": "sphere", "center": [0, 0, 0], "radius": 1, "frame":'
        ' {"origin": [0, 0, 0], "x": [1, 1, 0], "y": [0, 1, 0], "z": [0, 0, 1]}}')
INSTANCE = '{"type": "instance", "of": "%s"}'
scene("cycle-three", '{"objects": [' + INSTANCE % "a" + '], "groups": {\n"a": [' + INSTANCE % "b" + '],\n"b": ['
      + INSTANCE % "c" + '],\n"c": [' + INSTANCE % "a" + "]}}")
PLACED = '{"type": "instance", "of": "a", %s}'
for name, frames in (("shrunk", ['"scale": [1e-30, 1e-30, 1e-30]']), ("scaled", ['"scale": [1e-16, 1e-16, 1e-16]']),
                     ("grown", ['"scale": [1, 1e20, 1]']),
                     ("moved", ['"translation": [5e17, 0, 0]', '"translation": [-6e17, 0, 0]'])):
    scene("instance-" + name, '{"camera": {"eye": [0, 0, 5], "target": [0, 0, 0]}, "objects": [' + SPHERE + ",\n"
          + ",\n".join(PLACED % frame for frame in frames) + '], "groups": {"a": [' + SPHERE + "]}}")
count = 10000
beside("image-tracer", '"image": {"tracer": "./evil.so"}')
add("cut.pfm", b"PF\n64 32\n-1.0\n" + b"\0" * 999)
beside("light-environment-cut", '"lights": [{"type": "environment", "file": "cut.pfm"}]')
scene("texture-cut", '{"materials": {"a":\n{"kdTexture": {"file": "cut.pfm"}}},\n"objects": [' +
      SPHERE.replace("}", ', "material": "a"}') + "]}")
beside("light-environment-missing", '"lights": [{"type": "environment", "file": "none.hdr"}]')
beside("material-key", '"materials": {"glass": {"kx": 1}}')

# ---- glTF ----

TRIANGLE = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
INDICES = struct.pack("<3I", 0, 1, 2)
DATA = TRIANGLE + INDICES
URI = "data:application/octet-stream;base64,"


def document():
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
                      {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": 3}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 12}],
        "buffers": [{"byteLength": 48, "uri": URI + base64.b64encode(DATA).decode()}],
    }


def gltf(name, change):
    d = document()
    change(d)
    add(f"gltf-{name}.gltf", json.dumps(d))


def put(*path_and_value):
    *path, key, value = path_and_value

    def change(d):
        for step in path:
            d = d[step]
        if value is None:
            del d[key]
        else:
            d[key] = value

    return change


add("gltf-empty.gltf", "")
add("gltf-text.gltf", "glTF")
add("gltf-array.gltf", "[]")
add("gltf-cut.gltf", json.dumps(document())[:200])
add("gltf-nested.gltf", '{"asset": {"version": "2.0"}, "extras": ' + "[" * 10000 + "]" * 10000 + "}")
gltf("asset-missing", put("asset", None))
gltf("version-1", put("asset", "version", "1.0"))
gltf("version-later", put("asset", "minVersion", "2.1"))
gltf("extension-required", put("extensionsRequired", ["KHR_gaussian_splatting"]))
gltf("extension-number", put("extensionsRequired", [1]))
gltf("accessor-beyond", put("meshes", 0, "primitives", 0, "attributes", "POSITION", 7))
gltf("accessor-type", put("accessors", 0, "type", "MAT3"))
gltf("accessor-component", put("accessors", 0, "componentType", 5124))
gltf("accessor-count-missing", put("accessors", 0, "count", None))
gltf("accessor-count-negative", put("accessors", 0, "count", -1))
gltf("accessor-count-huge", put("accessors", 0, "count", 4294967295))
gltf("accessor-offset-overflow", put("accessors", 0, "byteOffset", 9223372036854775807))
gltf("accessor-offset-beyond-integers", put("accessors", 0, "byteOffset", 1e30))


def zeros(d):
    d["accessors"][0] = {"componentType": 5126, "type": "VEC3", "count": 4000000000}


gltf("accessor-zeros-huge", zeros)
gltf("stride-small", put("bufferViews", 0, "byteStride", 4))
gltf("stride-large", put("bufferViews", 0, "byteStride", 24))
gltf("stride-beyond", put("bufferViews", 0, "byteStride", 256))
gltf("view-length-missing", put("bufferViews", 0, "byteLength", None))
gltf("view-offset-overflow", put("bufferViews", 0, "byteOffset", 9223372036854775800))
gltf("buffer-uri-missing", put("buffers", 0, "uri", None))
gltf("buffer-file-missing", put("buffers", 0, "uri", "none.bin"))
gltf("buffer-file-folder", put("buffers", 0, "uri", "folder.obj"))
gltf("buffer-file-short", put("buffers", 0, "uri", "short.bin"))
gltf("buffer-file-outside", put("buffers", 0, "uri", "%2e%2e/a.bin"))
gltf("buffer-file-absolute", put("buffers", 0, "uri", "/a.bin"))
gltf("buffer-file-scheme", put("buffers", 0, "uri", "file:///a.bin"))
gltf("base64-odd", put("buffers", 0, "uri", URI + "AAAAA"))
gltf("base64-none", put("buffers", 0, "uri", "data:text/plain,hello"))
gltf("position-missing", put("meshes", 0, "primitives", 0, "attributes", {}))
gltf("scene-beyond", put("scene", 4))
gltf("scene-node-beyond", put("scenes", 0, "nodes", [1]))
gltf("scene-node-twice", put("scenes", 0, "nodes", [0, 0]))


def cycle(count):
    def change(d):
        d["nodes"] = [{"children": [(i + 1) % count]} for i in range(count)]
        d["scenes"][0]["nodes"] = [0]
    return change


gltf("node-cycle-long", cycle(10000))


def two_parents(d):
    d["nodes"] += [{"children": [2]}, {"mesh": 0}]
    d["nodes"][0] = {"children": [1, 2]}




def both(d):
    d["nodes"][0].update(matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], scale=[1, 1, 1])




def far_out(d):
    d["nodes"] = [{"scale": [1e200, 1e200, 1e200], "children": [1]}, {"scale": [1e200, 1e200, 1e200], "mesh": 0}]


gltf("node-placed-beyond", far_out)


def sparse(**changes):
    def change(d):
        s = {"count": 1, "indices": {"bufferView": 1, "componentType": 5125}, "values": {"bufferView": 0}}
        for key, value in changes.items():
            if value is None:
                del s[key]
            else:
                s[key] = value
        d["accessors"][0]["sparse"] = s
    return change


gltf("sparse-count-zero", sparse(count=0))
gltf("sparse-view-missing", sparse(indices={"componentType": 5125}))
gltf("sparse-float", sparse(indices={"bufferView": 1, "componentType": 5126}))
gltf("sparse-beyond", sparse(indices={"bufferView": 0, "byteOffset": 12, "componentType": 5125}))
gltf("camera-fov", lambda d: d.update(cameras=[{"type": "perspective", "perspective": {"yfov": -1, "znear": 1}}],
                                      nodes=[{"mesh": 0, "camera": 0}]))
gltf("light-type", lambda d: d.update(
    nodes=[{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}],
    extensions={"KHR_lights_punctual": {"lights": [{"type": "area"}]}}))
gltf("colour-beyond", lambda d: (d["meshes"][0]["primitives"][0].update(material=0), d.update(
    materials=[{"pbrMetallicRoughness": {"baseColorFactor": [2, 0, 0, 1]}}])))


# ---- GLB ----

def chunk(kind, data, fill=b" "):
    data += fill * (-len(data) % 4)
    return struct.pack("<I4s", len(data), kind) + data


def glb_of(*chunks, magic=b"glTF", version=2, length=None):
    body = b"".join(chunks)
    return magic + struct.pack("<II", version, 12 + len(body) if length is None else length) + body


plain = document()
del plain["buffers"][0]["uri"]
JSON, BIN = chunk(b"JSON", json.dumps(plain).encode()), chunk(b"BIN\0", DATA, b"\0")
whole = glb_of(JSON, BIN)  # nothing is wrong with it
add("glb-empty.glb", "")
add("glb-magic.glb", glb_of(JSON, BIN, magic=b"gltF"))
add("glb-header-cut.glb", whole[:10])
add("glb-length-beyond.glb", glb_of(JSON, BIN, length=1 << 31))
add("glb-length-short.glb", glb_of(JSON, BIN, length=16))
add("glb-cut.glb", whole[:-20])
add("glb-chunk-cut.glb", glb_of(JSON, b"\0\0\0"))
add("glb-chunk-beyond.glb", glb_of(struct.pack("<I4s", 0xFFFFFFFF, b"JSON") + b"{}"))
add("glb-chunk-first.glb", glb_of(BIN, JSON))
add("glb-bin-missing.glb", glb_of(JSON))
add("glb-bin-short.glb", glb_of(JSON, chunk(b"BIN\0", DATA[:40], b"\0")))
add("glb-json-wrong.glb", glb_of(chunk(b"JSON", b'{"asset": {"version": "2.0"},}'), BIN))
add("glb-json-empty.glb", glb_of(chunk(b"JSON", b""), BIN))

# ---- OBJ and MTL ----

CORNERS = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"


def obj(name, text):
    add(f"obj-{name}.obj", text)


obj("empty", "")
obj("vertex-huge", "v 0 1e39 0\n")
obj("index-beyond", CORNERS + "f 1 2 4\n")
obj("index-normal", CORNERS + "f 1//1 2//1 3//1\n")
obj("index-texture", CORNERS + "vt 0 0\nf 1/2 2/1 3/1\n")
obj("utf16", (CORNERS + "f 1 2 3\n").encode("utf-16"))
obj("library-outside", "mtllib ../a.mtl\n" + CORNERS + "f 1 2 3\n")
obj("library-absolute", "mtllib /a.mtl\n" + CORNERS + "f 1 2 3\n")


def mtl(name, text):
    add(f"mtl-{name}.mtl", text)
    obj(f"mtl-{name}", f"mtllib mtl-{name}.mtl\nusemtl a\n{CORNERS}f 1 2 3\n")


mtl("early", "Kd 1 1 1\n")
mtl("name", "newmtl\n")
mtl("word", "newmtl a\nKd red\n")
mtl("two", "newmtl a\nKd 1 1\n")
mtl("negative", "newmtl a\nKs -1 0 0\n")
mtl("dissolve", "newmtl a\nd 1.5\n")
mtl("illum-fraction", "newmtl a\nillum 1.5\n")
mtl("shininess", "newmtl a\nNs inf\n")
mtl("utf16", b"\xfe\xff" + "newmtl a\n".encode("utf-16-be"))
mtl("zero-byte", b"newmtl a\nKd 1 1 1\0garbage\n")

# ---- PLY ----

HEAD = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
FACE = "element face 1\nproperty list uchar int vertex_indices\n"
ROWS, ROW = "0 0 0\n1 0 0\n0 1 0\n", "3 0 1 2\n"


def ply(name, header, body="", format="ascii 1.0"):
    text = f"ply\nformat {format}\n{header}end_header\n"
    add(f"ply-{name}.ply", text.encode() + (body.encode() if isinstance(body, str) else body))


def little(name, header, body):
    ply(name, header, body, "binary_little_endian 1.0")


BINARY_ROWS, BINARY_FACE = TRIANGLE, struct.pack("<B3i", 3, 0, 1, 2)
add("ply-empty.ply", "")
add("ply-zeros.ply", b"\0" * 300)
ply("element-count", "element vertex many\n")
ply("list-type", "element face 1\nproperty list uchar vertex_indices\n")
ply("vertex-none", HEAD.replace("3", "0") + FACE, "3 0 0 0\n")
ply("count-overflow", HEAD.replace("3", "99999999999999999999999") + FACE, ROWS + ROW)
ply("count-beyond", HEAD.replace("3", "4") + FACE, ROWS + ROW)
ply("index-word", HEAD + FACE, ROWS + "3 0 1 b\n")
ply("zero-byte", HEAD + FACE, ROWS.encode() + b"3 0 1 2\0\n")
ply("line-endless", "comment " + "x" * 70000 + "\n" + HEAD + FACE, ROWS + ROW)
little("binary-cut", HEAD + FACE, BINARY_ROWS[:30])
little("binary-face-cut", HEAD + FACE, BINARY_ROWS + BINARY_FACE[:6])

# ---- files of rays ----

RAY = "reference camera 0 wrong 0 0 5 0 0 -1 0 inf triangles\n"


def rays(name, text):
    add(f"rays-{name}.txt", text)


rays("empty", "")
rays("words", "what is this\n")
rays("zero-byte", RAY.encode() + b"\0" + RAY.encode())
rays("number-missing", "reference camera 0 wrong 0 0 5\n")
rays("number-wide", RAY.replace("5", "1.00000000001"))
rays("scene-unknown", RAY.replace("triangles", "none.obj"))
rays("scene-outside", RAY.replace("triangles", "../a.obj"))
rays("scene-absolute", RAY.replace("triangles", "/a.obj"))
rays("tracer-unknown", RAY.replace("reference", "magic"))
rays("tracer-library", RAY.replace("reference", "./evil.so"))
rays("direction-zero", RAY.replace("-1", "0"))
rays("extreme-unknown", RAY.replace("triangles", "extreme:none:1"))
rays("extreme-number", RAY.replace("triangles", "extreme:scale"))
rays("line-long", RAY.replace("triangles", "x" * 5000))

# ---- what is no file of its kind ----

add("short.bin", DATA[:40])
add("extension", "")
add("model.stl", "solid\n")
add("model.json.txt", "{}")
add("good.json", "{\"objects\": [" + SPHERE + "]}")
add("good.glb", whole)

if __name__ == "__main__":
    folder = sys.argv[1]
    os.makedirs(os.path.join(folder, "folder.obj"), exist_ok=True)
    for name, content in files.items():
        with open(os.path.join(folder, name), "wb") as file:
            file.write(content)
