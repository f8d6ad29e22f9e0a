"""Makes the meshes and the images of still-life.json, all by rule: make.py FOLDER. Needs Debian's python3-numpy and
python3-pil. Lengths are in decimetres; the table's top is at y = 0."""
import os
import shutil
import sys

import numpy as np

import paint
import shape

HERE = os.path.dirname(os.path.abspath(__file__))


def vase():
    """Thick-walled: the outer side from the lip to the foot, then the inner side on its own."""
    outer = [(0.47, 2.62), (0.42, 2.5), (0.36, 2.3), (0.42, 2.0), (0.66, 1.6), (0.8, 1.2), (0.76, 0.8), (0.58, 0.4),
             (0.48, 0.15), (0.5, 0.04), (0.47, 0)]
    inner = [(0, 0.1), (0.4, 0.2), (0.5, 0.4), (0.72, 1.2), (0.34, 2.0), (0.29, 2.3), (0.35, 2.5), (0.41, 2.61),
             (0.44, 2.64), (0.47, 2.62)]
    return shape.lathe(shape.spline(outer)), shape.lathe(shape.spline(inner))


def tumbler():
    """A closed glass, and the water in it, which overlaps the glass a little."""
    glass = [(0, 0), (0.33, 0), (0.36, 0.03), (0.37, 0.08), (0.43, 1.1), (0.425, 1.13), (0.41, 1.13), (0.40, 1.1),
             (0.345, 0.2), (0.33, 0.15), (0.3, 0.13), (0, 0.12)]
    water = [(0, 0.115), (0.31, 0.125), (0.34, 0.16), (0.355, 0.2), (0.395, 0.78), (0.392, 0.79), (0.37, 0.775),
             (0.34, 0.77), (0, 0.77)]
    # These profiles run up on the outer side.
    return tuple(shape.lathe(shape.spline(p, 8)[::-1], 96) for p in (glass, water))


def bowl():
    outer = [(1.32, 0.72), (1.3, 0.745), (1.27, 0.75), (1.2, 0.62), (0.95, 0.3), (0.6, 0.13), (0.58, 0.02), (0.55, 0),
             (0.5, 0.02), (0.48, 0.1), (0, 0.12)]
    inner = [(0, 0.16), (0.5, 0.18), (0.9, 0.34), (1.16, 0.62), (1.25, 0.76), (1.285, 0.775), (1.32, 0.765),
             (1.32, 0.72)]
    return shape.lathe(shape.spline(inner + outer[1:]))


def orange(seed):
    """Radius about 0.4; the stalk's dimple is at the top."""
    angle = np.linspace(0, np.pi, 97)
    r = 0.4 * (1 - 0.10 * np.exp(-((angle / 0.2) ** 2)) - 0.05 * np.exp(-(((np.pi - angle) / 0.2) ** 2)))
    fruit = shape.lathe(np.stack([r * np.sin(angle), 0.95 * r * np.cos(angle)], 1), 128)
    rng = np.random.default_rng(seed)
    lean, size = rng.normal(size=(2, 3)), 0.035
    for k in range(2):
        fruit.points *= (1 + size * np.sin(2.1 * fruit.points @ lean[k] * 2 + k))[:, None]
    stalk = shape.lathe(np.array([(0, 0.375), (0.03, 0.37), (0.045, 0.35), (0.05, 0.325)]), 12)
    return fruit, stalk


def twig(rng):
    """A branch out of the vase, and its leaves."""
    stems, leaves = [], []
    for lean, turn, tall in ((0.25, 0.4, 1.5), (0.85, 2.7, 1.25), (0.45, 4.4, 1.35), (1.2, 5.8, 1.05), (0.7, 1.5, 1.2)):
        away = np.array([np.cos(turn), 0, 0.75 * np.sin(turn)])
        points = [0.05 * away + (0, 0.6, 0), 0.14 * away + (0, 1.7, 0), 0.22 * away + (0, 2.5, 0)]
        for t in np.linspace(0.2, 1, 5):
            points.append(points[2] + (0, tall * t, 0) + away * (lean * tall * t**1.5) + 0.03 * rng.normal(size=3))
        path = shape.spline(points, 12)
        stems.append(shape.tube(path, np.linspace(0.035, 0.012, len(path))))
        for k, at in enumerate(np.linspace(0.55, 0.985, 14)):
            i = int(at * (len(path) - 1))
            along = path[min(i + 1, len(path) - 1)] - path[i - 1]
            along = along / np.linalg.norm(along)
            angle = 2.4 * k + rng.normal(0, 0.25)
            side = np.array([np.cos(angle), 0, np.sin(angle)])
            side = side - along * (side @ along)
            grow = along * (0.45 + 0.6 * at) + side * (1.25 - 0.4 * at) + np.array([0, -0.1, 0])
            length = rng.uniform(0.55, 0.75) * (1.12 - 0.35 * at)
            blade = shape.leaf(length, 0.5 * length, rng.uniform(0.5, 1.1), rng.uniform(0.1, 0.35))
            roll = np.pi / 2 - angle + rng.normal(0, 0.35)
            turned = shape.toward(grow, roll)
            if turned[1, 2] < 0:  # leaves turn their fronts to the light
                turned = shape.toward(grow, roll + np.pi)
            leaves.append(blade.moved(turned, path[i]))
    return shape.together(stems), shape.together(leaves)


def cloth():
    """A runner under the bowl that hangs over the table's front edge, 2.1 in front of the middle."""
    s, t = np.meshgrid(np.linspace(-1, 1, 201), np.linspace(0, 1, 401))
    front, way, radius = 2.1, 5.6 * t - 2.2, 0.09
    bent = np.clip((way - front) / (radius * np.pi / 2), 0, 1) * np.pi / 2
    down = np.maximum(way - front - radius * np.pi / 2, 0)
    ripple = 0.028 * np.sin(2.3 * way + 1.5 * s) * np.sin(1.7 * s + 0.6 * way) + 0.018 * np.sin(5.1 * s - 1.9 * way)
    fold = 0.06 * np.sin(5.2 * s + 0.7 * down) * np.minimum(down / 1.2, 1)
    calm = np.clip((np.hypot(s * 1.0, way + 0.35) - 0.7) / 0.8, 0, 1)
    rise = 0.012 + (np.abs(ripple) * 0.9 + np.maximum(ripple, 0)) * calm
    points = np.stack([1.0 * s + 0.05 * np.sin(1.3 * way), -radius * (1 - np.cos(bent)) - down,
                       np.minimum(way, front) + radius * np.sin(bent) + fold], -1)
    normal = np.stack([0 * bent, np.cos(bent), np.sin(bent)], -1)
    points += rise[..., None] * normal
    return shape.sheet(points, np.stack([way / 2.2, (s + 1) / 2], -1))


def book():
    """Closed and flat: two boards, a back on the left, and pages. The front board's top has the cover's image."""
    boards = [shape.block((1.5, 0.045, 2.0), 0.015).moved(by=(0, y, 0)) for y in (0.023, 0.377)]
    spine = shape.block((0.06, 0.35, 2.0), 0.025).moved(by=(-0.74, 0.2, 0))
    u, v = np.meshgrid([0.0, 1.0], [0.0, 1.0])
    front = shape.sheet(np.stack([1.46 * (u - 0.5), 0.401 + 0 * u, 1.96 * (v - 0.5)], -1), np.stack([u, v], -1))
    paper = shape.block((1.42, 0.312, 1.9), 0.005).moved(by=(-0.01, 0.2, 0))
    return shape.together(boards + [spine]), front, paper


def main(folder):
    os.makedirs(folder, exist_ok=True)
    path = lambda name: os.path.join(folder, name)
    paint.all_images(path)
    made = {"vase vase_inside": vase(), "glass water": tumbler(), "bowl": [bowl()], "orange stalk": orange(3),
            "stems leaves": twig(np.random.default_rng(2)), "cloth": [cloth()], "boards front paper": book()}
    for names, meshes in made.items():
        for name, mesh in zip(names.split(), meshes, strict=True):
            mesh.save(path(name + ".ply"))
    shutil.copy(os.path.join(HERE, "still-life.json"), folder)


if __name__ == "__main__":
    main(sys.argv[1])
