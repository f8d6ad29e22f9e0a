"""Random scenes (light_random.py) with a sheet of N x N cells: in images.json by images of N x N texels, taken by the nearest
one; in cells.json each cell is a mesh with a material of its own, whose numbers this script takes from the texels. Images of
normals and directions have one texel there, in another frame (textured_frames.py), and one of heights has its place from the
texture coordinates alone."""
import copy
import json
import math
import os
import random
import struct
import zlib

import light_random
import textured_frames

N = 4  # cells along each side

COLORS = {"baseColor", "emissive", "specularColor", "sheenColor", "diffuseTransmissionColor", "kd", "ks", "ke"}
CLASSIC = ["kd", "ks", "ke", "shininess"]
METALLIC = ["baseColor", "metallic", "roughness", "emissive", "transmission", "specular", "specularColor", "clearcoat",
            "clearcoatRoughness", "sheenColor", "sheenRoughness", "iridescence", "diffuseTransmission",
            "diffuseTransmissionColor", "opacity"]
DEFAULT = {"baseColor": [1, 1, 1], "specularColor": [1, 1, 1], "diffuseTransmissionColor": [1, 1, 1], "roughness": 0.5, "specular": 1,
           "opacity": 1, "kd": [0.5, 0.5, 0.5], "shininess": 32}


class Image:
    """Texels, N x N of chance or one, as a file of 8 bits or of floats."""

    def __init__(self, r, folder, name, texel=None):
        self.side = 1 if texel else N
        self.texels = [[texel or [r.randrange(256) for _ in range(3)] for _ in range(self.side)] for _ in range(self.side)]
        self.bytes = r.random() < 0.7
        self.name = name + (".png" if self.bytes else ".pfm")
        with open(os.path.join(folder, self.name), "wb") as file:
            file.write(self.png() if self.bytes else self.pfm())

    def png(self):
        def chunk(kind, data):
            return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        rows = b"".join(b"\0" + bytes(x for texel in row for x in texel) for row in self.texels)
        return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", self.side, self.side, 8, 2, 0, 0, 0))
                + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))

    def pfm(self):
        rows = [x / 255 for row in reversed(self.texels) for texel in row for x in texel]
        return f"PF\n{self.side} {self.side}\n-1.0\n".encode() + struct.pack(f"<{len(rows)}f", *rows)

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

    def place(self, uvs):
        """Where these coordinates lie in the image."""
        uv = uvs[self.keys.get("uvSet", 0)]
        return [a * uv[0] + b * uv[1] + c for (a, b), c in zip(textured_frames.matrix(self.keys), self.keys.get("offset", (0, 0)))]

    def at(self, uvs):
        """Three numbers at the middle of a cell, whose coordinates these are."""
        u, v = self.place(uvs)
        space = self.keys.get("colorSpace", "srgb" if self.colored and self.image.bytes else "linear")
        return self.image.at(wrapped(u, self.keys.get("wrapU", "repeat")), wrapped(v, self.keys.get("wrapV", "repeat")), space)

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
        self.is_quad = r.random() < 0.2
        # How tangents come about: with the mesh, for smooth vertices, or from how an image lies on flat or bent triangles.
        self.way = "flat" if self.is_quad else r.choice(("given", "made", "flat", "bent"))
        self.smooth = self.way in ("given", "made")
        self.tangents = (1, r.choice((-1, 1))) if self.way == "given" else None
        high = r.choice((0, 0.3)) if self.way == "given" else 0.3 if self.way == "bent" else 0
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

    def mesh(self, cells, whole, tangents):
        """Of these cells; each has corners of its own."""
        corners = [(i + x, j + y) for i, j in cells for x, y in ((0, 0), (0, 1), (1, 1), (1, 0))]
        o = {"type": "mesh", "positions": [self.positions[at] for at in corners],
             "indices": [[4 * k + a, 4 * k + b, 4 * k + c] for k in range(len(cells)) for a, b, c in ((0, 1, 2), (0, 2, 3))],
             "uvs": [self.uvs[0](*at) for at in corners], "uvs1": [self.uvs[1](*at) for at in corners]}
        if self.smooth or tangents:
            o["normals"] = [self.normals[at] if self.smooth else [0, 1, 0] for at in corners]
        if tangents:
            o["tangents"] = [[tangents[0], 0, 0, tangents[1]] for _ in corners]
        if whole and self.colors:
            o["colors"] = [self.colors[at] for at in cells for _ in range(4)]
        if whole and self.opacities:
            o["opacities"] = [[self.opacities[at]] for at in cells for _ in range(4)]
        return o

    def quad(self, left, top, side):
        half = side / N
        return {"type": "quad", "center": [2 * left / N - 1 + half, 0, 2 * top / N - 1 + half], "u": [half, 0, 0], "v": [0, 0, -half]}

    def whole(self, cells):
        return self.quad(0, 0, N) if self.is_quad else self.mesh(cells, True, self.tangents)

    def cell(self, at, tangents):
        return self.quad(*at, 1) if self.is_quad else self.mesh([at], False, tangents)

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
    if r.random() < 0.3 and "model" in m:
        textures.pop("metallic", None), textures.pop("roughness", None)
        textures["metallicRoughness"] = Texture(r, Image(r, folder, "both"), True)
        textures["metallicRoughness"].keys["colorSpace"] = "linear"
    for key in (textured_frames.DIRECTED if "model" in m else ("normal",)) + ("bump",):
        if r.random() < 0.25:
            textures[key] = Texture(r, Image(r, folder, key), key != "bump")
            textures[key].keys["colorSpace"] = "linear"
            if sheet.way == "given" or "bump" in textures:
                textures[key].keys.pop("uvSet", None)
    if "bump" in textures:
        textures["bump"].keys["filter"] = r.choice(("nearest", "linear", "trilinear"))
        for key in textured_frames.DIRECTED:  # cells need the second uv set
            textures[key].keys.pop("uvSet", None) if key in textures else None
    for texture in textures.values() if sheet.is_quad else ():
        texture.keys.pop("uvSet", None)
    return textures


def bump(o, m, texture, at, sheet):
    """Gives a cell the image of heights, whose place is in the texture coordinates, or that of a quad."""
    keys = {k: v for k, v in texture.keys.items() if k not in ("scale", "rotation", "offset")}
    if sheet.is_quad:
        offset = texture.place([[x / N for x in at]])
        keys.update(offset=offset, rotation=texture.keys.get("rotation", 0), scale=[x / N for x in texture.keys.get("scale", (1, 1))])
    else:
        o["uvs1"] = [texture.place(uvs) for uvs in zip(o["uvs"], o["uvs1"])]
        keys["uvSet"] = 1
    m["bumpTexture"] = keys


def of_cell(r, m, textures, sheet, at, tangents, folder):
    """The material that has the texels' numbers."""
    m, uvs = copy.deepcopy(m), sheet.middle(*at)
    directed = {key: textures[key] for key in textured_frames.DIRECTED if key in textures}
    texels = {key: texture.at(uvs) for key, texture in directed.items()}

    def save(texel):
        return Image(r, folder, f"cell-{at[0]}-{at[1]}-{r.random()}", [round(x * 255) for x in texel]).name
    for key, texture in textures.items():
        if key in directed or key == "bump":
            continue
        if key == "metallicRoughness":
            texel = texture.at(uvs)
            m["metallic"] = m.get("metallic", 0) * texel[2]
            m["roughness"] = m.get("roughness", 0.5) * texel[1]
            continue
        zero = [0, 0, 0] if texture.colored else 0
        m[key] = texture.applied(m.get(key, DEFAULT.get(key, zero)), uvs)
    color = "baseColor" if "model" in m else "kd"
    if sheet.colors:
        m[color] = multiplied(m.get(color, DEFAULT[color]), sheet.colors[at])
    if sheet.opacities:  # after images, of which one may be inverted
        m["opacity"] = m.get("opacity", 1) * sheet.opacities[at]
    textured_frames.put(r, m, {key: t.keys for key, t in directed.items()}, texels, sheet, tangents, "bump" not in textures, save)
    return m


def scales(r, m, textures):
    """Factors that have a meaning with these images."""
    for key, texture, most in (("normalScale", "normal", 2), ("clearcoatNormalScale", "clearcoatNormal", 2), ("bumpScale", "bump", 0.2)):
        if texture in textures:
            m[key] = round(r.uniform(-most, most), 3)
    if "anisotropy" in textures:
        m["anisotropy"] = round(r.random(), 3)


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
    scales(r, m, textures)
    cells = [(i, j) for i in range(N) for j in range(N)]
    group = {"type": "group"}
    light_random.place(r, group, "shutter" in scene["camera"])
    placed = not sheet.is_quad and "motion" not in group and r.random() < 0.5
    if placed and sheet.smooth and "scale" in group:  # a stretch mixes normals otherwise
        group["scale"] = [math.copysign(group["scale"][0], x) for x in group["scale"]]
    images, plain = copy.deepcopy(scene), scene
    images["materials"]["sheet"] = dict(m, **{k + "Texture": t.keys for k, t in textures.items()})
    images["objects"].append(dict(group, children=[dict(sheet.whole(cells), material="sheet")]))
    for at in cells:
        given = sheet.tangents or (sheet.way == "flat" and not sheet.is_quad and "bump" not in textures and r.random() < 0.5)
        tangents = (r.choice((-1, 1)), r.choice((-1, 1))) if given else None
        o = sheet.cell(at, tangents)
        plain["materials"][f"cell {at}"] = of_cell(r, m, textures, sheet, at, tangents, folder)
        if "bump" in textures:
            bump(o, plain["materials"][f"cell {at}"], textures["bump"], at, sheet)
        if placed:
            o = textured_frames.place(o, textured_frames.placement(group))
        o["material"] = f"cell {at}"
        plain["objects"].append(o if placed else dict(group, children=[o]))
    for name, content in (("images", images), ("cells", plain)):
        with open(os.path.join(folder, name + ".json"), "w", encoding="utf-8") as file:
            json.dump(content, file, indent=1)
