"""Makes the scenes of lights.sh, renders and compares them. Needs python3-openimageio and python3-numpy."""
import json, os, pathlib, random, sys

import numpy as np

from noise import render

fathom, spp, lights, folder = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4]
NEAR, SIDE, CLEAR, SEEDS = 10, 500, 50, 4


class Setup:
    def __init__(self, name, low, half, balls, eye, fovy, depth):
        self.name, self.low, self.half, self.balls = name, low, half, balls
        self.camera = {"eye": eye, "target": [0, 0, 0], "fovy": fovy}
        self.image = {"integrator": "path", "width": 200, "height": 200, "maxDepth": depth}


SETUPS = (
    Setup("a bare floor", 1, 0.05, 0, [0, 0.9, 0.01], 100, 1),
    Setup("balls with soft shadows, 16 bounces", 2.5, 0.2, 4, [0, 2.4, 3.0], 60, 16),
)


def places(low):
    rng = random.Random(7)
    found = [(rng.uniform(-2, 2), rng.uniform(low, low + 1), rng.uniform(-2, 2)) for _ in range(NEAR)]
    while len(found) < lights:
        x, z = rng.uniform(-SIDE, SIDE), rng.uniform(-SIDE, SIDE)
        if x * x + z * z > CLEAR * CLEAR:
            found.append((x, rng.uniform(low, low + 1), z))
    return found


def write_scene(setup, name, at):
    half = setup.half
    balls = [
        {"type": "sphere", "center": [i - 1.5, 0.5, k - 1.5], "radius": 0.35, "material": "floor"}
        for i in range(setup.balls)
        for k in range(setup.balls)
    ]
    with open(os.path.join(folder, name + ".obj"), "w") as out:
        out.write("mtllib lamp.mtl\nusemtl lamp\n")
        for x, y, z in at:
            out.write(f"v {x - half} {y} {z - half}\nv {x + half} {y} {z - half}\nv {x} {y} {z + half}\n")
        for i in range(len(at)):
            out.write(f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}\n")
    scene = {
        "camera": setup.camera,
        "background": [0, 0, 0],
        "lights": [],
        "image": setup.image,
        "materials": {"floor": {"kd": [0.6, 0.6, 0.6]}},
        "objects": [
            {"type": "quad", "center": [0, 0, 0], "u": [600, 0, 0], "v": [0, 0, -600], "material": "floor"},
            {"type": "mesh", "file": name + ".obj"},
            *balls,
        ],
    }
    with open(os.path.join(folder, name + ".json"), "w") as out:
        json.dump(scene, out)


def measure(setup, name, at):
    """The processor time in seconds, and the error divided by the mean."""
    write_scene(setup, name, at)
    done = [render(fathom, pathlib.Path(folder, name + ".json"), seed, "--spp", spp) for seed in range(SEEDS)]
    images = np.array([image for image, seconds in done], float)
    return sorted(seconds for image, seconds in done)[SEEDS // 2], images.var(0, ddof=1).mean() ** 0.5 / images.mean()


with open(os.path.join(folder, "lamp.mtl"), "w") as out:
    out.write("newmtl lamp\nKd 0 0 0\nKe 300 300 300\n")
for setup in SETUPS:
    all_of_them = places(setup.low)
    print(f"\n{setup.name}:\n\n|lights|processor time, s|relative error|cost at equal error over one|over ten|")
    print("|-|-|-|-|-|")
    costs = []
    for count in 1, NEAR, lights:
        seconds, error = measure(setup, f"lights{count}", all_of_them[:count])
        costs.append(seconds * error**2)
        over = "|".join(f"{costs[-1] / cost:.1f}" for cost in costs[:2])
        print(f"|{count}|{seconds:.2f}|{error:.5f}|{over}|", flush=True)
