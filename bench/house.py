"""Writes a house for peers.sh: python3 house.py ROOMS LAMPS > house.json

ROOMS × ROOMS cubes with sides of 4 stand in rows, with a door to each neighbour and LAMPS lamps in each. The first
room has body.ply at its centre, the origin, and the camera in a corner."""
import json
import random
import sys

rooms, lamps = int(sys.argv[1]), int(sys.argv[2])
rng = random.Random(3)
objects = [{"type": "mesh", "file": "body.ply", "material": "white"}]


def quad(center, u, v, material):
    objects.append({"type": "quad", "center": center, "u": u, "v": v, "material": material})


def wall(along_x, x, z, door):
    """The wall around (x, 0, z); a door takes half of its width, and leaves a lintel."""
    half = lambda width: [width, 0, 0] if along_x else [0, 0, width]
    at = lambda y, off: [x + off, y, z] if along_x else [x, y, z + off]
    for y, height, off, width in [(0, 2, -1.5, 0.5), (0, 2, 1.5, 0.5), (1.5, 0.5, 0, 1)] if door else [(0, 2, 0, 2)]:
        quad(at(y, off), half(width), [0, height, 0], "red" if along_x else "white")


end = 4 * rooms - 2
middle = 2 * rooms - 2
quad([middle, -2, middle], [2 * rooms, 0, 0], [0, 0, -2 * rooms], "white")
quad([middle, 2, middle], [2 * rooms, 0, 0], [0, 0, 2 * rooms], "white")
for i in range(rooms + 1):
    for k in range(rooms):
        wall(False, 4 * i - 2, 4 * k, 0 < i < rooms)
        wall(True, 4 * k, 4 * i - 2, 0 < i < rooms)
for i in range(rooms):
    for k in range(rooms):
        for _ in range(lamps):
            center = [4 * i + rng.uniform(-1.6, 1.6), rng.uniform(0.9, 1.3), 4 * k + rng.uniform(-1.6, 1.6)]
            quad(center, [0.1, 0, 0], [0, 0, 0.1], "lamp")
json.dump(
    {
        "image": {"integrator": "path", "width": 512, "height": 512, "spp": 64, "maxDepth": 8},
        "camera": {"eye": [-1.8, 0.5, -1.8], "target": [0, -0.2, 0], "fovy": 70},
        "background": [0, 0, 0],
        "materials": {
            "white": {"kd": [0.73, 0.73, 0.73]},
            "red": {"kd": [0.63, 0.3, 0.25]},
            "lamp": {"kd": [0, 0, 0], "ke": [40, 35, 28]},
        },
        "objects": objects,
    },
    sys.stdout,
)
