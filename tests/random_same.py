"""Changes scenes made by chance (light_random.py, and each second one with textures, textured_scene.py) in ways that must not
change a bit of their images: all lengths times a power of two, all light likewise and the exposure against it, written as JSON
by `convert`, rendered by other threads, tiles and blocks of rays, with further outputs, cropped, and in parts that are merged.
Prints a line for each image that differs, and where its scene was kept.
usage: python3 tests/random_same.py FATHOM [COUNT [SEED [FOLDER]]]
  COUNT   scenes (100)
  SEED    of the first; each further scene has the next (1)
  FOLDER  where scenes that differ are kept (.)
Exit code 1: an image differs, or a scene is refused."""
import copy
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile

import exr
import light_random
import textured_scene

OF_LENGTH = {"eye", "target", "position", "translation", "center", "u", "v", "point", "radius", "lensRadius", "focusDistance",
             "orthographic", "nearClip", "farClip", "positions", "pointRadius", "attenuationDistance", "thickness", "bumpScale"}
OF_LIGHT = {"intensity", "ke", "emissive", "background"}


def times(value, factor):
    return [times(x, factor) for x in value] if isinstance(value, list) else value * factor


def scaled(value, keys, factor):
    """A copy in which what stands under these keys is multiplied, wherever it is."""
    if isinstance(value, list):
        return [scaled(x, keys, factor) for x in value]
    if not isinstance(value, dict):
        return value
    return {k: times(v, factor) if k in keys else scaled(v, keys, factor) for k, v in value.items()}


def in_other_units(scene, r):
    """What falls off with the distance gets more intensity."""
    factor = 2.0 ** r.randint(-12, 12)
    out = scaled(scene, OF_LENGTH, factor)
    for light in out["lights"]:
        if light["type"] in ("point", "spot"):
            light["intensity"] *= factor * factor
    return out, []


def brighter(scene, r):
    stops = r.randint(-20, 20)
    return scaled(scene, OF_LIGHT, 2.0 ** stops), ["--exposure", str(-stops)]


def cut_otherwise(scene, r):
    return copy.deepcopy(scene), ["--threads", str(r.choice((1, 2, 3))), "--tile-size", str(r.choice((32, 64))),
                                  "--block-width", str(r.choice((1, 4, 8, 16)))]


SAMPLES = ["--spp", "16", "-q"]
LAYERS = ["--aov", "all"]
LAWS = {"units": in_other_units, "light": brighter, "cut": cut_otherwise}


def ask(*command):
    run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    return run.returncode, (run.stdout + run.stderr).strip()


def render(fathom, scene, name, options):
    """As name.exr and name.png, which shows the scene as bright as it is unless the options say otherwise."""
    if "--exposure" not in options:
        options = [*options, "--exposure", "0"]
    code, said = ask(fathom, "render", scene, "-o", name + ".exr", "-o", name + ".png", *SAMPLES, "--exr-float", *options)
    return said if code else None


def write(scene, path):
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file, indent=1)
    return path


def compare(fathom, scene, options, folder):
    """What differs from the first image, or None. 8 bits where the exposure counts, which an .exr does not hold."""
    first, second = os.path.join(folder, "first"), os.path.join(folder, "second")
    ending = ".png" if "--exposure" in options else ".exr"
    refused = render(fathom, scene, second, options)
    if refused:
        return refused
    code, said = ask(fathom, "compare", first + ending, second + ending)
    return said if code else None


def differing(whole, part):
    """The first row and channel of a part of an image that differs, or None."""
    (left, top, width, height), rows = part
    for row in range(top, top + height):
        for name, values in rows[row].items():
            if values != whole[1][row][name][4 * left:4 * (left + width)]:
                return f"{name} in row {row} of {left},{top},{left + width},{top + height}"
    return None


def compare_crop(fathom, scene, r, folder):
    """A part of the image by itself: other points share a block, and others a wave."""
    whole = exr.read(os.path.join(folder, "layers.exr"))
    _, _, width, height = whole[0]
    x, y = r.randrange(width - 2), r.randrange(height - 2)
    crop = x, y, r.randint(x + 1, width), r.randint(y + 1, height)
    refused = render(fathom, scene, os.path.join(folder, "crop"), [*LAYERS, "--crop", ",".join(map(str, crop))])
    return refused or differing(whole, exr.read(os.path.join(folder, "crop.exr")))


def compare_parts(fathom, scene, r, folder):
    """Shares of the work, each rendered by itself, and merged."""
    count = r.choice((2, 3, 5))
    parts = [os.path.join(folder, f"{k}.part") for k in range(1, count + 1)]
    merged = os.path.join(folder, "merged.exr")
    for k, part in enumerate(parts, 1):
        code, said = ask(fathom, "render", scene, "-o", part, "--part", f"{k}/{count}", *SAMPLES, *LAYERS)
        if code:
            return said
    code, said = ask(fathom, "merge", *parts, "-o", merged, "--exr-float", "-q")
    return said if code else differing(exr.read(os.path.join(folder, "layers.exr")), exr.read(merged))


def compare_layers(fathom, scene, r, folder):
    """With further outputs the image is the same, and so are they in parts."""
    refused = render(fathom, scene, os.path.join(folder, "layers"), LAYERS)
    if refused:
        return {"layers": refused}
    layers, first = (exr.read(os.path.join(folder, name)) for name in ("layers.exr", "first.exr"))
    return {"layers": differing(layers, first), "crop": compare_crop(fathom, scene, r, folder),
            "parts": compare_parts(fathom, scene, r, folder)}


def judge(fathom, number, folder):
    """Laws that do not hold, and what was said of each."""
    textured = number % 2 == 0
    (textured_scene if textured else light_random).make(number, folder)
    path, r = os.path.join(folder, "images.json" if textured else "scene.json"), random.Random(number)
    refused = render(fathom, path, os.path.join(folder, "first"), [])
    if refused:
        return {"scene": refused}
    with open(path, encoding="utf-8") as file:
        scene = json.load(file)
    found = {}
    for name, law in LAWS.items():
        other, options = law(scene, r)
        found[name] = compare(fathom, write(other, os.path.join(folder, name + ".json")), options, folder)
    found.update(compare_layers(fathom, path, r, folder))
    converted = os.path.join(folder, "converted.json")
    code, said = ask(fathom, "convert", path, converted, "-q")
    found["converted"] = said if code else compare(fathom, converted, [], folder)
    return {name: said for name, said in found.items() if said}


def main(fathom, count="100", seed="1", keep="."):
    fathom, wrong = os.path.abspath(fathom), 0
    for number in range(int(seed), int(seed) + int(count)):
        with tempfile.TemporaryDirectory() as folder:
            found = judge(fathom, number, folder)
            if not found:
                continue
            wrong += 1
            kept = os.path.join(keep, f"random-same-{number}")
            shutil.copytree(folder, kept, dirs_exist_ok=True)
            for name, said in found.items():
                print(f"scene {number}, {name}: {said.splitlines()[-1]}; kept in {kept}", flush=True)
    print(f"{wrong} of {count} scenes have images that differ")
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
