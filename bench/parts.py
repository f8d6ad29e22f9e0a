"""Writes a scene of many parts, ribbons of 200 triangles that wind through each other, each a mesh that is placed once.
usage: python3 bench/parts.py SCENE.json [PARTS (300)]"""
import json
import math
import random
import sys

STEPS = 100


def ribbon(r):
    turns, width, start = r.uniform(6, 24), r.uniform(0.1, 0.5), r.uniform(0, 6)
    rows = [(2 * i / STEPS - 1, width * math.sin(turns * i / STEPS + start), 0.3 * math.cos(5 * i / STEPS)) for i in range(STEPS + 1)]
    positions = [[round(x, 5), round(y + side, 5), round(z, 5)] for x, y, z in rows for side in (-0.02, 0.02)]
    indices = [c for i in range(0, 2 * STEPS, 2) for c in ([i, i + 2, i + 3], [i, i + 3, i + 1])]
    return {"type": "mesh", "positions": positions, "indices": indices, "material": f"m{r.randrange(8)}",
            "rotate": {"axis": [r.gauss(0, 1) for _ in range(3)], "angle": r.uniform(0, 360)}, "scale": [1.5, 1.5, 1.5],
            "translation": [r.uniform(-1, 1), r.uniform(0.6, 2.2), r.uniform(-1, 1)]}


def main(path, parts="300"):
    r = random.Random(3)
    materials = {f"m{i}": {"kd": [r.uniform(0.2, 0.8) for _ in range(3)]} for i in range(8)}
    floor = {"type": "quad", "center": [0, 0, 0], "u": [5, 0, 0], "v": [0, 0, -5], "material": "m0"}
    scene = {"camera": {"eye": [0, 1.6, 6], "target": [0, 1.2, 0], "fovy": 40}, "image": {"width": 640, "height": 360},
             "background": [0.8, 0.85, 1], "materials": materials, "objects": [floor] + [ribbon(r) for _ in range(int(parts))]}
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)


if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
    sys.exit(__doc__)
main(*sys.argv[1:])
