#!/usr/bin/env python3
"""How far path tracing in a room is from Embree's bare calls: python3 bench/room.py PROGRAM [MESH [REPEATS]]

Puts a mesh (default: a sphere of 70,000 triangles with bumps) into a Cornell box of quads, has `fathom bench render` record the
rays of 512 x 512 pixels, 16 samples, one thread, and ask them again by Embree's calls alone, and prints a row for
bench/path_tracing.md.
"""
import json
import os
import subprocess
import sys
import tempfile


def quad(corners, material):
    return {"type": "quad", "corners": corners, "material": material}


def room(mesh, bounds):
    """The box is 2 wide, high and deep; the mesh stands on the floor, and its longest side is 1.2."""
    lower, upper = bounds["lower"], bounds["upper"]
    scale = 1.2 / max(b - a for a, b in zip(lower, upper))
    middle = [(a + b) / 2 for a, b in zip(lower, upper)]
    place = [-scale * middle[0], -scale * lower[1], -scale * middle[2]]
    colors = {"white": [0.73, 0.73, 0.73], "red": [0.65, 0.05, 0.05], "green": [0.12, 0.45, 0.15]}
    materials = {name: {"kd": kd} for name, kd in colors.items()}
    materials["lamp"] = {"kd": [0, 0, 0], "ke": [15, 12, 8]}
    return {
        "image": {"width": 512, "height": 512, "integrator": "path"},
        "camera": {"eye": [0, 1, 3.9], "target": [0, 1, 0], "fovy": 39},
        "materials": materials,
        "objects": [
            quad([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], "white"),
            quad([[-1, 2, -1], [1, 2, -1], [1, 2, 1], [-1, 2, 1]], "white"),
            quad([[-1, 0, -1], [1, 0, -1], [1, 2, -1], [-1, 2, -1]], "white"),
            quad([[-1, 0, 1], [-1, 0, -1], [-1, 2, -1], [-1, 2, 1]], "red"),
            quad([[1, 0, -1], [1, 0, 1], [1, 2, 1], [1, 2, -1]], "green"),
            quad([[-0.3, 1.99, -0.3], [0.3, 1.99, -0.3], [0.3, 1.99, 0.3], [-0.3, 1.99, 0.3]], "lamp"),
            {"type": "mesh", "file": mesh, "material": "white", "scale": [scale] * 3, "translation": place},
        ],
    }


def main():
    program = os.path.abspath(sys.argv[1])
    repeats = sys.argv[3] if len(sys.argv) > 3 else "9"
    with tempfile.TemporaryDirectory() as folder:
        mesh = os.path.abspath(sys.argv[2]) if len(sys.argv) > 2 else os.path.join(folder, "sphere.ply")
        if len(sys.argv) < 3:
            subprocess.run([program, "generate", "sphere", "--triangles", "70k", "-o", mesh, "-q"], check=True)
        info = json.loads(subprocess.check_output([program, "info", mesh, "--json"]))
        scene, out = os.path.join(folder, "room.json"), os.path.join(folder, "out.json")
        with open(scene, "w", encoding="utf-8") as file:
            json.dump(room(mesh, info["bounds"]), file)
        subprocess.run([program, "bench", "render", scene, "--integrator", "path", "--threads", "1", "--spp", "16",
                        "--repeats", repeats, "-q", "--json", out, "--allow-outside"], check=True)
        with open(out, encoding="utf-8") as file:
            run = json.load(file)["runs"][0]
    ceiling = run["ceiling"]
    traced, render = ceiling["tracedToBare"], ceiling["renderToBare"]
    print("| mesh | triangles | bare calls, s | through the tracer | render phase (quartiles) |")
    print("|---|---|---|---|---|")
    print(f"| {os.path.basename(mesh)} | {run['triangles']:,} | {ceiling['bareCpuSeconds']['median']:.2f} "
          f"| {traced['median']:.3f} | {render['median']:.3f} ({render['low']:.3f}–{render['high']:.3f}) |")


main()
