"""Makes the scenes of lights.sh, renders and compares them."""
import json, os, random, re, resource, subprocess, sys

fathom, spp, lights, folder = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4]
NEAR, SIDE, CLEAR, HALF, SEEDS = 10, 500, 50, 0.05, 4


def places():
    rng = random.Random(7)
    found = [(rng.uniform(-2, 2), rng.uniform(1, 2), rng.uniform(-2, 2)) for _ in range(NEAR)]
    while len(found) < lights:
        x, z = rng.uniform(-SIDE, SIDE), rng.uniform(-SIDE, SIDE)
        if x * x + z * z > CLEAR * CLEAR:
            found.append((x, rng.uniform(1, 2), z))
    return found


def write_scene(name, at):
    with open(os.path.join(folder, name + ".obj"), "w") as out:
        out.write("mtllib lamp.mtl\nusemtl lamp\n")
        for x, y, z in at:
            out.write(f"v {x - HALF} {y} {z - HALF}\nv {x + HALF} {y} {z - HALF}\nv {x} {y} {z + HALF}\n")
        for i in range(len(at)):
            out.write(f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}\n")
    scene = {
        "camera": {"eye": [0, 0.9, 0.01], "target": [0, 0, 0], "fovy": 100},
        "background": [0, 0, 0],
        "image": {"integrator": "path", "width": 200, "height": 200, "maxDepth": 1},
        "materials": {"floor": {"kd": [0.6, 0.6, 0.6]}},
        "objects": [
            {"type": "quad", "center": [0, 0, 0], "u": [600, 0, 0], "v": [0, 0, -600], "material": "floor"},
            {"type": "mesh", "file": name + ".obj"},
        ],
    }
    with open(os.path.join(folder, name + ".json"), "w") as out:
        json.dump(scene, out)


def render(name, seed):
    """The processor time, in seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([fathom, "render", f"{folder}/{name}.json", "-o", f"{folder}/{name}.{seed}.exr", "-q", "--spp", spp,
                    "--seed", str(seed), "--exr-float"], check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def difference(name, a, b):
    done = subprocess.run([fathom, "compare", f"{folder}/{name}.{a}.exr", f"{folder}/{name}.{b}.exr"],
                          capture_output=True, text=True)
    return float(re.search(r"RMSE ([0-9.e+-]+)", done.stdout).group(1))


def measure(name, at):
    write_scene(name, at)
    seconds = sorted(render(name, seed) for seed in range(SEEDS))
    squares = [difference(name, seed, seed + 1) ** 2 / 2 for seed in range(0, SEEDS, 2)]
    return seconds[SEEDS // 2], sum(squares) / len(squares)


with open(os.path.join(folder, "lamp.mtl"), "w") as out:
    out.write("newmtl lamp\nKd 0 0 0\nKe 300 300 300\n")
all_of_them = places()
few, many = measure("few", all_of_them[:NEAR]), measure("many", all_of_them)
for count, (seconds, square) in ((NEAR, few), (lights, many)):
    print(f"{count:7} lights: {seconds:6.2f} s, error {square ** 0.5:.5f}")
print(f"cost at equal error: {many[0] * many[1] / (few[0] * few[1]):.1f} times that of the ten alone")
