"""Noise and time of a floor lit by surfaces whose emission is an image, by one or more builds of Fathom.

usage: /usr/bin/python3 screens.py PROGRAM...

Prints a table for bench/path_tracing.md: for each lamp the noise of a sample relative to the mean, from two seeds, and seconds of
processor time. Needs python3-openimageio and python3-numpy."""

import numpy as np

from noise import render, table

SIDE, SAMPLES = 1024, 64


def windows():
    """A tenth of 20 x 20 windows is lit, as of a building at night."""
    image, random = np.zeros((SIDE, SIDE, 3), np.float32), np.random.default_rng(1)
    for row, column in np.argwhere(random.random((20, 20)) < 0.1) * 50:
        image[row + 20 : row + 45, column + 20 : column + 40] = 1, 0.8, 0.5
    return image


def corner():
    """A dim screen with a bright window in a corner."""
    image = np.full((SIDE, SIDE, 3), 0.02, np.float32)
    image[: SIDE // 8, : SIDE // 8] = 1
    return image


def stripes():
    image = np.zeros((SIDE, SIDE, 3), np.float32)
    image[SIDE // 3 : SIDE // 2, ::2] = 1
    return image


QUAD = {"type": "quad", "center": [0, 1.5, -1], "u": [1.5, 0, 0], "v": [0, 1, 0], "material": "lamp"}
BALL = {"type": "sphere", "center": [0, 1, -1], "radius": 0.5, "material": "lamp"}
LAMPS = {
    "a facade with lit windows, a quad": (windows, QUAD),
    "a dim screen with a bright corner, a quad": (corner, QUAD),
    "an even screen, a quad": (lambda: np.full((SIDE, SIDE, 3), 0.5, np.float32), QUAD),
    "a lantern with stripes, a sphere": (stripes, BALL),
}


def scene(lamp):
    glow = {"model": "metallicRoughness", "baseColor": [0, 0, 0], "emissive": [1, 1, 1], "emissiveStrength": 8}
    return {
        "image": {"width": 128, "height": 128, "maxDepth": 4},
        "camera": {"eye": [0, 3, 4], "target": [0, 0, 1], "fovy": 20},
        "background": [0, 0, 0],
        "lights": [],
        "materials": {"floor": {"kd": [0.5, 0.5, 0.5]}, "lamp": {**glow, "emissiveTexture": {"file": "lamp.png"}}},
        "objects": [{"type": "quad", "center": [0, 0, 0], "u": [5, 0, 0], "v": [0, 0, -5], "material": "floor"}, lamp],
    }


def measure(program, scene):
    options = "--spp", str(SAMPLES), "--threads", "1"
    (one, first), (two, second) = (render(program, scene, seed, *options) for seed in (1, 2))
    one, two = one[:, :, 1], two[:, :, 1]
    return np.sqrt(np.mean((one - two) ** 2) / 2) / one.mean() * SAMPLES**0.5, min(first, second)


rows = {title: (scene(shape), "lamp.png", image(), "uint8") for title, (image, shape) in LAMPS.items()}
table(__doc__, "lamp", rows, measure, 2)
