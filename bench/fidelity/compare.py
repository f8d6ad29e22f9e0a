"""Compares what two renderers made of the scenes of fidelity.sh: python3 compare.py SCENES.json OURS THEIRS SHEET.png
SEED... prints a table and writes a contact sheet: Fathom, Blender, and eight times their difference around grey.

A difference is a share of the mean of Blender's image. "Channels" are the means of red, green and blue, with the
standard error of the largest and the p-value of no difference at all by Welch's t-test over seeds, Bonferroni-corrected
for three channels. "Pixels" is the mean of the absolute differences, "noise" the part of it that samples make alone:
the same mean with the halves of each renderer's seeds taken from each other, which has the same variance."""
import json
import math
import os
import sys

import numpy as np
import OpenImageIO as oiio

from spec import known as formulas

listed, ours, theirs, sheet, *seeds = sys.argv[1:]


def image(path):
    pixels = oiio.ImageBuf(path).get_pixels(oiio.FLOAT)
    if pixels is None or pixels.size < 3:
        raise SystemExit(f"fidelity: {path}: cannot be read as an image")
    return np.float64(pixels[..., :3])


def images(folder, name):
    return np.stack([image(os.path.join(folder, f"{name}-{seed}.exr")) for seed in seeds])


def p_value(t, freedom):
    """Of Student's t, two-sided: the density's integral by Simpson's rule over x = tan."""
    if not freedom > 0 or not math.isfinite(t):
        return float("nan") if not freedom > 0 else 0.0
    x = np.linspace(math.atan(abs(t) / math.sqrt(freedom)), math.pi / 2, 4001)
    y = np.cos(x) ** (freedom - 1)
    weights = np.full(4001, 2.0)
    weights[1::2], weights[[0, -1]] = 4, 1
    whole = math.sqrt(math.pi) * math.exp(math.lgamma(freedom / 2) - math.lgamma((freedom + 1) / 2))
    return min(1.0, 2 * (weights @ y) * (x[1] - x[0]) / 3 / whole)


def welch(a, b):
    """Difference of the means, its standard error and p, of values a seed."""
    va, vb, n = a.var(ddof=1) / len(a), b.var(ddof=1) / len(b), len(a) - 1
    error = math.sqrt(va + vb)
    difference = a.mean() - b.mean()
    if error == 0:
        return difference, 0, 1.0 if difference == 0 else 0.0
    return difference, error, p_value(difference / error, (va + vb) ** 2 / ((va ** 2 + vb ** 2) / n))


def row(a, b):
    scale = b.mean()
    half = len(seeds) // 2
    means = [welch(a[..., c].mean((1, 2)), b[..., c].mean((1, 2))) for c in range(3)]
    worst = max(means, key=lambda m: abs(m[0]))
    apart = lambda x: (x[:half].sum(0) - x[half:2 * half].sum(0)) / (2 * half)
    pixels = np.abs(a.mean(0) - b.mean(0)).mean() / scale
    noise = np.abs(apart(a) - apart(b)).mean() / scale
    return [m[0] / scale for m in means], worst[1] / scale, min(1, 3 * min(m[2] for m in means)), pixels, noise


def display(x):
    x = np.clip(x, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def strip(a, b):
    """Three pictures next to each other in a frame of one size."""
    out = np.full((140, 3 * 140, 3), 0.1)
    for k, x in enumerate((display(a), display(b), 0.5 + 8 * (a - b) / max(b.mean(), 1e-6) / 2)):
        out[2:2 + x.shape[0], k * 140 + 2:k * 140 + 2 + x.shape[1]] = np.clip(x, 0, 1)
    return out


print("| | scene | red, % | green, % | blue, % | ± | p | pixels, % | noise, % |")
print("|---|---|---|---|---|---|---|---|---|")
strips, judged = [], []
for k, s in enumerate(json.load(open(listed))):
    if not os.path.exists(os.path.join(ours, f"{s['name']}-{seeds[0]}.exr")):
        print(f"| {k + 1} | {s['name']} | not rendered by Fathom | | | | | | |")
        continue
    a, b = images(ours, s["name"]), images(theirs, s["name"])
    means, error, p, pixels, noise = row(a, b)
    mark = "**" if max(map(abs, means)) > 0.01 or pixels - noise > 0.01 else ""
    print(f"| {k + 1} | {mark}{s['name']}{mark} | " + " | ".join(f"{100 * m:+.2f}" for m in means)
          + f" | {100 * error:.2f} | {p:.2g} | {100 * pixels:.2f} | {100 * noise:.2f} |")
    strips.append(strip(a.mean(0), b.mean(0)))
    if s["name"] in formulas:
        truth = formulas[s["name"]](s["size"])
        apart = lambda x: f"{100 * (x.mean() - truth.mean()) / truth.mean():+.2f} | " \
                          f"{100 * np.abs(x.mean(0) - truth).mean() / truth.mean():.2f}"
        judged.append(f"| {s['name']} | {apart(a)} | {apart(b)} |")
print("\n| against glTF's formulas | Fathom, mean, % | pixels, % | Blender, mean, % | pixels, % |\n|---|---|---|---|---|")
print("\n".join(judged))
strips += [np.zeros_like(strips[0])] * (-len(strips) % 4)
page = np.concatenate([np.concatenate(strips[i:i + 4], 1) for i in range(0, len(strips), 4)])
out = oiio.ImageBuf(oiio.ImageSpec(page.shape[1], page.shape[0], 3, "uint8"))
out.set_pixels(oiio.ROI(), np.float32(page))
out.write(sheet)
