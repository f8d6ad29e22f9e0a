"""Energy and noise of balls of rough glass in an even sky, by one or more builds of Fathom.

usage: /usr/bin/python3 rough_glass.py PROGRAM...

Prints a table for bench/README.md: for each ball the mean of its middle, which is 1 if no light is lost, and the standard
deviation of one sample relative to that mean. Needs python3-openimageio and python3-numpy."""

import json
import pathlib
import subprocess
import sys
import tempfile

import OpenImageIO as oiio

BALLS = {
    "glass": {},
    "green glass": {"baseColor": [0.5, 0.9, 0.5]},
    "dispersion 1": {"dispersion": 1},
    "transmission 0.8": {"transmission": 0.8},
    "metallic 0.3": {"metallic": 0.3},
    "anisotropy 0.6": {"anisotropy": 0.6},
    "film of 400 nm on white": {"iridescence": 1, "transmission": 0},
}
ROUGHNESSES = 0.1, 0.3, 0.5, 0.7, 1
SAMPLES = 256


def scene(roughness, extra):
    material = {"model": "metallicRoughness", "baseColor": [1, 1, 1], "roughness": roughness, "transmission": 1, "thickness": 1}
    return {
        "camera": {"eye": [0, 0, 6], "target": [0, 0, 0], "fovy": 4},
        "image": {"width": 64, "height": 64, "maxDepth": 64},
        "background": [1, 1, 1],
        "materials": {"ball": {**material, **extra}},
        "objects": [{"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "ball"}],
    }


def measure(program, file, image):
    command = [program, "render", file, "-o", image, "--spp", str(SAMPLES), "--exposure", "0", "--quiet"]
    subprocess.run(command, check=True)
    green = oiio.ImageBuf(str(image)).get_pixels()[:, :, 1]
    return green.mean(), green.std() / green.mean() * SAMPLES**0.5


def main():
    programs = sys.argv[1:] or sys.exit(__doc__)
    print("|ball|roughness" + "|mean|noise" * len(programs) + "|")
    print("|-" * (2 + 2 * len(programs)) + "|")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for k, (ball, extra) in enumerate(BALLS.items()):
            for roughness in ROUGHNESSES:
                file = folder / "ball.json"
                file.write_text(json.dumps(scene(roughness, extra)))
                found = [measure(p, file, folder / f"{k}-{roughness}-{i}.exr") for i, p in enumerate(programs)]
                print(f"|{ball}|{roughness}" + "".join(f"|{mean:.3f}|{noise:.2f}" for mean, noise in found) + "|", flush=True)


main()
