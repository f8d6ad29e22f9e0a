"""Textures against materials cell by cell: both scenes of textured_scene.py must have the same light in each of 8 x 6 regions.
Prints a line for each scene that differs or is refused, and where it was kept. Needs python3-numpy, python3-openimageio.
usage: python3 tests/textured_random.py FATHOM [COUNT [SEED [FOLDER]]]
  COUNT   scenes (100)
  SEED    of the first; each further scene has the next (1)
  FOLDER  where scenes that differ are kept (.)
Exit code 1: a scene differs, one run in 1,000 by chance."""
import os
import shutil
import subprocess
import sys
import tempfile

import numpy
import OpenImageIO

import textured_scene

RUNS = 32  # renders of each scene, by other seeds
# Student's t with 31 degrees of freedom is beyond this in 7e-8 of cases: of 144 values in each of 100 scenes, one in 1,000.
LIMIT = 7.0
# Both scenes take the same random numbers, so that most paths are the same but for rounding: a standard error counts as at least
# 16 roundoffs of the brightest region's light. The few that rounding sends elsewhere are too rare for Student's t at first: one
# scene of 16 is then rendered again.
LEAST = 2.0 ** -20


def regions(fathom, folder, name, seed, samples):
    """The mean of each of 8 x 6 regions and three channels."""
    image = os.path.join(folder, "out.exr")
    run = subprocess.run([fathom, "render", os.path.join(folder, name + ".json"), "-o", image, "--spp", str(samples), "--seed",
                          str(seed), "--exr-float", "-q"], stderr=subprocess.PIPE, text=True, check=False)
    if run.returncode:
        raise ValueError(f"{name}: " + (run.stderr.strip().splitlines() or [f"ended with {run.returncode}"])[-1])
    pixels = OpenImageIO.ImageInput.open(image).read_image(OpenImageIO.FLOAT)[:, :, :3]
    return pixels.reshape(6, 8, 8, 8, 3).mean(axis=(1, 3))


def judge(fathom, folder, first, samples):
    """The largest Student's t of all regions, and by how much the whole image differs."""
    both = [numpy.array([regions(fathom, folder, name, first + k, samples) for k in range(RUNS)], dtype=float)
            for name in ("images", "cells")]
    difference = both[0] - both[1]
    least = LEAST * max(max(x.mean(axis=0).max() for x in both), 1e-30)
    error = numpy.sqrt(difference.var(axis=0, ddof=1) / RUNS + least * least)
    whole = difference.mean() / max(both[1].mean(), 1e-30)
    return (numpy.abs(difference.mean(axis=0)) / error).max(), whole


def main(fathom, count="100", seed="1", keep="."):
    fathom, wrong, refused = os.path.abspath(fathom), 0, 0
    for number in range(int(seed), int(seed) + int(count)):
        with tempfile.TemporaryDirectory() as folder:
            textured_scene.make(number, folder)
            try:
                t, whole = judge(fathom, folder, 1, 16)
                if t < LIMIT:
                    continue
                again, whole = judge(fathom, folder, 1 + RUNS, 128)
            except ValueError as error:
                refused += 1
                print(f"scene {number} is refused: {error}", flush=True)
                continue
            wrong += again > LIMIT
            kept = os.path.join(keep, f"textured-random-{number}")
            shutil.copytree(folder, kept, dirs_exist_ok=True)
            print(f"scene {number}: t {t:.1f}, then {again:.1f}, {whole:+.1e} of the light; kept in {kept}", flush=True)
    print(f"{wrong} of {int(count) - refused} scenes differ; {refused} were refused")
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
