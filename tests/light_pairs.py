"""Path tracing against the reference integrator: every small scene of scenes/ by both, compared by Welch's test of means
of cells, corrected for all of them (Šidák). Prints a row for each scene: the difference of all light in parts of it, its
standard error, and the p-value over the scene's cells. Scenes that the reference refuses are named.
usage: python3 tests/light_pairs.py FATHOM [ERROR] [TEXT]
  ERROR  the relative standard error to aim at, by some 4 / ERROR^2 samples (0.003)
  TEXT   only scenes whose names hold it
Exit code 1: a scene differs, one run in 500 by chance."""
import json
import os
import shutil
import subprocess
import sys
import tempfile

LEVEL = 0.002
here = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def scenes(text):
    for folder in ("tour", "light", "."):
        for name in sorted(os.listdir(os.path.join(here, "scenes", folder))):
            if name.endswith(".json") and name != "fathom.schema.json" and text in name:
                yield os.path.normpath(os.path.join(folder, name))


def prepare(path):
    with open(path, encoding="utf-8") as file:
        scene = json.load(file)
    image = scene.setdefault("image", {})
    image["integrator"] = "path"
    image["maxDepth"] = min(image.get("maxDepth", 16), 16)
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)


def compare(fathom, path, error, result):
    run = subprocess.run([fathom, "validate", path, "--light", "--light-error", error, "--json", result, "-q"],
                         stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if run.returncode not in (0, 1):
        said = run.stderr.strip().splitlines() or [f"the program ended with {run.returncode}"]
        return said[-1].split(": ", 2)[-1]
    with open(result, encoding="utf-8") as file:
        return json.load(file)


def main(fathom, error="0.003", text=""):
    fathom, names, worst = os.path.abspath(fathom), list(scenes(text)), {}
    print("| scene | path less reference | ± | p |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as work:
        shutil.copytree(os.path.join(here, "scenes"), os.path.join(work, "scenes"))
        for name in names:
            path = os.path.join(work, "scenes", name)
            prepare(path)
            found = compare(fathom, path, error, os.path.join(work, "result.json"))
            if isinstance(found, str):
                print(f"| {name} | refused: {found} | | |", flush=True)
                continue
            worst[name] = found["p"]
            print(f"| {name} | {found['difference']:+.1e} | {found['standardError']:.1e} | {found['p']:.2g} |", flush=True)
    level = 1 - (1 - LEVEL) ** (1 / max(len(worst), 1))
    differ = [name for name, p in worst.items() if p < level]
    print(f"\n{len(differ)} of {len(worst)} scenes differ, below a p-value of {level:.1g}: {', '.join(differ) or 'none'}")
    return 1 if differ else 0


if len(sys.argv) < 2:
    sys.exit(__doc__)
sys.exit(main(*sys.argv[1:]))
