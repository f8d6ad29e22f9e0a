"""Random scenes (light_random.py) with a sheet of N x N cells: in images.json by images of N x N texels, taken by the nearest
one; in cells.json each cell is a mesh with a material of its own, whose numbers this script takes from the texels."""
import copy
import json
import math
import os
import random
import struct
import zlib

import light_random

N = 4  # cells along each side

COLORS = {"baseColor", "emissive", "specularColor", "sheenColor", "diffuseTransmissionColor", "kd", "ks", "ke"}
CLASSIC = ["kd", "ks", "ke", "shininess"]
METALLIC = ["baseColor", "metallic", "roughness", "emissive", "transmission", "specular", "specularColor", "clearcoat",
            "clearcoatRoughness", "sheenColor", "sheenRoughness", "iridescence", "diffuseTransmission",
            "diffuseTransmissionColor", "opacity"]
DEFAULT = {"baseColor": [1, 1, 1], "specularColor": [1, 1, 1], "diffuseTransmissionColor": [1, 1, 1], "roughness": 0.5, "specular": 1,
           "opacity": 1, "kd": [0.5, 0.5, 0.5], "shininess": 32}


class Image:
    """N x N texels of chance, as a file of 8 bits or of floats."""

    def __init__(self, r, folder, name):
        self.texels = [[[r.randrange(256) for _ in range(3)] for _ in range(N)] for _ in range(N)]
        self.bytes = r.random() < 0.7
        self.name = name + (".png" if self.bytes else ".pfm")
        with open(os.path.join(folder, self.name), "wb") as file:
            file.write(self.png() if self.bytes else self.pfm())

    def png(self):
        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        rows = b"".join(b"\0" + bytes(x for texel in row for x in texel) for row in self.texels)
        return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", N, N, 8, 2, 0, 0, 0))
                + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))

    def pfm(self):
        rows = [x / 255 for row in reversed(self.texels) for texel in row for x in texel]
        return f"PF\n{N} {N}\n-1.0\n".encode() + struct.pack(f"<{len(rows)}f", *rows)

    def at(self, column, row, space):
        texel = [x / 255 for x in self.texels[row][column]]
        return [linear(x) for x in texel] if space == "srgb" else texel


def linear(x):
    return x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4


def wrapped(x, how):
    """The texel that a coordinate lies in."""
    x = math.floor(x * N)
    if how == "clamp":
        return min(max(x, 0), N - 1)
    x %= 2 * N if how == "mirror" else N
    return 2 * N - 1 - x if x >= N else x


class Texture:
    """An image as a material looks it up; turns and scales keep cells on texels."""

    def __init__(self, r, image, colored, may_invert=False):
        self.image = image
        self.keys = {"file": image.name, "filter": "nearest"}
        light_random.maybe(r, 0.3, self.keys, "scale", lambda: [r.choice((-1, 1)), r.choice((-1, 1))])
        light_random.maybe(r, 0.3, self.keys, "rotation", lambda: r.choice((90, 180, 270, -90)))
        light_random.maybe(r, 0.3, self.keys, "offset", lambda: [r.randint(-9, 9) / N, r.randint(-9, 9) / N])
        for key in ("wrapU", "wrapV"):
            light_random.maybe(r, 0.5, self.keys, key, lambda: r.choice(("repeat", "mirror", "clamp")))
        light_random.maybe(r, 0.3, self.keys, "uvSet", lambda: 1)
        if not colored:
            light_random.maybe(r, 0.5, self.keys, "channel", lambda: r.choice("rgb"))
        light_random.maybe(r, 0.4, self.keys, "colorSpace", lambda: r.choice(("srgb", "linear")))
        if may_invert:
            light_random.maybe(r, 0.3, self.keys, "inverted", lambda: True)
        self.colored = colored

    def at(self, uvs):
        """Three numbers at the middle of a cell, whose coordinates these are."""
        u, v = uvs[self.keys.get("uvSet", 0)]
        sx, sy = self.keys.get("scale", (1, 1))
        turn = math.radians(self.keys.get("rotation", 0))
        u, v = u * sx, v * sy
        u, v = u * math.cos(turn) + v * math.sin(turn), v * math.cos(turn) - u * math.sin(turn)
        ox, oy = self.keys.get("offset", (0, 0))
        space = self.keys.get("colorSpace", "srgb" if self.colored and self.image.bytes else "linear")
        return self.image.at(wrapped(u + ox, self.keys.get("wrapU", "repeat")), wrapped(v + oy, self.keys.get("wrapV", "repeat")), space)

    def factor(self, uvs):
        texel = self.at(uvs)
        return texel if self.colored else texel["rgb".index(self.keys.get("channel", "r"))]

    def applied(self, value, uvs):
        if "inverted" in self.keys:
            return 1 - (1 - value) * self.factor(uvs)
        return multiplied(value, self.factor(uvs))


def multiplied(value, factor):
    return [a * b for a, b in zip(value, factor)] if isinstance(value, list) else value * factor


class Sheet:
    """A mesh, bent and smooth or flat, which may have colours of vertices; or a quad."""

    def __init__(self, r):
        high = r.choice((0, 0.3))
        self.is_quad = r.random() < 0.2
        self.smooth = r.random() < 0.5
        self.positions = {(i, j): [i / N * 2 - 1, round(r.uniform(-high, high), 3), j / N * 2 - 1]
                          for i in range(N + 1) for j in range(N + 1)}
        self.normals = {at: light_random.direction(r)[:1] + [2] + light_random.direction(r)[2:] for at in self.positions}
        shift = [r.randint(-3, 3), r.randint(-3, 3)]
        self.uvs = [lambda i, j: [i / N, j / N], lambda i, j: [(j + shift[0]) / N, (shift[1] - i) / N]]
        self.colors = self.opacities = None
        if not self.is_quad and r.random() < 0.3:
            self.colors = {(i, j): light_random.color(r) for i in range(N) for j in range(N)}
        if self.colors and r.random() < 0.5:
            self.opacities = {(i, j): round(r.random(), 3) for i in range(N) for j in range(N)}

    def mesh(self, cells, whole):
        """Of these cells; each has corners of its own."""
        corners = [(i + x, j + y) for i, j in cells for x, y in ((0, 0), (0, 1), (1, 1), (1, 0))]
        o = {"type": "mesh", "positions": [self.positions[at] for at in corners],
             "indices": [[4 * k + a, 4 * k + b, 4 * k + c] for k in range(len(cells)) for a, b, c in ((0, 1, 2), (0, 2, 3))],
             "uvs": [self.uvs[0](*at) for at in corners], "uvs1": [self.uvs[1](*at) for at in corners]}
        if self.smooth:  # tangents, because those that are made are means over a mesh
            o.update(normals=[self.normals[at] for at in corners], tangents=[[1, 0, 0, 1] for _ in corners])
        if whole and self.colors:
            o["colors"] = [self.colors[at] for at in cells for _ in range(4)]
        if whole and self.opacities:
            o["opacities"] = [[self.opacities[at]] for at in cells for _ in range(4)]
        return o

    def quad(self, left, top, side):
        half = side / N
        return {"type": "quad", "center": [2 * left / N - 1 + half, 0, 2 * top / N - 1 + half], "u": [half, 0, 0], "v": [0, 0, -half]}

    def whole(self, cells):
        return self.quad(0, 0, N) if self.is_quad else self.mesh(cells, True)

    def cell(self, at):
        return self.quad(*at, 1) if self.is_quad else self.mesh([at], False)

    def middle(self, i, j):
        return [of(i + 0.5, j + 0.5) for of in self.uvs]


def covering(r):
    """A material for a sheet, which is no volume."""
    m = light_random.classic(r) if r.random() < 0.25 else light_random.metallic(r, True)
    if "model" in m:
        light_random.maybe(r, 0.3, m, "emissive", lambda: light_random.color(r, 0, 3))
        light_random.maybe(r, 0.5, m, "opacityCutoff", lambda: 0.5) if "opacity" in m else None
    else:
        light_random.maybe(r, 0.3, m, "ke", lambda: light_random.color(r, 0, 3))
    return m


def textured(r, m, sheet, folder):
    """Gives some parameters images."""
    textures = {}
    for key in METALLIC if "model" in m else CLASSIC:
        needless = key in ("ks", "shininess") and "ks" not in m or key == "shininess" and "specular" not in m
        if not needless and r.random() < (0.7 if key in m else 0.1):
            textures[key] = Texture(r, Image(r, folder, key), key in COLORS, "model" in m and key not in COLORS)
    if r.random() < 0.3:
        textures.pop("metallic", None), textures.pop("roughness", None)
        textures["metallicRoughness"] = Texture(r, Image(r, folder, "both"), True)
        textures["metallicRoughness"].keys["colorSpace"] = "linear"
    for texture in textures.values() if sheet.is_quad else ():
        texture.keys.pop("uvSet", None)
    return textures if "model" in m else {k: t for k, t in textures.items() if k in CLASSIC}


def of_cell(m, textures, sheet, at):
    """The material that has the texels' numbers."""
    m, uvs = copy.deepcopy(m), sheet.middle(*at)
    color = "baseColor" if "model" in m else "kd"
    if sheet.colors:
        m[color] = multiplied(m.get(color, DEFAULT[color]), sheet.colors[at])
    if sheet.opacities:
        m["opacity"] = m.get("opacity", 1) * sheet.opacities[at]
    for key, texture in textures.items():
        if key == "metallicRoughness":
            texel = texture.at(uvs)
            m["metallic"] = m.get("metallic", 0) * texel[2]
            m["roughness"] = m.get("roughness", 0.5) * texel[1]
            continue
        zero = [0, 0, 0] if texture.colored else 0
        m[key] = texture.applied(m.get(key, DEFAULT.get(key, zero)), uvs)
    return m


def make(seed, folder):
    """Writes images.json and cells.json."""
    light_random.make(seed, folder)
    with open(os.path.join(folder, "scene.json"), encoding="utf-8") as file:
        scene = json.load(file)
    r = random.Random(seed)
    sheet, m = Sheet(r), covering(r)
    if "model" not in m:
        sheet.opacities = None
    textures = textured(r, m, sheet, folder)
    cells = [(i, j) for i in range(N) for j in range(N)]
    group = {"type": "group"}
    light_random.place(r, group, "shutter" in scene["camera"])
    images, plain = copy.deepcopy(scene), scene
    images["materials"]["sheet"] = dict(m, **{k + "Texture": t.keys for k, t in textures.items()})
    images["objects"].append(dict(group, children=[dict(sheet.whole(cells), material="sheet")]))
    for at in cells:
        plain["materials"][f"cell {at}"] = of_cell(m, textures, sheet, at)
    plain["objects"].append(dict(group, children=[dict(sheet.cell(at), material=f"cell {at}") for at in cells]))
    for name, content in (("images", images), ("cells", plain)):
        with open(os.path.join(folder, name + ".json"), "w", encoding="utf-8") as file:
            json.dump(content, file, indent=1)
