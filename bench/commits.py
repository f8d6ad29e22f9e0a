"""Times two builds of Fathom on the same scenes, to see what a change costs scenes that do not need it.

usage: commits.py [--rounds N] [--options "OPTIONS OF THE SECOND BUILD"] PROGRAM PROGRAM SCENE:SAMPLES...

Prints a table for bench/README.md: processor seconds in user mode of the whole program on one thread, the least of all
rounds (default 15), the median of the rounds' ratios with their quartiles, and how many pixels differ. The builds take
turns at being first. A scene is read by both builds: take its file from the older one's sources, and give what has another
default since then by --options."""

import argparse
import os
import pathlib
import resource
import statistics
import subprocess
import tempfile


def seconds(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def differing(program, a, b):
    said = subprocess.run([program, "compare", a, b], capture_output=True, text=True, check=False).stdout
    return said.strip().splitlines()[-1].split(", ")[-1]


def measure(programs, options, scene, samples, rounds, folder):
    images = [str(folder / f"{i}.exr") for i in range(2)]
    commands = [[program, "render", scene, "-o", image, "--spp", samples, "--threads", "1", "-q", *own]
                for program, image, own in zip(programs, images, ([], options))]
    times = ([], [])
    for k in range(rounds):
        for i in ((0, 1), (1, 0))[k % 2]:
            times[i].append(seconds(commands[i]))
    ratios = [new / old for old, new in zip(*times)]
    low, middle, high = statistics.quantiles(ratios, n=4) if rounds > 1 else ratios * 3
    print(f"|`{pathlib.Path(scene).stem}`, {samples} samples|{min(times[0]):.3f}|{min(times[1]):.3f}|"
          f"{middle:.3f} ({low:.3f}–{high:.3f})|{differing(programs[1], *images)}|", flush=True)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--options", default="")
    parser.add_argument("programs", nargs=2, type=os.path.abspath)
    parser.add_argument("scenes", nargs="+")
    asked = parser.parse_args()
    print("|scene|first, s|second, s|ratio|pixels|\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for scene in asked.scenes:
            file, samples = scene.rsplit(":", 1)
            measure(asked.programs, asked.options.split(), file, samples, asked.rounds, pathlib.Path(folder))


if __name__ == "__main__":
    main()
