"""Inputs of a megabyte, each built to cost a reader as much as it can: many of everything, deep, crossing, crowded.

usage: large.py FOLDER    writes FOLDER/TARGET/NAME"""
import math
import os
import struct
import sys

MEGABYTE = 1 << 20


def fill(make, head="", tail="", size=MEGABYTE):
    """head, make(0), make(1)... up to the size, tail"""
    parts, used, i = [head], len(head) + len(tail), 0
    while True:
        part = make(i)
        used += len(part)
        if used > size:
            return "".join(parts) + tail
        parts.append(part)
        i += 1


def rows(make, head, tail):
    """The same with commas between."""
    return fill(lambda i: ("," if i else "") + make(i), head, tail)


SPHERE = '{"type":"sphere","center":[0,0,0],"radius":1}'


def scene_json():
    lights = MEGABYTE // 2 // 45
    spheres = ",".join([SPHERE] * lights)
    points = ",".join(['{"type":"point","position":[9,9,9]}'] * lights)
    chain = ",".join(f'"g{i}":[' + ",".join([f'{{"type":"instance","of":"g{i + 1}"}}'] * 10) + "]" for i in range(60))
    ring = ",".join(
        f'"g{i}":[' + '{"type":"group","children":[' * 300 + f'{{"type":"instance","of":"g{i + 1}"}}' + "]}" * 300 + "]"
        for i in range(110))
    return {
        "materials": rows(lambda i: f'"m{i}":{{}}', '{"materials":{', '},"objects":[%s]}' % SPHERE),
        "groups": rows(lambda i: f'"g{i}":[]', '{"groups":{', '},"objects":[%s]}' % SPHERE),
        "unknown_names": rows(lambda i: f'"m{i}":{{}}', '{"materials":{',
                              '},"objects":[{"type":"sphere","radius":1,"center":[0,0,0],"material":"x"}]}'),
        "lights_in_spheres": f'{{"lights":[{points}],"objects":[{spheres}]}}',
        "spheres": rows(lambda i: SPHERE, '{"objects":[', "]}"),
        "placed": rows(lambda i: SPHERE[:-1] + ',"translation":[1,2,3]}', '{"objects":[', "]}"),
        "batches": rows(lambda i: '{"type":"triangle","vertices":[[0,0,0],[1,0,0],[0,1,0]],"castsShadow":%s}'
                        % ("true" if i % 2 else "false"), '{"objects":[', "]}"),
        "brackets": "[" * MEGABYTE,
        "objects": rows(lambda i: "{}", '{"objects":[', "]}"),
        "empty_arrays": rows(lambda i: "[]", '{"objects":[', "]}"),
        "keys": rows(lambda i: f'"k{i}":0', "{", "}"),
        "number": '{"objects":[' + "9" * MEGABYTE + "]}",
        "name": '{"name":"' + "\\u00e9" * (MEGABYTE // 6) + '","objects":[' + SPHERE + "]}",
        "doubling": f'{{"groups":{{{chain},"g60":[{SPHERE}]}},"objects":[{{"type":"instance","of":"g0"}}]}}',
        "deep_ring": f'{{"groups":{{{ring},"g110":[{{"type":"instance","of":"g0"}}]}},"objects":[]}}',
        "chain": rows(lambda i: f'"g{i}":[{{"type":"instance","of":"g{i + 1}"}}]', '{"groups":{',
                      '},"objects":[{"type":"instance","of":"g0"}]}'),
        "grid": '{"objects":[{"type":"mesh","shading":"smooth","positions":['
                + ",".join(["[0,0,0]", "[1,0,0]", "[0,1,0]"] * 20000) + '],"indices":['
                + ",".join(["[0,1,2]"] * 50000) + "]}]}",
    }


ASSET = '{"asset":{"version":"2.0"},'
ZERO = '{"componentType":5126,"count":%d,"type":"VEC3"}'


def glb(text, data):
    text = text.encode() + b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    return (b"glTF" + struct.pack("<II", 2, 28 + len(text) + len(data)) + struct.pack("<I4s", len(text), b"JSON") + text
            + struct.pack("<I4s", len(data), b"BIN\0") + data)


def of_buffer(data, accessors, rest):
    return glb(ASSET + f'"buffers":[{{"byteLength":{len(data)}}}],"bufferViews":[{{"buffer":0,"byteLength":{len(data)}}}],'
               f'"accessors":[{accessors}],' + rest + "}", data)


def gltf():
    mesh = '{"primitives":[{"attributes":{"POSITION":%d}}]}'
    return {
        "zeros": ASSET + '"accessors":[' + ZERO % 4000000000 + '],"meshes":[' + mesh % 0 + "]}",
        "many_zeros": ASSET + '"accessors":[' + ",".join([ZERO % 100000] * 8000) + '],"meshes":['
                      + ",".join(mesh % i for i in range(8000)) + "]}",
        "nodes": rows(lambda i: f'{{"children":[{i + 1}]}}', ASSET + '"nodes":[', ',{}]}'),
        "roots": rows(lambda i: "{}", ASSET + '"nodes":[', "]}"),
        "children": ASSET + '"nodes":[{"children":[' + ",".join(map(str, range(1, 100000))) + "]}"
                    + ",{}" * 100000 + "]}",
        "brackets": ASSET + '"a":' + "[" * MEGABYTE,
        "extensions": rows(lambda i: '"KHR_materials_ior"', ASSET + '"extensionsRequired":[', "]}"),
        "keys": rows(lambda i: f'"k{i}":0', "{", "}"),
        "base64": ASSET + '"buffers":[{"byteLength":700000,"uri":"data:;base64,' + "AAAA" * 250000
                  + '"}],"bufferViews":[{"buffer":0,"byteLength":700000}],"accessors":[{"bufferView":0,"count":50000,'
                  '"componentType":5126,"type":"VEC3"}],"meshes":[' + mesh % 0 + "]}",
    }


def glb_files():
    data = bytes(524288)
    bytes_of = ",".join(['{"bufferView":0,"componentType":5121,"normalized":true,"count":%d,"type":"VEC3"}' % 131072] * 5000)
    shared = '{"bufferView":0,"componentType":5121,"count":131072,"type":"VEC3"},' \
             '{"bufferView":0,"componentType":5121,"count":500000,"type":"SCALAR"}'
    strips = ",".join(['{"attributes":{"POSITION":0},"indices":1,"mode":5}'] * 8000)
    ascending = struct.pack("<100000I", *range(100000))
    sparse = ('{"count":100000,"componentType":5126,"type":"VEC3","sparse":{"count":100000,"indices":{"bufferView":0,'
              '"componentType":5125},"values":{"bufferView":0}}}')
    many = ",".join(['{"mesh":0,"extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":0}}}}'] * 5000)
    return {
        "conversions": of_buffer(data, bytes_of, '"meshes":['
                                 + ",".join('{"primitives":[{"attributes":{"POSITION":%d}}]}' % i for i in range(5000)) + "]"),
        "strips": of_buffer(data, shared, '"meshes":[{"primitives":[' + strips + "]}]"),
        "counted_up": of_buffer(data, shared, '"meshes":[{"primitives":['
                                + ",".join(['{"attributes":{"POSITION":0}}'] * 10000) + "]}]"),
        "sparse": of_buffer(ascending + bytes(800000), sparse, '"meshes":[{"primitives":['
                            + ",".join(['{"attributes":{"POSITION":0}}'] * 5000) + "]}]"),
        "instances": of_buffer(data, '{"bufferView":0,"componentType":5126,"count":40000,"type":"VEC3"},'
                               '{"bufferView":0,"componentType":5121,"count":3,"type":"SCALAR"}',
                               '"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"nodes":[' + many + "]"),
        "chunks": b"glTF" + struct.pack("<II", 2, 12 + 12 + 8 * 131000) + struct.pack("<I4s", 4, b"JSON") + b"{}  "
                  + struct.pack("<I4s", 0, b"XXXX") * 131000,
    }


def star(n):
    """A polygon that crosses itself everywhere."""
    return [(math.cos(2.3 * i), math.sin(2.3 * i)) for i in range(n)]


def comb(n):
    """Teeth: half of all corners are reflex."""
    return [(i, 0 if i % 2 else 1000) for i in range(n - 1)] + [(n / 2, -1)]


def polygon_obj(points):
    return "".join(f"v {x:.4g} {y:.4g} 0\n" for x, y in points) + "f " + " ".join(str(i + 1) for i in range(len(points))) + "\n"


def obj():
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
    materials = corners + "mtllib a.mtl\nf 1 2 3\n"
    return {
        "faces": fill(lambda i: "f 1 2 3\n", corners),
        "vertices": fill(lambda i: "v 0 0 0\n", "", "f 1 2 3\n"),
        "materials": fill(lambda i: f"usemtl m{i}\nf 1 2 3\n", corners),
        "groups": fill(lambda i: f"s {i}\nf 1 2 3\n", corners),
        "libraries": fill(lambda i: f"mtllib l{i % 97}\n", corners + "f 1 2 3\n"),
        "same_libraries": fill(lambda i: f"mtllib {'./' * (i % 2)}a.mtl\n", corners + "f 1 2 3\n").encode()
                          + b"\xff" + b"newmtl a\n" * 10000,
        "library_words": fill(lambda i: "a ", corners + "f 1 2 3\nmtllib ", "\n"),
        "star": polygon_obj(star(40000)),
        "comb": polygon_obj(comb(40000)),
        "flat": polygon_obj([(i % 100, 0) for i in range(60000)]),
        "same": polygon_obj([(0, 0)] * 90000),
        "joined": fill(lambda i: "\\\n", corners + "f 1 2 3 ", "\n"),
        "blank": corners + " " * MEGABYTE + "\nf 1 2 3\n",
        "smooth_fan": fill(lambda i: "v 1 %d 0\n" % i, "", "".join("f 1 %d %d\n" % (i, i + 1) for i in range(2, 30000))),
        "digits": "v " + "9" * MEGABYTE + " 0 0\n",
        "points": fill(lambda i: " 1", "v 0 0 0\np", "\n"),
        "coloured_lines": fill(lambda i: f" {i % 2 + 1}", "v 0 0 0 1 0 0\nv 1 0 0\nl", "\n"),
        "short_lines": fill(lambda i: f"usemtl m{i % 97}\nl 1 2\nl 1\n", corners),
        "cloud": fill(lambda i: "v 9e9 %d 0\n" % (i % 10)),
        "newmtl": (materials + "").encode() + b"\xff" + fill(lambda i: f"newmtl m{i}\n").encode(),
    }


def ply_of(kind, elements, body):
    return f"ply\nformat {kind} 1.0\n{elements}end_header\n".encode() + body


def ply():
    xyz = "property float x\nproperty float y\nproperty float z\n"
    face = "element face %d\nproperty list %s vertex_indices\n"
    points = star(50000)
    ring = b"".join(struct.pack("<3f", x, y, 0) for x, y in points)
    small = b"".join(struct.pack("<3f", x, y, 0) for x, y in points[:3])
    return {
        "polygon": ply_of("binary_little_endian", f"element vertex 50000\n{xyz}" + face % (1, "uint uint"),
                          ring + struct.pack("<I50000I", 50000, *range(50000))),
        "edges": ply_of("binary_little_endian", f"element vertex 3\n{xyz}element edge {MEGABYTE // 2}\nproperty uchar "
                        "vertex1\nproperty uchar vertex2\n", small + b"\x00\x02" * (MEGABYTE // 2)),
        "strip": ply_of("binary_little_endian", f"element vertex 3\n{xyz}element tristrips 1\nproperty list uint int "
                        "vertex_indices\n", small + struct.pack("<I", 250000) + struct.pack("<5i", 0, 1, 2, 1, 0) * 50000),
        "properties": ply_of("ascii", f"element vertex 3\n{xyz}" + fill(lambda i: f"property int a{i}\n"), b""),
        "elements": ply_of("ascii", f"element vertex 3\n{xyz}" + face % (1, "uchar int")
                           + fill(lambda i: f"element a{i} 0\n"), b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        "comments": ply_of("ascii", fill(lambda i: "comment\n") + f"element vertex 3\n{xyz}" + face % (1, "uchar int"),
                           b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        "empty_faces": ply_of("binary_little_endian", f"element vertex 3\n{xyz}" + face % (1000000, "uchar int"),
                              small + bytes(1000000)),
        "blank_lines": ply_of("ascii", f"element vertex 3\n{xyz}" + face % (1, "uchar int"),
                              b"\n" * MEGABYTE + b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        "vertices": ply_of("ascii", f"element vertex 170000\n{xyz}" + face % (1, "uchar int"),
                           b"0 0 0\n" * 170000 + b"3 0 1 2\n"),
        "faces": ply_of("ascii", f"element vertex 3\n{xyz}" + face % (130000, "uchar int"),
                        b"0 0 0\n1 0 0\n0 1 0\n" + b"3 0 1 2\n" * 130000),
    }


def rays():
    line = "embree vertex 17 leak 1 0 0 0 0 1 0 inf s\n"
    return {
        "lines": fill(lambda i: line),
        "comments": fill(lambda i: "#\n"),
        "long": line[:-1] + "s" * MEGABYTE,
        "digits": "a b 1 c " + "9" * MEGABYTE,
        "blank": fill(lambda i: "\n"),
    }


def command_line():
    return {
        "words": fill(lambda i: "a\n"),
        "tracer": "--tracer\nembree" + ":user" * (MEGABYTE // 5),
        "kinds": "--tracer\n" + "x" * MEGABYTE,
        "counts": "-c" + "1," * (MEGABYTE // 2),
        "digits": "-r" + "9" * MEGABYTE,
        "power": "-n1e" + "9" * MEGABYTE,
        "option": "--" + "s" * MEGABYTE,
        "aov": "--aov=" + "Z," * (MEGABYTE // 2),
    }


def checkpoint():
    """Records of waves as they are, which are too large for the corpus."""
    head = (b"FTHMCKPT" + struct.pack("<II", 1, 20) + b"0.1.0".ljust(32, b"\0") + b"embree".ljust(128, b"\0") + bytes(160))
    record = struct.pack("<64d", *[1.0] * 64) + struct.pack("<64Q", *[9] * 64) + struct.pack("<64I", *[1] * 64) + bytes(49152)
    # The last byte: records are whole (checkpoint.c).
    end = struct.pack("<II", 0xFFFFFFFF, 0) + struct.pack("<QQdd", 1, 1, 0.5, 1) + bytes(32) + bytes(7) + b"\x08"
    return {
        "records": head + b"".join(struct.pack("<II", i, 0) + record for i in range(4)) + end,
        "record": head + struct.pack("<II", 2, 0) + record + end,
        "same_record": head + (struct.pack("<II", 2, 0) + record) * 20 + end,
        "zeros": head + bytes(MEGABYTE - 1) + b"\x08",
    }


def wire():
    size = struct.pack("<6I", 2, 2, 0, 0, 2, 2)
    channel = struct.pack("<I2s3I", 2, b"R", 0, 1, 1)
    count = MEGABYTE // len(channel)
    number = struct.pack("<I2sII", 2, b"a", 0, MEGABYTE // 8) + bytes(MEGABYTE)
    return {
        "channels": size + struct.pack("<2I", count, 0) + channel * count,
        "numbers": size + struct.pack("<2I", 0, 1) + number,
        "name": struct.pack("<8I", 4, 4, 1, 0, 0, 1, 0, MEGABYTE) + b"p" * (MEGABYTE - 1) + b"\0",
    }


def part():
    """Tiles of no use after the ones that there are, and a record that says it has all the rest."""
    def record(wave, payload):
        return struct.pack("<IIQQdd7Q", 0x45564157, wave, 9, len(payload), 0, 1, *range(7)) + payload + bytes(8)

    tiles = bytes([2, 0]) + b"".join(record(wave, bytes(768)) for wave in range(4))
    again = record(0, bytes(768))
    return {
        "again": tiles + again * ((MEGABYTE - len(tiles)) // len(again)),
        "one": bytes([2, 0]) + record(0, bytes(MEGABYTE - 200)),
        "changes": bytes([0, 255]) + bytes([16, 0, 2]) * 255 + bytes(MEGABYTE // 2),
    }


def ranks():
    """Requests without end; units and results of one square, again and again."""
    def messages(kind, count, body):
        one = struct.pack("<HII", 8 + len(body), kind, count) + body
        return one * ((MEGABYTE - 1) // len(one))

    unit = struct.pack("<IIQ", 0, 0, 1 << 63)
    done = unit + struct.pack("<Qdd7Q", 1, 0, 0, *range(7)) + bytes(256)
    return {
        "requests": b"\4" + messages(2, 1, b""),
        "units": b"\1" + messages(3, 4000, unit * 4000),
        "results": b"\4" + messages(2, 9, b"")[:10] + messages(4, 1, done),
    }


def main(folder):
    targets = {"scene_json": scene_json, "gltf": gltf, "glb": glb_files, "obj": obj, "ply": ply, "rays": rays,
               "command_line": command_line, "checkpoint": checkpoint, "wire": wire, "part": part,
               "ranks": ranks}
    for target, make in targets.items():
        os.makedirs(f"{folder}/{target}", exist_ok=True)
        for name, content in make().items():
            with open(f"{folder}/{target}/{name}", "wb") as file:
                file.write(content if isinstance(content, bytes) else content.encode())


main(sys.argv[1])
