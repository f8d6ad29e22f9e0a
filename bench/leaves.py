"""Writes scenes of leaves with cut-outs for commits.py: python3 bench/leaves.py FOLDER

Five balls of 4,000 square cards stand under the sun and an even sky. The image has a leaf in the middle of a square: a
disc with a soft edge, around which the card is absent. cards.json: two triangles a card; grids.json: 72. opaque.json:
the cards of cards.json, with an image that is 1 everywhere. shade.json: a closed ball with holes around a lamp."""
import json
import math
import pathlib
import random
import sys

folder = pathlib.Path(sys.argv[1])
rng = random.Random(3)
SIZE = 256


def image(name, value):
    texels = bytes(value(x, y) for y in range(SIZE) for x in range(SIZE) for _ in range(3))
    (folder / name).write_bytes(b"P6 %d %d 255\n" % (SIZE, SIZE) + texels)


def unit():
    v = [rng.gauss(0, 1) for _ in range(3)]
    return [x / math.hypot(*v) for x in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def square(n, vertex):
    """The indices of n × n squares, whose vertices are vertex(u, v)."""
    vertices = [vertex(i % (n + 1) / n, i // (n + 1) / n) for i in range((n + 1) ** 2)]
    faces = []
    for i in range(n * n):
        a = i // n * (n + 1) + i % n
        faces += [(a, a + 1, a + n + 2), (a, a + n + 2, a + n + 1)]
    return vertices, faces


def card(n, center):
    along, way = unit(), unit()
    across = cross(along, way)
    length = math.hypot(*across)

    def vertex(u, v):
        s, t = 0.24 * (u - 0.5), 0.24 * (v - 0.5) / length
        return [center[k] + s * along[k] + t * across[k] for k in range(3)] + [u, v]

    return square(n, vertex)


def centers():
    for i in range(20000):
        d, r = unit(), 1.6 * rng.random() ** (1 / 3)
        yield [3 * (i % 5 - 2) + r * d[0], 3 + r * d[1], r * d[2]]


def write_mesh(name, parts):
    vertices, faces = [], []
    for more, of in parts:
        faces += [[i + len(vertices) for i in f] for f in of]
        vertices += more
    head = "ply\nformat ascii 1.0\nelement vertex %d\n" % len(vertices)
    head += "".join("property float %s\n" % c for c in "xyzuv")
    head += "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % len(faces)
    rows = [" ".join("%.7g" % x for x in v) for v in vertices] + ["3 %d %d %d" % tuple(f) for f in faces]
    (folder / name).write_text(head + "\n".join(rows) + "\n")


def write_scene(name, mesh, picture, objects, eye):
    leaf = {"model": "metallicRoughness", "baseColor": [0.2, 0.4, 0.1], "roughness": 0.6, "opacityCutoff": 0.5}
    leaf["opacityTexture"] = {"file": picture, "channel": "r"}
    scene = {
        "image": {"width": 480, "height": 270},
        "camera": {"eye": eye, "target": [0, 2.6, 0], "fovy": 40},
        "background": [0.5, 0.7, 1],
        "materials": {
            "leaf": leaf,
            "ground": {"model": "metallicRoughness", "baseColor": [0.4, 0.35, 0.3], "roughness": 1},
            **({"lamp": {"kd": [0, 0, 0], "ke": [30, 28, 24]}} if objects else {}),
        },
        "lights": [{"type": "sun", "direction": [0.4, -1, -0.5], "intensity": 2}],
        "objects": [
            {"type": "mesh", "file": mesh, "material": "leaf"},
            {"type": "plane", "point": [0, 0, 0], "normal": [0, 1, 0], "material": "ground"},
        ]
        + objects,
    }
    (folder / name).write_text(json.dumps(scene, indent=1))


def disc(x, y):
    r = math.hypot(x - SIZE / 2, y - SIZE / 2) / SIZE
    return max(0, min(255, round(255 * (0.42 - r) / 0.02)))


def on_ball(u, v):
    t, p = math.pi * v, 2 * math.pi * (u % 1)
    ring = 0 if v in (0, 1) else 1.4 * math.sin(t)
    return [ring * math.cos(p), 2.6 + 1.4 * math.cos(t), ring * math.sin(p), 8 * u, 4 * v]


image("leaf.ppm", disc)
image("white.ppm", lambda x, y: 255)
write_mesh("cards.ply", [card(1, c) for c in centers()])
write_mesh("grids.ply", [card(6, c) for c in centers()])
write_mesh("ball.ply", [square(128, on_ball)])
write_scene("cards.json", "cards.ply", "leaf.ppm", [], [0, 3.5, 14])
write_scene("grids.json", "grids.ply", "leaf.ppm", [], [0, 3.5, 14])
write_scene("opaque.json", "cards.ply", "white.ppm", [], [0, 3.5, 14])
lamp = {"type": "sphere", "center": [0, 2.6, 0], "radius": 0.2, "material": "lamp"}
write_scene("shade.json", "ball.ply", "leaf.ppm", [lamp], [0, 3.5, 6])
