"""Renders for scripts that compare builds of Fathom by noise and time. Needs python3-openimageio and python3-numpy."""

import itertools
import json
import pathlib
import resource
import subprocess
import sys
import tempfile

import OpenImageIO as oiio

numbers = itertools.count()  # OpenImageIO may keep what it has read under a name


def render(program, scene, seed, *options):
    """Returns the pixels of an image, and seconds of processor time."""
    image, before = scene.parent / f"{next(numbers)}.exr", resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    command = [program, "render", scene, "-o", image, "--exr-float", "--seed", str(seed), "--quiet", *options]
    subprocess.run(command, check=True)
    return oiio.ImageBuf(str(image)).get_pixels()[:, :, :3], resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def table(usage, what, rows, measure, digits):
    """Prints a row for each of `rows`, by title: (scene, file, pixels, type). measure(program, scene): noise and seconds."""
    programs = [pathlib.Path(p).resolve() for p in sys.argv[1:]] or sys.exit(usage)
    print(f"|{what}" + "|noise|s" * len(programs) + "|")
    print("|-" * (1 + 2 * len(programs)) + "|")
    with tempfile.TemporaryDirectory() as name:
        scene = pathlib.Path(name) / "scene.json"
        for title, (made, file, pixels, kind) in rows.items():
            oiio.ImageBuf(pixels).write(str(scene.parent / file), kind)
            scene.write_text(json.dumps(made))
            cells = (measure(p, scene) for p in programs)
            print(f"|{title}" + "".join(f"|{noise:.{digits}f}|{seconds:.2f}" for noise, seconds in cells) + "|", flush=True)
