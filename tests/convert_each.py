"""Converts small scenes that have one thing each: a parameter, an image and how it lies, a mesh, a light, a camera. The images
of both files agree but for rounding, or `convert` warns of something that it does not warn of without that thing.
Prints a line for each that differs silently.
usage: python3 tests/convert_each.py FATHOM [EVERY [FIRST [FOLDER]]]
  EVERY   takes one of so many scenes (1)
  FIRST   the number of the first (0)
  FOLDER  for files (a temporary one)
Exit code 1: an image differs silently, or a file is refused."""
import json
import os
import random
import re
import struct
import subprocess
import sys
import tempfile
import zlib

import exr

FORMATS = ("json", "glb", "obj")  # PLY keeps no materials, and says so
POINTS = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
FACES = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
FLOOR = {"type": "mesh", "positions": [[-3, -1, -3], [3, -1, -3], [3, -1, 3], [-3, -1, 3]], "indices": [[0, 2, 1], [0, 3, 2]],
         "material": "floor"}
PLACE = {"translation": [0.1, 0.2, 0.3], "rotate": {"axis": [1, 2, 3], "angle": 40}}
GLASS = {"transmission": 1, "thickness": 1, "roughness": 0.1}
LAMP = {"type": "point", "position": [2, 4, 3], "intensity": 20}
TANGENTS = [[0, 1, 0, 1], [0, 1, 0, 1], [1, 0, 0, -1], [1, 0, 0, -1], [0, 1, 0, 1], [1, 0, 0, -1]]
# Not the same by rounding, but by the same mean: it is lit by triangles, or its places are nodes of their own.
NOISY = {"a quad that shines", "instances with other materials"}
CAMERA = {"eye": [1.5, 1.25, 4], "target": [0, 0, 0], "fovy": 40}


def metal(**keys):
    return {"model": "metallicRoughness", "baseColor": [0.5, 0.75, 0.25], **keys}


def classic(**keys):
    return {"kd": [0.5, 0.25, 0.125], **keys}


def mesh(**keys):
    uvs = [[[(i * a) % 1.7 + b, (i * c) % 1.3] for i in range(6)] for a, b, c in ((0.37, 0, 0.61), (0.23, -0.3, 0.41))]
    o = {"type": "mesh", "positions": [[p[0] * 1.1 + 0.03, p[1] + 0.2, p[2]] for p in POINTS], "indices": FACES, "normals": POINTS,
         "uvs": uvs[0], "uvs1": uvs[1], "material": "m"}
    o.update(keys)
    return {k: v for k, v in o.items() if v is not None}


def scene(m=None, *objects, **keys):
    s = {"camera": CAMERA, "image": {}, "materials": {"m": metal() if m is None else m, "floor": metal(roughness=1)},
         "objects": [*(objects or [mesh()]), FLOOR], "lights": [LAMP]}
    s.update(keys)
    return {k: v for k, v in s.items() if v is not None}


# ---- one thing each ----

def parameters():
    """Of materials, each with what it needs to have an effect."""
    for keys in ({"metallic": 0.5}, {"roughness": 0.25}, {"emissive": [0.5, 0.25, 0.1]}, {"ior": 1.7}, {"ior": 0}, {"specular": 0.5},
                 {"specularColor": [0.5, 0.25, 1]}, {"transmission": 0.5}, {"clearcoat": 0.5}, {"sheenColor": [0.5, 0.25, 0.1]},
                 {"anisotropy": 0.5}, {"iridescence": 0.5}, {"diffuseTransmission": 0.5}, {"opacity": 0.5}, {"doubleSided": False},
                 {"multiscatter": False}, GLASS, {"emissive": [0.5, 0.25, 0.1], "emissiveStrength": 3.5}, {"emissive": [5, 2, 1]},
                 {"clearcoat": 1, "clearcoatRoughness": 0.3}, {"sheenColor": [1, 1, 1], "sheenRoughness": 0.4},
                 {"anisotropy": 0.9, "roughness": 0.3, "metallic": 1, "anisotropyRotation": 1.2}, {"iridescence": 1, "iridescenceIor": 1.9},
                 {"iridescence": 1, "iridescenceThicknessMax": 700}, {**GLASS, "dispersion": 2}, {**GLASS, "priority": 3},
                 {**GLASS, "attenuationColor": [0.3, 0.9, 0.4], "attenuationDistance": 0.5}, {"opacity": 0.6, "opacityCutoff": 0.5},
                 {"diffuseTransmission": 0.5, "diffuseTransmissionColor": [0.2, 0.4, 0.8]}, {"transmission": 1, "roughness": 0},
                 {"baseColor": [0, 0, 0], "specular": 0, "emissive": [0.5, 0.2, 0.1]}):
        yield f"metallicRoughness {keys}", scene(metal(**keys))
    shine = {"ks": [0.3, 0.2, 0.1], "specular": "blinn", "shininess": 20}
    for keys in ({}, shine, {**shine, "specular": "phong"}, {"kr": [0.3, 0.2, 0.1]}, {"kr": [0.3, 0.2, 0.1], "fresnel": True},
                 {"kr": [0.3, 0.2, 0.1], **shine}, {"kd": [0, 0, 0], "kt": [0.5, 0.7, 0.9], "ior": 1.3}, {"ke": [0.3, 0.1, 2]},
                 {"kd": [0, 0, 0], "kr": [1, 1, 1], "kt": [1, 1, 1], "fresnel": True}, {"kt": [0.5, 0.7, 0.9], "ior": 1},
                 {"kd": [0, 0, 0], "kt": [0.5, 0.7, 0.9], **shine}, {"kd": [0, 0, 0]}, {"litFromBehind": True}, {"kt": [1, 1, 1]}):
        yield f"classic {keys}", scene(classic(**keys))


IMAGES = {"baseColor": {}, "metallic": {"metallic": 1}, "roughness": {"roughness": 1}, "metallicRoughness": {"metallic": 1, "roughness": 1},
          "emissive": {"emissive": [1, 1, 1]}, "normal": {"normalScale": 0.7}, "bump": {"bumpScale": 0.1}, "transmission": {"transmission": 1},
          "specular": {}, "specularColor": {}, "clearcoat": {"clearcoat": 1}, "clearcoatNormal": {"clearcoat": 1, "clearcoatNormalScale": -0.4},
          "clearcoatRoughness": {"clearcoat": 1, "clearcoatRoughness": 1}, "sheenColor": {"sheenColor": [1, 1, 1]},
          "sheenRoughness": {"sheenColor": [1, 1, 1], "sheenRoughness": 1}, "anisotropy": {"anisotropy": 1, "roughness": 0.3},
          "iridescence": {"iridescence": 1}, "iridescenceThickness": {"iridescence": 1}, "diffuseTransmission": {"diffuseTransmission": 1},
          "diffuseTransmissionColor": {"diffuseTransmission": 1}, "opacity": {}}
CLASSIC = {"kd": {}, "ks": {"ks": [0.5, 0.5, 0.5], "specular": "blinn"}, "ke": {"ke": [1, 1, 1]}, "opacity": {}, "normal": {},
           "shininess": {"ks": [0.5, 0.5, 0.5], "specular": "blinn", "shininess": 100}, "bump": {"bumpScale": 0.2}}
CHANNELS = {"metallic": "b", "roughness": "g", "specular": "a", "clearcoatRoughness": "g", "sheenRoughness": "a",
            "iridescenceThickness": "g", "diffuseTransmission": "a", "opacity": "a"}  # of glTF; "r" otherwise
LIES = ({}, {"uvSet": 1}, {"scale": [2, -3]}, {"rotation": 30}, {"rotation": -50, "scale": [1.5, -0.7], "offset": [0.3, -0.2]},
        {"wrapU": "mirror", "wrapV": "clamp"}, {"wrapU": "clamp", "wrapV": "clamp"}, {"filter": "nearest"}, {"filter": "linear"},
        {"colorSpace": "srgb"}, {"colorSpace": "linear"}, {"offset": [0.25, 0.5]}, {"channel": "g"}, {"channel": "a"}, {"inverted": True})
COLORED = {"baseColor", "metallicRoughness", "emissive", "normal", "specularColor", "clearcoatNormal", "sheenColor", "anisotropy",
           "diffuseTransmissionColor", "kd", "ks", "ke"}


def images():
    for model, table in ((metal, IMAGES), (classic, CLASSIC)):
        for key, needed in table.items():
            for lies in LIES:
                if key in COLORED and ("channel" in lies or "inverted" in lies) or model == classic and "inverted" in lies:
                    continue
                texture = {"file": "rgb.png" if key in ("baseColor", "kd") else "rgba.png", **lies}
                if key in CHANNELS:
                    texture.setdefault("channel", CHANNELS[key])
                yield f"{key}Texture {lies}", scene(model(**needed, **{key + "Texture": texture}))
    both = {"baseColorTexture": {"file": "rgba.png"}, "opacityTexture": {"file": "rgba.png", "channel": "a"}}
    yield "colour and opacity", scene(metal(**both))
    yield "colour and cut opacity", scene(metal(opacityCutoff=0.5, **both))
    brushed = {"anisotropy": 0.9, "roughness": 0.3, "metallic": 1, "anisotropyRotation": 1.2}
    yield "an image on brushed metal", scene(metal(baseColorTexture={"file": "rgb.png"}, **brushed))
    yield "an image without coordinates", scene(metal(baseColorTexture={"file": "rgb.png"}), mesh(uvs=None, uvs1=None))
    yield "an image on a quad", scene(metal(baseColorTexture={"file": "rgb.png"}), {**QUAD, "material": "m"})


QUAD = {"type": "quad", "center": [0, 0, 0], "u": [1, 0, 0.5], "v": [0, 1, 0]}


def shapes():
    colors = {"colors": [[0.2 * i, 1 - 0.1 * i, 0.5] for i in range(6)]}
    far = {"positions": [[p[0] + 1e5, p[1], p[2]] for p in POINTS]}
    for name, keys in {"colours": colors, "opacities": {**colors, "opacities": [[0.1 * i + 0.2] for i in range(6)]},
                       "bright colours": {"colors": [[2, 1, 0.5]] * 6}, "facets": {"normals": None}, "no shadow": {"castsShadow": False},
                       "a name": {"name": 'a"b\\ü é/#'}, "a default material": {"material": None}, "a place": PLACE,
                       "a mirror image": {"scale": [-1, 1, 1]}, "a stretched place": {**PLACE, "scale": [0.7, 1.2, 0.9]}, "far": far,
                       "one key": {"motion": [{"time": 0, "translation": [0.3, 0, 0]}]}}.items():
        yield name, scene(None, mesh(**keys))
    image = metal(normalTexture={"file": "rgb.png"})
    yield "tangents", scene(image, mesh(tangents=TANGENTS))
    yield "tangents in a mirror image", scene(image, mesh(tangents=TANGENTS, scale=[-0.7, 1.2, 0.9]))
    yield "one side in a mirror image", scene(metal(doubleSided=False), mesh(scale=[-1, 1, 1], indices=FACES[:4]))
    odd = scene(None, mesh(material='m a"t\\ü#1'), mesh(material="material_1", translation=[1.5, 0, 0]))
    odd["materials"].update({'m a"t\\ü#1': metal(metallic=1), "material_1": metal(roughness=0.1)})
    yield "names of materials", odd
    instance = {"type": "instance", "of": "g e"}
    yield "instances", scene(None, {**instance, **PLACE}, {**instance, "translation": [0.8, 0.2, 0]}, groups={"g e": [mesh()]})
    yield "instances with other materials", scene(None, {**instance, **PLACE}, {**instance, "scale": [0.5, 0.5, -0.5], "material": "floor"},
                                                  groups={"g e": [mesh()]})
    yield "a group in a group", scene(None, {"type": "group", "name": "a b", **PLACE, "children": [
        mesh(), {"type": "group", "children": [mesh(translation=[1, 0, 0])], "scale": [0.5, 0.5, 0.5]}]})
    yield "points", scene(None, {"type": "mesh", "positions": [[0.3 * i, 0.1 * i, 0.05 * i * i] for i in range(-4, 5)], "pointRadius": 0.2})
    yield "a sphere", scene(None, {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "m"})
    yield "a quad that shines", scene({"ke": [3, 3, 3]}, {**QUAD, "material": "m"})
    yield "a plane", scene(None, mesh(), {"type": "plane", "point": [0, -1, 0], "normal": [0, 1, 0], "material": "floor"})
    moves = {**CAMERA, "shutter": [0, 1]}
    yield "motion", scene(None, mesh(motion=[{"time": 0}, {"time": 1, "translation": [1, 0, 0]}]), camera=moves)
    keys = [{"time": t, "positions": [[p[0] * (1 + t), p[1], p[2]] for p in POINTS], "normals": POINTS} for t in (0, 0.4)]
    yield "moving vertices", scene(None, mesh(vertexKeys=keys), camera=moves)


def surroundings():
    down = {"direction": [-1, -2, -0.5]}
    for light in ({"type": "spot", "position": [1, 3, 2], "target": [0, 0, 0], "innerAngle": 10, "outerAngle": 25, "color": [1, 0.5, 0.25]},
                  {"type": "spot", "position": [1, 3, 2], "direction": [-0.1, -1, -1], "outerAngle": 90}, {"type": "directional", **down},
                  {"type": "sun", **down, "angularDiameter": 5}, {**LAMP, "radius": 0.5}, {**LAMP, "intensity": 0}):
        yield f"light {light}", scene(lights=[light])
    yield "no lights", scene(lights=[])
    yield "a background", scene(background=[0.2, 0.3, 0.4])
    yield "an ambient light", scene(classic(ka=[0.2, 0.1, 0.1]), image={"integrator": "classic"}, ambient=[1, 1, 1])
    view = {"eye": CAMERA["eye"], "target": [0, 0, 0]}
    for camera in ({**CAMERA, "lensRadius": 0.1, "focusDistance": 3.5, "blades": 5}, {**view, "orthographic": 3}, {**CAMERA, "up": [1, 1, 0]},
                   {**CAMERA, "nearClip": 3.8, "farClip": 4.5},
                   {**view, "d": 1, "h": 0.9, "w": 0.9}, {"frame": {"origin": [0, 1, 5], "z": [0, 0.2, 1]}, "fovy": 35}, None,
                   {"motion": [{"time": 0, **view}, {"time": 1, **view, "eye": [2, 1, 4]}], "fovy": 40, "shutter": [0, 1]}):
        yield f"camera {camera}", scene(camera=camera)
    for image in ({"maxDepth": 2}, {"integrator": "classic"}, {"filter": "gaussian", "filterWidth": 3}, {"epsilon": 0.01}):
        yield f"image {image}", scene(image=image)


# ---- files ----

def write_png(r, path, channels):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes(r.randrange(40, 256) for _ in range(4 * channels)) for _ in range(4))
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 4, 4, 8, 2 if channels == 3 else 6, 0, 0, 0))
                   + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.returncode, done.stderr.strip()


def render(fathom, path):
    image = path + ".exr"
    code, said = run(fathom, "render", path, "-o", image, "--size", "24x24", "--spp", "4", "--seed", "3", "--exr-float", "--no-floor", "-q")
    if code:
        raise ValueError(said)
    rows = exr.read(image)[1]
    return [x for row in rows.values() for c in "RGB" for x in struct.unpack(f"{len(row[c]) // 4}f", row[c])]


def convert(fathom, content, folder, kind):
    """The file to render, and what was said, without its numbers."""
    out = os.path.join(folder, "out." + kind)
    code, said = run(fathom, "convert", os.path.join(folder, "in.json"), out)
    if code:
        raise ValueError(said)
    if kind == "obj":  # the scene's own camera and lights see it
        around = {k: content[k] for k in ("camera", "lights", "background", "image", "ambient") if k in content}
        with open(os.path.join(folder, "around.json"), "w", encoding="utf-8") as file:
            json.dump({**around, "objects": [{"type": "mesh", "file": "out.obj"}]}, file)
        out = os.path.join(folder, "around.json")
    return out, {re.sub(r"\(\d+ such.*", "", line) for line in said.splitlines()}


def compare(fathom, name, content, folder, usual):
    """Lines about formats that lose something silently."""
    with open(os.path.join(folder, "in.json"), "w", encoding="utf-8") as file:
        json.dump(content, file)
    before = render(fathom, os.path.join(folder, "in.json"))
    for kind in FORMATS:
        out, said = convert(fathom, content, folder, kind)
        if name == "nothing":
            usual[kind] = said
        after = render(fathom, out)
        off = max(abs(a - b) for a, b in zip(before, after))
        # Four samples of a pixel, each of some ten products and sums of rounded numbers.
        if off > 64 * 2.0 ** -24 * max(before) and not said - usual[kind] and name not in NOISY:
            yield f"{name}: .{kind} differs by {off:.2g} of {max(before):.2g}, and nothing was said"


def main(fathom, every="1", first="0", folder=None):
    wrong, usual, fathom = 0, {}, os.path.abspath(fathom)
    things = [*parameters(), *images(), *shapes(), *surroundings()][int(first)::int(every)]
    with tempfile.TemporaryDirectory() as temporary:
        folder, r = folder or temporary, random.Random(5)
        write_png(r, os.path.join(folder, "rgb.png"), 3)
        write_png(r, os.path.join(folder, "rgba.png"), 4)
        for name, content in [("nothing", scene()), *things]:
            try:
                lines = list(compare(fathom, name, content, folder, usual))
            except ValueError as error:
                lines = [f"{name} is refused: {error}"]
            wrong += len(lines)
            print(*lines, sep="\n", end="\n" if lines else "", flush=True)
    print(f"{wrong} of {len(FORMATS) * len(things)} files differ silently or are refused")
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
