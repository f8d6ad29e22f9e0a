"""The scenes of fidelity.sh, one for each feature of glTF: python3 scenes.py FOLDER writes them and scenes.json."""
import json
import os
import sys

import numpy as np

from gltf import (CLAMP, LINEAR, MIRROR, NEAREST, REPEAT, TRILINEAR, Scene, about, bumps, cube, decoded, encoded, patches, png,
                  quad, sphere, turn)

made = []
STRIP, FAN = 5, 6


def scene(says, **keys):
    """The function's name, with dashes, names the scene."""
    def add(fill):
        s = Scene(fill.__name__.replace("_", "-"), says, **keys)
        fill(s)
        made.append(s)
        return fill
    return add


def spread(s, count, size, z=0.0):
    """Places in rows of two that fill the view at distance 4."""
    rows = (count + 1) // 2
    return [[(k % 2 - 0.5) * size, ((rows - 1) / 2 - k // 2) * size, z] for k in range(count)]


def stage(s):
    """The parts of most scenes: a camera, a lamp in the upper left, and a sky of one colour."""
    s.camera()
    s.sun()


def show(s, material, shape=None, **place):
    return s.node(mesh=s.mesh((shape or quad(2, 2), material)), **place)


# ---- materials without a highlight ----

@scene("baseColorFactor")
def base_color(s):
    stage(s)
    for at, color in zip(spread(s, 4, 1.1), ((0.8, 0.1, 0.1), (0.1, 0.7, 0.2), (0.9, 0.9, 0.9), (0, 0.2, 0.9))):
        show(s, s.material(color), sphere(0.5, 64, 32), translation=at)


@scene("no material at all: the default", shading="blender")
def no_material(s):
    stage(s)
    s.node(mesh=s.mesh((quad(2, 2), None)), rotation=about((0, 1, 0), 30))


@scene("baseColorTexture, PNG, nearest")
def texture_nearest(s):
    stage(s)
    show(s, s.material((0.9, 0.8, 0.7), s.texture(patches())), rotation=about((0, 1, 0), 40))


def tilted(s, pixels, low, size):
    stage(s)
    show(s, s.material((1, 1, 1), s.texture(s.image(png(pixels)), LINEAR, low)), quad(size, size),
         rotation=about((1, 0, 0), -40))


def with_twin(s, fill, *arguments):
    """Blender gets the same texels with 16 bits, which it decodes before it filters them."""
    s.twin = Scene(s.name + "-twin", "")
    fill(s, *arguments)
    fill(s.twin, arguments[0].astype(np.uint16) * 257, *arguments[1:])


@scene("baseColorTexture, linear filter")
def texture_linear(s):
    tilted(s, patches(), LINEAR, 2)


@scene("the same; Blender gets 16 bits, which it decodes before filtering")
def texture_linear_16(s):
    with_twin(s, tilted, patches(), LINEAR, 2)


@scene("minified, with mip levels; 16 bits likewise")
def texture_minified(s):
    with_twin(s, tilted, patches(256, 256), TRILINEAR, 6)


@scene("16-bit PNG with alpha")
def texture_png16(s):
    stage(s)
    pixels = patches(8, 8, 4).astype(np.uint16) * 256 + 77
    pixels[..., 3] = np.where(patches(8, 8, 1, 4)[..., 0] > 128, 65535, 0)
    show(s, s.material((1, 1, 1), s.texture(s.image(png(pixels))), alphaMode="MASK"), rotation=about((0, 0, 1), 20))


@scene("grey PNG of one channel")
def texture_grey(s):
    stage(s)
    show(s, s.material((0.9, 0.5, 0.2), s.texture(patches(8, 8, 1))))


@scene("JPEG")
def texture_jpeg(s):
    stage(s)
    pixels = np.kron(patches(4, 4), np.ones((16, 16, 1), np.uint8))
    show(s, s.material((1, 1, 1), s.texture(s.image(encoded(pixels, ".jpg"), ".jpg"))))


@scene("EXT_texture_webp, with a PNG for readers without it")
def texture_webp(s):
    stage(s)
    s.uses("EXT_texture_webp")
    data = encoded(np.kron(patches(4, 4), np.ones((16, 16, 1), np.uint8)), ".webp")
    info = s.texture(decoded(data, ".webp"))
    image = s.image(data, ".webp")
    s.json["textures"][info["index"]]["extensions"] = {"EXT_texture_webp": {"source": image}}
    show(s, s.material((1, 1, 1), info))


@scene("buffer and image as data URIs")
def data_uri(s):
    stage(s)
    s.embed = "data"
    show(s, s.material((1, 1, 1), s.texture(s.image(png(patches()), how="data"))))


@scene("GLB, image in a buffer view")
def glb(s):
    stage(s)
    s.embed = "glb"
    show(s, s.material((1, 1, 1), s.texture(s.image(png(patches()), how="view"))))


@scene("wrap modes: repeat, mirrored, clamped, mixed")
def wrap(s):
    stage(s)
    modes = ((REPEAT, REPEAT), (MIRROR, MIRROR), (CLAMP, CLAMP), (MIRROR, CLAMP))
    for at, (u, v) in zip(spread(s, 4, 1.05), modes):
        shape = quad(1, 1, 2.5)
        shape["TEXCOORD_0"] -= np.float32(0.7)
        show(s, s.material((1, 1, 1), s.texture(patches(4, 4), s=u, t=v)), shape, translation=at)


@scene("KHR_texture_transform: offset, rotation, scale, all")
def uv_transform(s):
    stage(s)
    s.uses("KHR_texture_transform")
    for at, t in zip(spread(s, 4, 1.05), ({"offset": [0.3, 0.1]}, {"rotation": 0.5}, {"scale": [2, 0.5]},
                                          {"offset": [0.2, 0.4], "rotation": -0.8, "scale": [1.5, 0.7]})):
        info = s.texture(patches(), extensions={"KHR_texture_transform": t})
        show(s, s.material((1, 1, 1), info), quad(1, 1), translation=at)


@scene("TEXCOORD_1, by texCoord and by KHR_texture_transform")
def second_uvs(s):
    stage(s)
    s.uses("KHR_texture_transform")
    for at, keys in zip(spread(s, 2, 1.05), ({"texCoord": 1}, {"extensions": {"KHR_texture_transform":
                                                                              {"texCoord": 1, "scale": [0.5, 0.5]}}})):
        shape = quad(1, 2)
        shape["TEXCOORD_1"] = shape["TEXCOORD_0"][[1, 2, 3, 0]] * np.float32(0.8)
        show(s, s.material((1, 1, 1), s.texture(patches(), **keys)), shape, translation=at)


@scene("uvs as normalized bytes and shorts")
def uv_integers(s):
    stage(s)
    for at, (kind, most) in zip(spread(s, 2, 1.05), ((np.uint8, 255), (np.uint16, 65535))):
        shape = quad(1, 2)
        shape["TEXCOORD_0"] = np.round(shape["TEXCOORD_0"] * most).astype(kind)
        show(s, s.material((1, 1, 1), s.texture(patches())), shape, translation=at)


@scene("normal map, no tangents", background=(0, 0, 0))
def normal_map(s):
    stage(s)
    show(s, s.material(normalTexture=s.texture(bumps(), LINEAR)), rotation=about((0, 1, 0), 20))


@scene("normal map, uvs mirrored and turned", background=(0, 0, 0))
def normal_mirrored(s):
    stage(s)
    for at, order in zip(spread(s, 4, 1.05), ([0, 1, 2, 3], [1, 0, 3, 2], [3, 2, 1, 0], [1, 2, 3, 0])):
        shape = quad(1, 1)
        shape["TEXCOORD_0"] = shape["TEXCOORD_0"][order]
        show(s, s.material(normalTexture=s.texture(bumps(), LINEAR)), shape, translation=at)


@scene("normal map on a sphere: MikkTSpace", background=(0, 0, 0))
def normal_sphere(s):
    stage(s)
    show(s, s.material(normalTexture=s.texture(bumps(64, 6), LINEAR)), sphere(1, 128, 64))


@scene("normal map with given tangents, as MikkTSpace's", background=(0, 0, 0))
def normal_tangents(s):
    stage(s)
    shape = quad(2, 2)
    shape["TANGENT"] = np.float32([[1, 0, 0, 1]] * 4)
    show(s, s.material(normalTexture=s.texture(bumps(), LINEAR)), shape)


@scene("normalTexture.scale 0.3 and 2", background=(0, 0, 0))
def normal_scale(s):
    stage(s)
    for at, scale in zip(spread(s, 2, 1.05), (0.3, 2)):
        show(s, s.material(normalTexture=s.texture(bumps(), LINEAR, scale=scale)), quad(1, 2), translation=at)


@scene("occlusionTexture: what it shows is computed")
def occlusion(s):
    stage(s)
    show(s, s.material(occlusionTexture=s.texture(patches())))


def glow(s, factor):
    s.camera((0, 0.5, 4))
    show(s, s.material((0, 0, 0), emissiveFactor=list(factor), emissiveTexture=s.texture(patches())), quad(1.6, 1))
    show(s, s.material(), quad(6, 6), translation=[0, -0.7, 0], rotation=about((1, 0, 0), -90))


@scene("emissiveFactor of one number, times emissiveTexture, above a floor that they light")
def emissive(s):
    glow(s, (0.8, 0.8, 0.8))


@scene("emissiveFactor with a colour, times emissiveTexture")
def emissive_tinted(s):
    glow(s, (0.9, 0.5, 0.2))


@scene("KHR_materials_emissive_strength", background=(0, 0, 0))
def emissive_strength(s):
    s.camera((0, 0.5, 4))
    show(s, s.material((0, 0, 0), emissiveFactor=[1, 0.6, 0.3],
                       extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 5}}), sphere(0.4, 64, 32))
    show(s, s.material(), quad(6, 6), translation=[0, -0.7, 0], rotation=about((1, 0, 0), -90))


@scene("alphaMode MASK, cutoffs 0.5 and 0.8, with shadows")
def alpha_mask(s):
    stage(s)
    pixels = patches(8, 8, 4, 3)
    for at, keys in zip(spread(s, 2, 1.05), ({}, {"alphaCutoff": 0.8})):
        show(s, s.material((1, 1, 1), s.texture(pixels), alphaMode="MASK", **keys), quad(1, 2), translation=at)
    show(s, s.material(), quad(6, 6), translation=[0, 0, -0.8])


@scene("alphaMode BLEND by texture and factor, with shadows")
def alpha_blend(s):
    stage(s)
    for at, color in zip(spread(s, 2, 1.05), ((1, 1, 1, 1), (0.9, 0.3, 0.2, 0.5))):
        show(s, s.material(color, s.texture(patches(8, 8, 4, 3)), alphaMode="BLEND"), quad(1, 2), translation=at)
    show(s, s.material(), quad(6, 6), translation=[0, 0, -0.8])


@scene("alphaMode OPAQUE: alpha is ignored")
def alpha_opaque(s):
    stage(s)
    show(s, s.material((1, 1, 1, 0.3), s.texture(patches(8, 8, 4, 3))))


@scene("the same; Blender gets the image without alpha")
def alpha_opaque_rgb(s):
    alpha_opaque(s)
    s.twin = Scene(s.name + "-twin", "")
    stage(s.twin)
    show(s.twin, s.twin.material((1, 1, 1), s.twin.texture(patches(8, 8, 4, 3)[..., :3])))


@scene("doubleSided, seen from behind, with a normal map", background=(0, 0, 0))
def double_sided(s):
    stage(s)
    show(s, s.material((0.8, 0.3, 0.2), normalTexture=s.texture(bumps(), LINEAR)), rotation=about((0, 1, 0), 160))


@scene("COLOR_0: floats, bytes, shorts")
def vertex_colors(s):
    stage(s)
    colors = np.array([[1, 0.1, 0.1], [0.1, 1, 0.1], [0.1, 0.1, 1], [0.9, 0.9, 0.2]])
    for at, (kind, most) in zip(spread(s, 3, 1.05), ((np.float32, 1), (np.uint8, 255), (np.uint16, 65535))):
        shape = quad(1, 1)
        shape["COLOR_0"] = (colors * most).astype(kind)
        show(s, s.material((1, 1, 1)), shape, translation=at)


@scene("COLOR_0 times texture times factor")
def vertex_colors_texture(s):
    stage(s)
    shape = quad(2, 2)
    shape["COLOR_0"] = np.float32([[1, 0.2, 0.2], [0.2, 1, 0.2], [0.2, 0.2, 1], [1, 1, 1]])
    show(s, s.material((0.9, 0.8, 0.7), s.texture(patches())), shape)


@scene("COLOR_0 with alpha, alphaMode BLEND")
def vertex_alpha(s):
    stage(s)
    shape = quad(2, 2)
    shape["COLOR_0"] = np.float32([[1, 0.2, 0.2, 0], [0.2, 1, 0.2, 1], [0.2, 0.2, 1, 0.5], [1, 1, 1, 1]])
    show(s, s.material((1, 1, 1), alphaMode="BLEND"), shape)
    show(s, s.material((0.2, 0.2, 0.2)), quad(6, 6), translation=[0, 0, -0.8])


# ---- meshes and nodes ----

@scene("nodes in nodes: translation, rotation, scale, matrix")
def hierarchy(s):
    stage(s)
    grey, red = s.material(), s.material((0.8, 0.2, 0.1))
    top = s.node(translation=[-0.4, -0.2, 0], rotation=about((1, 1, 0), 30), scale=[1.2, 1.2, 1.2])
    show(s, grey, cube(0.6), parent=top)
    arm = s.node(top, translation=[0.8, 0, 0], rotation=about((0, 0, 1), 40))
    show(s, red, cube(0.6), parent=arm, matrix=[0.6, 0.8, 0, 0, -0.64, 0.48, 0, 0, 0, 0, 1.2, 0, 0.1, 0.5, 0, 1])


def balls_scaled(s, material, *scales):
    stage(s)
    shape = s.mesh((sphere(0.5, 64, 32), material))
    for at, scale in zip(spread(s, 4, 1.1), scales):
        s.node(mesh=shape, translation=at, scale=scale, rotation=about((1, 2, 0.5), 50))


@scene("mirrored and non-uniform scale, with a texture")
def mirrored(s):
    balls_scaled(s, s.material((1, 1, 1), s.texture(patches())), [1, 1, 1], [-1, 1, 1], [1, 0.5, 1.5], [-0.6, -1, -1])


@scene("mirrored scale, with a normal map", background=(0, 0, 0))
def mirrored_normal_map(s):
    balls_scaled(s, s.material(normalTexture=s.texture(bumps(64, 6, 0.15), LINEAR)), [1, 1, 1], [-1, 1, 1],
                 [0.8, -0.8, 0.8], [-0.6, -0.6, -0.6])


@scene("non-uniform scale, with a normal map", background=(0, 0, 0))
def scaled_normal_map(s):
    balls_scaled(s, s.material(normalTexture=s.texture(bumps(64, 6, 0.15), LINEAR)), [1, 0.5, 1.5], [-0.6, -1, -1])


@scene("sparse accessors, with and without a base")
def sparse(s):
    stage(s)
    for at, base in zip(spread(s, 2, 1.1), (True, False)):
        shape = quad(1, 1)
        points = shape["POSITION"]
        which = [2] if base else [0, 1, 2, 3]
        moved = (points * np.float32([1, 2, 1]) if base else points * np.float32(0.7))[which]
        k = s.accessor(points)
        a = s.json["accessors"][k]
        a["sparse"] = {"count": len(which), "indices": {"bufferView": s.view(np.uint16(which).tobytes()),
                                                       "componentType": 5123},
                       "values": {"bufferView": s.view(np.float32(moved).tobytes())}}
        if not base:
            del a["bufferView"]
        whole = points.copy() if base else np.zeros_like(points)
        whole[which] = moved
        a["min"], a["max"] = whole.min(0).tolist(), whole.max(0).tolist()
        show(s, s.material((0.8, 0.5, 0.2)), {**shape, "POSITION": k}, translation=at)


@scene("two morph targets with weights")
def morph(s):
    stage(s)
    shape = quad(1.4, 1.4)
    at = show(s, s.material((0.8, 0.5, 0.2), s.texture(patches())), shape, rotation=about((0, 1, 0), 20))
    mesh = s.json["meshes"][s.json["nodes"][at]["mesh"]]
    moves = np.float32([[[0, 0, 0], [0.5, 0, 0], [0.5, 0.4, 0], [0, 0, 0]],
                        [[-0.4, -0.3, 0], [0, 0, 0], [0, 0, 0], [0, 0.5, 0]]])
    mesh["primitives"][0]["targets"] = [{"POSITION": s.accessor(move)} for move in moves]
    mesh["weights"] = [0.7, 0.4]


@scene("a skin of two joints")
def skin(s):
    stage(s)
    along = np.linspace(0, 1, 17)
    points = np.float32([[2 * a - 1, b, 0] for a in along for b in (-0.3, 0.3)])
    first = 2 * np.arange(len(along) - 1)
    shape = {"POSITION": points, "NORMAL": np.float32([[0, 0, 1]] * len(points)),
             "TEXCOORD_0": np.float32([[a, b] for a in along for b in (1, 0)]),
             "indices": np.uint16(np.stack([first, first + 2, first + 3, first, first + 3, first + 1], 1).ravel()),
             "JOINTS_0": s.accessor(np.uint8([[0, 1, 0, 0]] * len(points))),
             "WEIGHTS_0": np.float32([[1 - a, a, 0, 0] for a in along.repeat(2)])}
    at = show(s, s.material((0.9, 0.8, 0.7), s.texture(patches())), shape)
    joints = [s.node(translation=[0, -0.2, 0]), s.node(translation=[0, 0.5, 0], rotation=about((0, 0, 1), 50))]
    s.json["nodes"][at]["skin"] = s.push("skins", {"joints": joints})


def cubic(t, start, out, into, end):
    """A piece of a spline over one second."""
    return ((2 * t**3 - 3 * t**2 + 1) * start + (t**3 - 2 * t**2 + t) * out + (3 * t**2 - 2 * t**3) * end
            + (t**3 - t**2) * into)


@scene("animations at a time: linear, stepped and spline; Blender gets the pose")
def animations(s):
    t = 0.3
    s.options = ["--time", str(t)]
    s.twin = Scene(s.name + "-posed", "")
    spline = np.float32([[0, 0, 0], [-0.6, 0.6, 0], [2, 1, 0], [1, -1, 0], [0.6, 0.2, 0], [0, 0, 0]])
    poses = [{"translation": [-0.6 + t * 0.5, -0.6, 0]}, {"translation": [0.6, -0.6, 0], "rotation": about((0, 0, 1), 90 * t)},
             {"translation": [0, 0, 0], "scale": [0.5, 1, 1]}, {"translation": cubic(t, *spline[1:5]).tolist()}]
    for to, posed in ((s, False), (s.twin, True)):
        stage(to)
        material = to.material((0.9, 0.8, 0.7), to.texture(patches()))
        at = [show(to, material, quad(0.6, 0.6), **(pose if posed else {"translation": pose["translation"]})) for pose in poses]
    s.animate(at[0], "translation", [0, 1], [[-0.6, -0.6, 0], [-0.1, -0.6, 0]])
    s.animate(at[1], "rotation", [0, 1], [about((0, 0, 1), 0), about((0, 0, 1), 90)])
    s.animate(at[2], "scale", [0, 0.2, 1], [[1, 1, 1], [0.5, 1, 1], [2, 2, 2]], "STEP")
    s.animate(at[3], "translation", [0, 1], spline, "CUBICSPLINE")


@scene("KHR_materials_variants, the second; Blender gets its material")
def variants(s):
    s.options = ["--variant", "night"]
    s.twin = Scene(s.name + "-plain", "")
    for to, color in ((s, (0.9, 0.2, 0.1)), (s.twin, (0.1, 0.2, 0.8))):
        stage(to)
        at = show(to, to.material(color), sphere(0.9, 64, 32))
    mapping = {"material": s.material((0.1, 0.2, 0.8)), "variants": [1]}
    s.uses("KHR_materials_variants")
    s.json["extensions"]["KHR_materials_variants"] = {"variants": [{"name": "day"}, {"name": "night"}]}
    primitive = s.json["meshes"][s.json["nodes"][at]["mesh"]]["primitives"][0]
    primitive["extensions"] = {"KHR_materials_variants": {"mappings": [mapping]}}


@scene("KHR_node_visibility; Blender gets the visible nodes")
def node_visibility(s):
    s.twin = Scene(s.name + "-seen", "")
    s.uses("KHR_node_visibility")
    for to in (s, s.twin):
        stage(to)
        for k, place in enumerate(spread(to, 4, 1.1)):
            hidden = {"extensions": {"KHR_node_visibility": {"visible": False}}} if k in (1, 2) else {}
            if to is s or not hidden:
                show(to, to.material((0.8, 0.5, 0.2)), quad(0.9, 0.9), translation=place, **hidden)


@scene("points as spheres; Blender gets spheres")
def points(s):
    s.twin = Scene(s.name + "-spheres", "")
    at = np.float32([[x, y, 0.3 * x * y] for x in np.linspace(-1, 1, 30) for y in np.linspace(-1, 1, 30)])
    radius = float(np.linalg.norm(at.max(0) - at.min(0))) / 80  # scenes/README.md: as D / (2 sqrt 900) is larger
    for to in (s, s.twin):
        stage(to)
    show(s, s.material((0.8, 0.5, 0.2)), None)
    s.json["meshes"][-1] = {"primitives": [{"attributes": {"POSITION": s.accessor(at)}, "material": 0, "mode": 0}]}
    ball = s.twin.mesh((sphere(radius, 32, 16), s.twin.material((0.8, 0.5, 0.2))))
    for place in at:
        s.twin.node(mesh=ball, translation=place.tolist())


@scene("KHR_mesh_quantization: positions, normals and uvs as integers")
def quantized(s):
    stage(s)
    s.uses("KHR_mesh_quantization", True)
    shape = sphere(1, 128, 64)
    shape["POSITION"] = np.round(shape["POSITION"] * 32767).astype(np.int16)
    shape["NORMAL"] = np.round(shape["NORMAL"] * 127).astype(np.int8)
    shape["TEXCOORD_0"] = np.round(shape["TEXCOORD_0"] * 65535).astype(np.uint16)
    show(s, s.material((1, 1, 1), s.texture(patches())), shape)


@scene("KHR_meshopt_compression with its filter COLOR; Blender gets plain buffers")
def packed(s):
    shape = sphere(1, 128, 64)
    points, indices = np.round(shape["POSITION"] * 32767).astype(np.int16), shape["indices"].reshape(-1)
    luma = np.round(120 + 60 * shape["POSITION"][:, 1])
    co, cg = np.round(40 * shape["POSITION"][:, 0]), np.round(20 * shape["POSITION"][:, 2])
    colors = np.stack((luma + co - cg, luma + cg, luma - co - cg, 0 * luma + 255), 1).astype(np.uint8)
    coded = np.stack((luma, co, cg, 0 * luma + 255), 1).astype(np.int16).astype(np.uint8)
    s.twin = Scene(s.name + "-twin", "")
    for to in (s, s.twin):
        stage(to)
        to.uses("KHR_mesh_quantization", True)
    arrays = {"POSITION": s.packed(points), "COLOR_0": s.packed(coded, filter="COLOR"),
              "indices": s.packed(indices, "INDICES")}
    show(s, s.material((1, 1, 1)), arrays)
    show(s.twin, s.twin.material((1, 1, 1)), {"POSITION": points, "COLOR_0": colors, "indices": indices})


@scene("one mesh in many nodes")
def instances(s):
    stage(s)
    shape = s.mesh((cube(0.5), s.material((0.3, 0.6, 0.9))))
    for k in range(9):
        s.node(mesh=shape, translation=[(k % 3 - 1) * 0.75, (k // 3 - 1) * 0.75, 0],
               rotation=about((1, 0.3 * k, 0.5), 20 * k))


def instancing(s):
    stage(s)
    shape = s.mesh((cube(0.5), s.material((0.3, 0.6, 0.9))))
    places = np.float32([[(k % 3 - 1) * 0.75, (k // 3 - 1) * 0.75, 0] for k in range(9)])
    turns = np.float32([about((1, 0.3 * k, 0.5), 20 * k) for k in range(9)])
    return shape, places, turns


@scene("EXT_mesh_gpu_instancing; Blender gets the same as nodes")
def gpu_instancing(s):
    shape, places, turns = instancing(s)
    s.uses("EXT_mesh_gpu_instancing")
    attributes = {"TRANSLATION": s.accessor(places), "ROTATION": s.accessor(turns)}
    s.node(mesh=shape, extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}})
    s.twin = Scene("gpu-instancing-as-nodes", "")
    shape, places, turns = instancing(s.twin)
    for place, around in zip(places, turns):
        s.twin.node(mesh=shape, translation=place.tolist(), rotation=around.tolist())


@scene("triangle strips and fans, with and without indices")
def strips(s):
    stage(s)
    m = s.material((1, 1, 1), s.texture(patches()))
    loose = lambda shape, order: {k: v[order] for k, v in shape.items() if k != "indices"}
    for at, (order, mode) in zip(spread(s, 4, 1.05), (((0, 1, 3, 2), STRIP), ((0, 1, 2, 3), FAN)) * 2):
        shape = quad(1, 1)
        order = list(order)
        shape = {**shape, "indices": np.uint8(order)} if at[1] > 0 else loose(shape, order)
        s.node(mesh=s.mesh((shape, m, mode)), translation=at)


@scene("no indices, and indices of 8, 16 and 32 bits")
def indices(s):
    stage(s)
    m = s.material((1, 1, 1), s.texture(patches()))
    for at, kind in zip(spread(s, 4, 1.05), (None, np.uint8, np.uint16, np.uint32)):
        shape = quad(1, 1)
        if kind:
            shape["indices"] = shape["indices"].astype(kind)
        else:
            order = shape.pop("indices")
            shape = {k: v[order] for k, v in shape.items()}
        show(s, m, shape, translation=at)


@scene("no normals: flat")
def flat(s):
    stage(s)
    shape = sphere(1, 12, 8)
    del shape["NORMAL"]
    show(s, s.material(), shape)


def two_halves(s):
    stage(s)
    left, right = quad(1, 2), quad(1, 2)
    left["POSITION"][:, 0] -= 0.55
    right["POSITION"][:, 0] += 0.55
    s.node(mesh=s.mesh((left, s.material((0.8, 0.2, 0.1))), (right, s.material((0.1, 0.3, 0.8)))))


@scene("several primitives in a mesh")
def primitives(s):
    two_halves(s)


@scene("two scenes, the second shown; Blender, which imports both, gets the second alone")
def second_scene(s):
    s.twin = Scene(s.name + "-twin", "")
    two_halves(s)
    two_halves(s.twin)
    show(s, s.material((0, 1, 0)), quad(4, 4), translation=[0, 0, 1])
    hidden = s.json["scenes"][0]["nodes"].pop()
    s.json["scenes"].insert(0, {"nodes": [hidden]})
    s.json["scene"] = 1


# ---- cameras and lights ----

@scene("perspective camera, turned, aspect ratio 2", size=(136, 68))
def camera_wide(s):
    s.camera((1, 1.5, 3), turn((-0.4, -0.4, -1), 0.3), 0.7, 2)
    s.sun()
    show(s, s.material((1, 1, 1), s.texture(patches())))


@scene("perspective camera, aspect ratio 1/2, in a scaled node", size=(68, 136))
def camera_tall(s):
    top = s.node(scale=[2, 2, 2], rotation=about((0, 1, 0), 25))
    camera = s.push("cameras", {"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.01, "aspectRatio": 0.5}})
    s.node(top, camera=camera, translation=[0, 0, 2])
    s.sun()
    show(s, s.material((1, 1, 1), s.texture(patches())))


@scene("orthographic camera, xmag 1.5, ymag 1")
def camera_orthographic(s):
    s.size = (120, 80)
    lens = {"xmag": 1.5, "ymag": 1.0, "znear": 0.01, "zfar": 100}
    camera = s.push("cameras", {"type": "orthographic", "orthographic": lens})
    s.node(camera=camera, translation=[0, 1, 4], rotation=about((1, 0, 0), -14))
    s.sun()
    show(s, s.material((1, 1, 1), s.texture(patches())), cube(1), rotation=about((1, 1, 0), 40))


@scene("directional light, coloured, in a scaled and turned node", background=(0, 0, 0))
def light_directional(s):
    s.camera()
    top = s.node(scale=[3, 3, 3], rotation=about((0, 1, 0), -30))
    s.light("directional", 3, (1, 0.8, 0.5), top, rotation=turn((0, -1, -1)))
    show(s, s.material(), sphere(0.7))
    show(s, s.material(), quad(4, 4), translation=[0, 0, -1])


@scene("point lights, coloured", background=(0, 0, 0))
def light_point(s):
    s.camera()
    s.light("point", 4, (1, 0.6, 0.3), translation=[-1, 1, 1])
    s.light("point", 2, (0.3, 0.6, 1), translation=[1, 0.2, 0.8])
    show(s, s.material(), sphere(0.4, 64, 32))
    show(s, s.material(), quad(4, 4), translation=[0, 0, -0.7])


@scene("spot light with a sharp edge", background=(0, 0, 0))
def light_spot_hard(s):
    s.camera()
    s.light("spot", 10, (1, 0.9, 0.8), cone=(0.29, 0.3), translation=[0, 0.5, 2], rotation=turn((0, -0.1, -1)))
    show(s, s.material(), quad(4, 4))


@scene("spot light with a soft edge", background=(0, 0, 0))
def light_spot_soft(s):
    s.camera()
    s.light("spot", 10, (1, 0.9, 0.8), cone=(0.1, 0.5), translation=[0, 0, 2])
    show(s, s.material(), quad(4, 4))


# ---- what has a highlight ----

@scene("KHR_materials_unlit, with texture and vertex colours", shading="blender")
def unlit(s):
    stage(s)
    shape = quad(2, 2)
    shape["COLOR_0"] = np.float32([[1, 0.2, 0.2], [0.2, 1, 0.2], [0.2, 0.2, 1], [1, 1, 1]])
    show(s, s.material((0.9, 0.8, 0.7), s.texture(patches()), extensions={"KHR_materials_unlit": {}}), shape)


def balls(s, materials, size=1.1):
    stage(s)
    radius = 0.45 * size / 1.1
    for at, m in zip(spread(s, len(materials), size), materials):
        show(s, m, sphere(radius, 96, 48), translation=at)


@scene("metals under an even sky, roughness 0.1 to 0.8", shading="blender")
def metal(s):
    s.camera()
    for at, r in zip(spread(s, 4, 1.4), (0.1, 0.3, 0.5, 0.8)):
        show(s, s.material((0.9, 0.6, 0.2), metallic=1, roughness=r), sphere(0.4, 96, 48), translation=at)


def highlight(s, **keys):
    s.camera((0, 0, 6), yfov=0.4)
    s.light("directional", 3, rotation=turn((0.5, -0.4, -1)))
    show(s, s.material((0.6, 0.3, 0.1), **keys), sphere(1, 256, 128))


@scene("a metal's highlight, roughness 0.3", shading="blender", background=(0, 0, 0))
def highlight_metal(s):
    highlight(s, metallic=1, roughness=0.3)


@scene("a dielectric's highlight, roughness 0.3", shading="blender", background=(0, 0, 0))
def highlight_dielectric(s):
    highlight(s, roughness=0.3)


@scene("dielectrics, roughness 0.1 to 1", shading="blender")
def dielectric(s):
    balls(s, [s.material((0.6, 0.1, 0.1), roughness=r) for r in (0.1, 0.3, 0.6, 1)])


@scene("metallic 0.25 to 1, roughness 0.4", shading="blender")
def metallic(s):
    balls(s, [s.material((0.9, 0.6, 0.2), metallic=m, roughness=0.4) for m in (0.25, 0.5, 0.75, 1)])


@scene("metallicRoughnessTexture: blue and green", shading="blender")
def metallic_roughness_texture(s):
    stage(s)
    s.light("point", 2, translation=[0.5, 0.5, 1])
    pixels = patches()
    info = s.texture(pixels)
    show(s, s.material((0.9, 0.7, 0.4), metallic=1, roughness=1, pbr={"metallicRoughnessTexture": info}))


@scene("KHR_materials_ior 1 to 2.4", shading="blender")
def ior(s):
    balls(s, [s.material((0.5, 0.1, 0.1), roughness=0.3, extensions={"KHR_materials_ior": {"ior": n}})
              for n in (1.0, 1.33, 1.8, 2.4)])


@scene("KHR_materials_specular: factor and colour", shading="blender")
def specular(s):
    balls(s, [s.material((0.5, 0.1, 0.1), roughness=0.3, extensions={"KHR_materials_specular": e})
              for e in ({"specularFactor": 0.0}, {"specularFactor": 0.5}, {"specularFactor": 1.0},
                        {"specularColorFactor": [0.3, 0.8, 1.0]})])


@scene("KHR_materials_clearcoat, smooth and rough", shading="blender")
def clearcoat(s):
    balls(s, [s.material((0.5, 0.1, 0.1), roughness=0.7, extensions={"KHR_materials_clearcoat": e})
              for e in ({"clearcoatFactor": 0.0}, {"clearcoatFactor": 1.0},
                        {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.3}, {"clearcoatFactor": 0.5})])


@scene("KHR_materials_sheen, roughness 0.3 to 1", shading="blender")
def sheen(s):
    balls(s, [s.material((0.3, 0.05, 0.05), extensions={"KHR_materials_sheen": {
        "sheenColorFactor": [0.8, 0.8, 1], "sheenRoughnessFactor": r}}) for r in (0.3, 0.5, 0.7, 1)])


@scene("KHR_materials_pbrSpecularGlossiness", shading="blender")
def specular_glossiness(s):
    balls(s, [s.material(extensions={"KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.5, 0.1, 0.1, 1], "specularFactor": [f, f, f], "glossinessFactor": g}})
        for f, g in ((0.04, 0.7), (0.04, 0.2), (0.2, 0.7), (0.5, 0.5))])


@scene("KHR_materials_transmission without a volume: thin walls", shading="blender")
def transmission(s):
    stage(s)
    for at, r in zip(spread(s, 2, 1.1), (0.0, 0.4)):
        show(s, s.material((0.9, 0.5, 0.3), roughness=r, extensions={"KHR_materials_transmission":
                                                                     {"transmissionFactor": 1}}),
             quad(1, 2), translation=at)
    show(s, s.material((1, 1, 1), s.texture(patches()), extensions={"KHR_materials_specular": {"specularFactor": 0}}),
         quad(6, 6), translation=[0, 0, -1])


def ball_of_glass(s, **keys):
    s.camera()
    show(s, s.material((1, 1, 1), roughness=0.0, extensions={
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_volume": {"thicknessFactor": 1, **keys}}), sphere(0.8, 192, 96))
    show(s, s.material((0, 0, 0), emissiveFactor=[1, 1, 1], emissiveTexture=s.texture(patches())), quad(6, 6),
         translation=[0, 0, -1.5])


@scene("KHR_materials_volume: refraction", shading="blender")
def volume(s):
    ball_of_glass(s)


@scene("KHR_materials_volume: absorption", shading="blender")
def volume_absorbing(s):
    ball_of_glass(s, attenuationColor=[0.9, 0.4, 0.2], attenuationDistance=0.5)


if __name__ == "__main__":
    folder = sys.argv[1]
    listed = []
    for s in made:
        path = s.write(folder)
        other = s.twin.write(folder) if s.twin else path
        listed.append({"name": s.name, "says": s.says, "file": path, "twin": other, "shading": s.shading,
                       "background": s.background, "size": s.size, "options": s.options})
    with open(os.path.join(folder, "scenes.json"), "w") as file:
        json.dump(listed, file, indent=1)
