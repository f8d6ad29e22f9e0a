"""The images of some scenes of scenes.py by glTF's own formulas, without any renderer: one bounce of light from lights
without size, seen by a camera on the z axis. Each pixel is the mean of 16 × 16 jittered points."""
import numpy as np

from gltf import bumps

POINTS = 16
dot = lambda a, b: (a * b).sum(-1, keepdims=True)
unit = lambda a: a / np.linalg.norm(a, axis=-1, keepdims=True)


def rays(size, yfov):
    width, height = size
    x, y = np.meshgrid(np.arange(width * POINTS), np.arange(height * POINTS))
    x, y = np.stack([x, y]) / POINTS + np.random.RandomState(1).random((2, *x.shape)) / POINTS
    scale = np.tan(yfov / 2) / height
    return unit(np.stack([(2 * x - width) * scale, (height - 2 * y) * scale, -np.ones_like(x)], -1))


def pixels(values):
    height, width = values.shape[0] // POINTS, values.shape[1] // POINTS
    return values.reshape(height, POINTS, width, POINTS, 3).mean((1, 3))


def on_quad(d, distance, size):
    """Points of the quad in z = 0, and whether there is one."""
    p = d * (-distance / d[..., 2:]) + [0, 0, distance]
    return p, (np.abs(p[..., :2]) <= size / 2).all(-1, keepdims=True)


def texels(image, u, v):
    """Between texels, repeated."""
    size = len(image)
    x, y = u * size - 0.5, v * size - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    at = lambda a, b: np.float64(image[b % size, a % size])
    s, t = (x - i)[..., None], (y - j)[..., None]
    return (at(i, j) * (1 - s) + at(i + 1, j) * s) * (1 - t) + (at(i, j + 1) * (1 - s) + at(i + 1, j + 1) * s) * t


def normal_tangents(size):
    """"Normal textures": n = normalize(2 rgb - 1), lit by Lambert's cosine."""
    d = rays(size, 0.6)
    p, there = on_quad(d, 4, 2)
    n = unit(texels(bumps(), (p[..., 0] + 1) / 2, (1 - p[..., 1]) / 2) / 255 * 2 - 1)
    towards = -unit(np.float64([0.6, -0.5, -0.6]))
    return pixels(there * np.maximum(dot(n, towards), 0) * 0.8 / np.pi * 2.0 * np.ones(3))


def spot(size, place, axis, cone, color):
    """KHR_lights_punctual: intensity over the square of the distance, times the falloff of its reference code."""
    p, there = on_quad(rays(size, 0.6), 4, 4)
    to = place - p
    away = np.linalg.norm(to, axis=-1, keepdims=True)
    inner, outer = np.cos(cone[0]), np.cos(cone[1])
    falloff = np.clip((dot(-to / away, unit(np.float64(axis))) - outer) / (inner - outer), 0, 1) ** 2
    return pixels(there * 0.8 / np.pi * 10 * np.float64(color) * falloff * to[..., 2:] / away ** 3)


def highlight(size, metallic, roughness, color):
    """Appendix B on a sphere of radius 1 at distance 6, lit by 3 lux."""
    d = rays(size, 0.4)
    eye = np.float64([0, 0, 6])
    b = dot(d, eye)
    root = b * b - dot(eye, eye) + 1
    n = eye + d * (-b - np.sqrt(np.maximum(root, 0)))
    v, l = -d, np.broadcast_to(-unit(np.float64([0.5, -0.4, -1])), d.shape)
    h = unit(l + v)
    nl, nv, nh, vh = np.maximum(dot(n, l), 0), np.abs(dot(n, v)), dot(n, h), np.abs(dot(v, h))
    a2 = roughness ** 4
    visible = 0.5 / (nv * np.sqrt(a2 + (1 - a2) * nl * nl) + nl * np.sqrt(a2 + (1 - a2) * nv * nv) + 1e-300)
    specular = visible * a2 / (np.pi * (nh * nh * (a2 - 1) + 1) ** 2)
    w = (1 - vh) ** 5
    color = np.float64(color)
    fresnel = 0.04 + 0.96 * w
    dielectric = color / np.pi * (1 - fresnel) + specular * fresnel
    f = dielectric * (1 - metallic) + metallic * (color + (1 - color) * w) * specular
    return pixels((root > 0) * f * nl * 3.0)


known = {
    "normal-tangents": normal_tangents,
    "light-spot-hard": lambda s: spot(s, np.float64([0, 0.5, 2]), (0, -0.1, -1), (0.29, 0.3), (1, 0.9, 0.8)),
    "light-spot-soft": lambda s: spot(s, np.float64([0, 0, 2]), (0, 0, -1), (0.1, 0.5), (1, 0.9, 0.8)),
    "highlight-metal": lambda s: highlight(s, 1, 0.3, (0.6, 0.3, 0.1)),
    "highlight-dielectric": lambda s: highlight(s, 0, 0.3, (0.6, 0.3, 0.1)),
}
