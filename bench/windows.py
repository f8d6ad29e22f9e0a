"""Noise and time of a room that a sky lights through a window, by one or more builds of Fathom.

usage: /usr/bin/python3 windows.py PROGRAM...

Prints a table for bench/path_tracing.md: for each room the relative noise of the median pixel, from two seeds, and seconds of
processor time. Needs python3-openimageio and python3-numpy."""

import numpy as np

from noise import render, table

WIDTH, HEIGHT, SAMPLES = 512, 256, 32


def sky(sun_azimuth):
    """Blue to the zenith, a dim ground, and a sun of half a degree at 30 degrees; azimuth in turns from the window's view."""
    v, u = np.mgrid[0.5:HEIGHT, 0.5:WIDTH] / np.array([HEIGHT, WIDTH])[:, None, None]
    image = np.where(v[..., None] < 0.5, np.array([0.6, 0.8, 1.2]) * (2 - 2 * v[..., None]), [0.1, 0.08, 0.06])
    sun = (abs(v - 1 / 3) < 0.7 / HEIGHT) & (abs(u - 0.25 - sun_azimuth) < 0.7 / WIDTH)
    image[sun] += np.array([1, 0.9, 0.7]) * 1e4
    return image.astype(np.float32)


def quad(center, u, v, material):
    return {"type": "quad", "center": center, "u": u, "v": v, "material": material}


def room(pane=False, lamp=0, even=False, sun=0):
    """6 x 2.8 x 8 with a window of 2.4 x 1.3 on the left."""
    shapes = [quad([0, -1.4, 0], [3, 0, 0], [0, 0, -4], "floor")]
    shapes += [quad([0, 1.4, 0], [3, 0, 0], [0, 0, 4], "wall"), quad([0, 0, -4], [3, 0, 0], [0, 1.4, 0], "wall")]
    shapes += [quad([0, 0, 4], [-3, 0, 0], [0, 1.4, 0], "wall"), quad([3, 0, 0], [0, 0, 4], [0, 1.4, 0], "wall")]
    for z, y, deep, high in ((-2.6, 0, 1.4, 1.4), (2.6, 0, 1.4, 1.4), (0, -0.9, 1.2, 0.5), (0, 1.15, 1.2, 0.25)):
        shapes.append(quad([-3, y, z], [0, 0, deep], [0, -high, 0], "wall"))
    if pane:
        shapes.append(quad([-3, 0.25, 0], [0, 0, 1.2], [0, -0.65, 0], "pane"))
    if lamp:
        shapes.append(quad([0, 1.39, -1.5], [0.3, 0, 0], [0, 0, 0.3], "lamp"))
    for x, z, material in ((-1.6, -1, "gold"), (1.6, -0.2, "plastic"), (0.2, -1.5, "wall")):
        shapes.append({"type": "sphere", "center": [x, -0.9, z], "radius": 0.5, "material": material})
    model = {"model": "metallicRoughness", "roughness": 0.3, "metallic": 0}
    lights = [] if even else [{"type": "environment", "file": "sky.exr"}]
    if sun:
        lights.append({"type": "directional", "direction": [0.8, -0.5, -0.1], "intensity": sun})
    outside = {"background": [0.6, 0.8, 1.2]} if even else {}
    return outside | ({"lights": lights} if lights else {}) | {
        "image": {"width": 320, "height": 200, "maxDepth": 12},
        "camera": {"eye": [0.6, 0.1, 3.8], "target": [-0.3, -0.25, -1], "fovy": 55},
        "materials": {
            "floor": {**model, "baseColor": [0.35, 0.22, 0.12]},
            "wall": {"kd": [0.7, 0.7, 0.7]},
            "gold": {**model, "baseColor": [0.9, 0.7, 0.3], "metallic": 1},
            "plastic": {**model, "baseColor": [0.1, 0.2, 0.7]},
            "pane": {**model, "roughness": 0, "transmission": 1},
            "lamp": {"kd": [0, 0, 0], "ke": [lamp, lamp, lamp]},
        },
        "objects": shapes,
    }


ROOMS = {
    "the sun behind the house": (0.5, room()),
    "the same, with a clear pane": (0.5, room(pane=True)),
    "the sun shines in": (0, room()),
    "a dim lamp": (0.5, room(lamp=1)),
    "a lamp": (0.5, room(lamp=10)),
    "a bright lamp": (0.5, room(lamp=100)),
    "a dim directional light through the window": (0.5, room(sun=1)),
    "an even background": (0, room(even=True)),
    "the same, and a dim lamp": (0, room(lamp=1, even=True)),
    "and a lamp": (0, room(lamp=10, even=True)),
    "and a bright lamp": (0, room(lamp=100, even=True)),
    "and a dim directional light": (0, room(even=True, sun=1)),
}


def measure(program, scene):
    (one, first), (two, second) = (render(program, scene, seed, "--spp", str(SAMPLES)) for seed in (1, 2))
    one, two = one.mean(axis=2), two.mean(axis=2)
    off = abs(one - two) / np.maximum((one + two) / 2, 1e-6) / 2**0.5
    return np.median(off) / 0.6745, min(first, second)  # the median of a normal distribution's absolute value


rows = {title: (made, "sky.exr", sky(azimuth), "float") for title, (azimuth, made) in ROOMS.items()}
table(__doc__, "room", rows, measure, 3)
