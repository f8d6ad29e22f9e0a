"""Path tracing against the reference integrator on scenes made by chance: shapes, placements, motion, lenses, materials, lights
and skies. A scene that differs is rendered again with another seed and eight times the samples, and counts if it differs
again. Prints a line for each that differs or is refused, and where it was kept.
usage: python3 tests/light_random.py FATHOM [COUNT [SEED [ERROR [FOLDER]]]]
  COUNT   scenes (100)
  SEED    of the first; each further scene has the next (1)
  ERROR   the relative standard error to aim at, by some 4 / ERROR^2 samples (0.004)
  FOLDER  where scenes that differ are kept (.)
Exit code 1: a scene differs, one run in 10,000 by chance."""
import json
import math
import os
import random
import shutil
import subprocess
import sys
import tempfile

LEVEL = 0.01  # of all scenes together; twice by chance is its square


def color(r, low=0.0, high=1.0):
    return [round(r.uniform(low, high), 3) for _ in range(3)]


def maybe(r, part, of, key, value):
    if r.random() < part:
        of[key] = value()


def classic(r):
    m = {"kd": color(r, 0, 0.8)}
    kind = r.choice(("matt", "glossy", "mirror", "glass"))
    if kind == "glossy":
        m.update(kd=color(r, 0, 0.5), ks=color(r, 0, 0.4), specular=r.choice(("phong", "blinn")),
                 shininess=round(10 ** r.uniform(0, 3), 1))
    elif kind == "mirror":
        m.update(kd=color(r, 0, 0.3), kr=color(r, 0.1, 0.7))
    elif kind == "glass":
        m.update(kd=[0, 0, 0], kr=[1, 1, 1], kt=[1, 1, 1], fresnel=True, ior=round(r.uniform(1.05, 2), 3))
    maybe(r, 0.2, m, "litFromBehind", lambda: True)
    return m


def leave_out(m):
    """What the reference refuses beside each other."""
    solid = m.get("thickness", 0) > 0
    refused = []
    if m.get("transmission", 0) > 0:
        refused += ["clearcoat", "sheenColor"]
    if m.get("iridescence", 0) > 0 or solid:
        refused += ["specular", "specularColor"]
    if solid:
        refused += ["iridescence", "opacity"]
    for key in refused:
        m.pop(key, None)
    return m


def metallic(r, directed):
    def unit():
        return round(r.random(), 3)
    m = {"model": "metallicRoughness", "baseColor": color(r, 0, 1), "metallic": r.choice((0, 0, 1, unit())),
         "roughness": r.choice((0, unit(), unit(), 1)), "ior": round(r.uniform(1, 2.4), 3)}
    maybe(r, 0.3, m, "specular", unit)
    maybe(r, 0.3, m, "specularColor", lambda: color(r))
    maybe(r, 0.3, m, "clearcoat", unit)
    maybe(r, 0.3, m, "clearcoatRoughness", unit)
    maybe(r, 0.2, m, "sheenColor", lambda: color(r))
    maybe(r, 0.2, m, "sheenRoughness", unit)
    maybe(r, 0.2, m, "diffuseTransmission", unit)
    maybe(r, 0.2, m, "diffuseTransmissionColor", lambda: color(r))
    maybe(r, 0.2, m, "opacity", unit)
    maybe(r, 0.3, m, "multiscatter", lambda: False)
    maybe(r, 0.2, m, "doubleSided", lambda: False)
    maybe(r, 0.3, m, "transmission", unit)
    if r.random() < 0.2:
        m.update(iridescence=unit(), iridescenceIor=round(r.uniform(1, 2.5), 2),
                 iridescenceThicknessMax=round(r.uniform(50, 900)))
    if directed and r.random() < 0.4:
        m.update(anisotropy=unit(), anisotropyRotation=round(r.uniform(-4, 4), 2))
    return leave_out(m)


def solid(r, directed):
    m = metallic(r, directed)
    m.pop("diffuseTransmission", None)
    m.update(transmission=1, metallic=0, thickness=1, priority=r.randint(1, 255))
    maybe(r, 0.5, m, "attenuationColor", lambda: color(r, 0.1, 1))
    maybe(r, 0.5, m, "attenuationDistance", lambda: round(r.uniform(0.2, 3), 2))
    maybe(r, 0.3, m, "dispersion", lambda: round(r.uniform(0, 4), 2))
    return leave_out(m)


def lamp(r):
    strength = 10 ** r.uniform(-0.5, 1)
    return {"kd": [0, 0, 0], "ke": [round(strength * c, 3) for c in color(r, 0.3, 1)]}


def direction(r):
    z, turn = r.uniform(-1, 1), r.uniform(0, 2 * math.pi)
    flat = math.sqrt(1 - z * z)
    return [round(x, 4) for x in (flat * math.cos(turn), z, flat * math.sin(turn))]


def place(r, o, moves):
    """Turns, stretches and mirrors it about its own place."""
    maybe(r, 0.5, o, "rotate", lambda: {"axis": direction(r), "angle": round(r.uniform(-180, 180), 1)})
    maybe(r, 0.5, o, "scale", lambda: [round(r.choice((-1, 1)) * r.uniform(0.5, 1.5), 3) for _ in range(3)])
    o["translation"] = [round(r.uniform(-2, 2), 3), round(r.uniform(-0.5, 2), 3), round(r.uniform(-2, 1.5), 3)]
    if moves and r.random() < 0.4:
        keys = {k: o.pop(k) for k in ("rotate", "scale", "translation") if k in o}
        last = dict(keys, translation=[round(x + r.uniform(-0.6, 0.6), 3) for x in keys["translation"]])
        o["motion"] = [dict(keys, time=0), dict(last, time=1)]


def pyramid(r):
    """A closed mesh of eight triangles, smooth or not."""
    points = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    o = {"type": "mesh", "positions": [[0.8 * x for x in p] for p in points], "indices": faces}
    maybe(r, 0.5, o, "normals", lambda: points)
    return o


def bent(r, o):
    """Its corners move, and its normals with them."""
    far = [[round(x + r.uniform(-0.3, 0.3), 3) for x in p] for p in o["positions"]]
    o["vertexKeys"] = [{"time": 0, "positions": o["positions"]}, {"time": 1, "positions": far}]
    for key in o["vertexKeys"] if "normals" in o else []:
        key["normals"] = o["normals"]


def nested(r, o, moves):
    """Inside of a group, which is placed as well."""
    group = {"type": "group", "children": [o]}
    place(r, group, moves)
    return group


def cloud(r):
    return {"type": "mesh", "positions": [[round(r.uniform(-1, 1), 3) for _ in range(3)] for _ in range(20)],
            "pointRadius": round(r.uniform(0.05, 0.3), 3)}


def shape(r, kinds):
    kind = r.choice(kinds)
    if kind == "sphere":
        return {"type": "sphere", "center": [0, 0, 0], "radius": round(r.uniform(0.3, 0.9), 3)}
    if kind == "quad":
        return {"type": "quad", "center": [0, 0, 0], "u": [round(r.uniform(0.3, 1), 3), 0, 0], "v": [0, 0, round(r.uniform(0.3, 1), 3)]}
    return pyramid(r) if kind == "mesh" else cloud(r)


def light(r, folder):
    o = {"type": r.choice(("point", "spot", "directional", "sun", "environment"))}
    if o["type"] in ("point", "spot"):
        o.update(position=[round(r.uniform(-3, 3), 2), round(r.uniform(2, 4), 2), round(r.uniform(-2, 3), 2)],
                 intensity=round(r.uniform(1, 10), 2), color=color(r, 0.2, 1))
        maybe(r, 0.5, o, "radius", lambda: round(r.uniform(0.01, 0.4), 3))
        if o["type"] == "spot":
            o.update(target=[0, 0, 0], innerAngle=round(r.uniform(0, 20), 1), outerAngle=round(r.uniform(25, 60), 1))
    elif o["type"] == "environment":
        o.update(file="sky.pfm", rotation=round(r.uniform(0, 360)), intensity=round(r.uniform(0.2, 1), 2))
        write_sky(r, os.path.join(folder, "sky.pfm"))
    else:
        o.update(direction=[round(r.uniform(-1, 1), 2), -1, round(r.uniform(-1, 1), 2)], intensity=round(r.uniform(0.2, 1), 2))
        if o["type"] == "sun":
            o["angularDiameter"] = round(r.uniform(0.5, 20), 1)
    return o


def write_sky(r, path):
    """An image of 24 x 12 texels, one of them brighter than the others, some black."""
    import array
    width, height = 24, 12
    texels = array.array("f", (max(r.uniform(-0.2, 1), 0) for _ in range(3 * width * height)))
    at = 3 * r.randrange(width * height)
    for c in range(3):
        texels[at + c] = r.uniform(5, 30)
    with open(path, "wb") as file:
        file.write(f"PF\n{width} {height}\n-1.0\n".encode())
        file.write(texels.tobytes())


def make(seed, folder):
    r = random.Random(seed)
    moves = r.random() < 0.3
    camera = {"eye": [round(r.uniform(-3, 3), 2), round(r.uniform(0.5, 3), 2), round(r.uniform(4, 7), 2)],
              "target": [0, 0.5, 0], "fovy": round(r.uniform(25, 60))}
    if r.random() < 0.1:
        camera["orthographic"] = 4
        del camera["fovy"]
    elif r.random() < 0.3:
        camera.update(lensRadius=round(r.uniform(0.01, 0.3), 3), focusDistance=round(r.uniform(3, 8), 2))
        maybe(r, 0.5, camera, "blades", lambda: r.randint(3, 9))
    if r.random() < 0.2:
        camera["nearClip"] = round(r.uniform(0, 6), 2)
        maybe(r, 0.5, camera, "farClip", lambda: camera["nearClip"] + round(r.uniform(0.5, 5), 2))
    if moves:
        camera["shutter"] = [0, round(r.uniform(0.3, 1), 2)]
        if r.random() < 0.3:
            eye, target = camera.pop("eye"), camera.pop("target")
            camera["motion"] = [{"time": t, "eye": [round(x + t * r.uniform(-0.5, 0.5), 2) for x in eye],
                                 "target": target} for t in (0, 1)]
    materials = {"floor": {"kd": color(r, 0.1, 0.8)}}
    objects = [{"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": "floor"}]
    glass = r.random() < 0.5
    for i in range(r.randint(2, 6)):
        kinds = ("sphere", "quad") if r.random() < 0.6 else ("mesh", "cloud")
        o = shape(r, kinds)
        kind = r.random()
        if kind < 0.15:
            material = lamp(r)
        elif kind < 0.4:
            material = classic(r)
        elif kind < 0.5 and glass and o["type"] == "sphere":
            material, glass = solid(r, True), False
        else:
            material = metallic(r, o["type"] != "mesh")
        materials[f"m{i}"] = material
        o["material"] = f"m{i}"
        if moves and "indices" in o and r.random() < 0.4:
            bent(r, o)
        place(r, o, moves)
        maybe(r, 0.1, o, "castsShadow", lambda: False)
        objects.append(nested(r, o, moves) if r.random() < 0.2 else o)
    if r.random() < 0.1:  # all of it under water
        materials["water"] = solid(r, False)
        objects.append({"type": "plane", "point": [0, 6, 0], "normal": [0, 1, 0], "material": "water"})
    scene = {"camera": camera, "image": {"width": 64, "height": 48, "integrator": "path", "maxDepth": r.randint(1, 10)},
             "materials": materials, "objects": objects, "lights": [light(r, folder) for _ in range(r.randint(0, 2))],
             "background": color(r, 0, 1) if r.random() < 0.6 else [0, 0, 0]}
    with open(os.path.join(folder, "scene.json"), "w", encoding="utf-8") as file:
        json.dump(scene, file, indent=1)


def judge(fathom, folder, seed, error):
    """The smallest p-value, or why there is none."""
    scene, result = os.path.join(folder, "scene.json"), os.path.join(folder, "result.json")
    run = subprocess.run([fathom, "validate", scene, "--light", "--light-error", str(error), "--seed", str(seed), "--json",
                          result, "-q"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if run.returncode not in (0, 1):
        said = run.stderr.strip().splitlines() or [f"the program ended with {run.returncode}"]
        return said[-1]
    with open(result, encoding="utf-8") as file:
        found = json.load(file)
    return found


def main(fathom, count="100", seed="1", error="0.004", keep="."):
    fathom, first, error, wrong, refused = os.path.abspath(fathom), int(seed), float(error), 0, 0
    level = 1 - (1 - LEVEL) ** (1 / int(count))
    for number in range(first, first + int(count)):
        with tempfile.TemporaryDirectory() as folder:
            make(number, folder)
            found = judge(fathom, folder, number, error)
            if isinstance(found, str):
                refused += 1
                print(f"scene {number} is refused: {found}", flush=True)
                continue
            if found["p"] >= level:
                continue
            again = judge(fathom, folder, number + 1000000, error / math.sqrt(8))
            wrong += again["p"] < level
            kept = os.path.join(keep, f"light-random-{number}")
            shutil.copytree(folder, kept, dirs_exist_ok=True)
            print(f"scene {number}: p {found['p']:.2g}, then {again['p']:.2g}, {again['difference']:+.1e} +- "
                  f"{again['standardError']:.1e}; kept in {kept}", flush=True)
    print(f"{wrong} of {int(count) - refused} scenes differ; {refused} were refused")
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
