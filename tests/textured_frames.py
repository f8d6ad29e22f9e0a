"""For textured_scene.py: the frames in which images of normals and directions stand, and other frames for the same vectors.
A frame is its tangent and its bitangent, as vectors (x, z) of a sheet that looks along y."""
import math

DIRECTED = ("normal", "clearcoatNormal", "anisotropy")
ALONG = ([(1, 0), (0, 1)], [(0, 1), (-1, 0)])  # u and v of both uv sets on a sheet


def matrix(keys):
    """Of a texture's turn and scale, by rows."""
    turn, (sx, sy) = math.radians(keys.get("rotation", 0)), keys.get("scale", (1, 1))
    return [[math.cos(turn) * sx, math.sin(turn) * sy], [-math.sin(turn) * sx, math.cos(turn) * sy]]


def frame(keys, tangents):
    """Of a texture with these keys. tangents: their sign and their bitangents' side, or None."""
    if tangents and keys.get("uvSet", 0) == 0:
        sign, side = tangents
        return (sign, 0), (0, -side * sign)
    u, v = ALONG[keys.get("uvSet", 0)]
    t, b = [tuple(round(row[0] * u[k] + row[1] * v[k]) for k in (0, 1)) for row in matrix(keys)]
    return t, (-b[0], -b[1])


def directing(textures):
    """The keys of the texture in whose frame anisotropy has its direction."""
    return textures.get("normal") or textures.get("anisotropy") or {}


def moved(vector, old, new):
    """The same vector in another frame."""
    x, y = [vector[0] * old[0][k] + vector[1] * old[1][k] for k in (0, 1)]
    return [x * axis[0] + y * axis[1] for axis in new]


def other(r, keys, way):
    """Keys of a texture of one texel, whose frame may be another one."""
    if way == "flat":
        out = {"scale": [r.choice((-1, 1)), r.choice((-1, 1))], "rotation": r.choice((0, 90, 180, 270)), "uvSet": r.choice((0, 1))}
    else:
        out = {k: keys[k] for k in ("rotation", "uvSet") if k in keys}
        out["scale"] = [x * r.choice((-1, 1)) for x in keys.get("scale", (1, 1))]
    return out


def put(r, m, textures, texels, sheet, tangents, second, save):
    """Gives the material of a cell images of one texel. textures: keys of each in the whole sheet; texels: numbers;
    second: the second uv set is free; save: a function that writes an image and gives its name."""
    new = {}
    for name in textures:
        new[name] = {} if tangents else other(r, textures[name], sheet.way)
        if sheet.is_quad or not second:
            new[name].pop("uvSet", None)
    old_way, new_way = (frame(directing(of), t) for of, t in ((textures, sheet.tangents), (new, tangents)))
    for name, keys in new.items():
        x, y, z = texels[name]
        here = (old_way, new_way) if name == "anisotropy" else (frame(textures[name], sheet.tangents), frame(keys, tangents))
        x, y = moved((2 * x - 1, 2 * y - 1), *here)
        m[name + "Texture"] = dict(keys, file=save([(x + 1) / 2, (y + 1) / 2, z]))
    if "anisotropy" in m or "anisotropy" in textures:
        turn = m.get("anisotropyRotation", 0)
        start = moved((1, 0), old_way, new_way)
        x, y = moved((math.cos(turn), math.sin(turn)), old_way, new_way)
        if "anisotropy" in textures:  # the turn begins at the direction of the texel
            x, y = x * start[0] + y * start[1], y * start[0] - x * start[1]
        m["anisotropyRotation"] = math.atan2(y, x)


# ---- places ----

def placement(o):
    """Its matrix, by rows of four, of a group that stands still."""
    axis, turn = o.get("rotate", {}).get("axis", [0, 1, 0]), math.radians(o.get("rotate", {}).get("angle", 0))
    length = math.sqrt(sum(a * a for a in axis))
    x, y, z = [a / length for a in axis]
    c, s = math.cos(turn), math.sin(turn)
    rotation = [[c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s],
                [y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s],
                [z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]]
    scale = o.get("scale", [1, 1, 1])
    return [[a * b for a, b in zip(row, scale)] + [t] for row, t in zip(rotation, o["translation"])]


def cofactors(m):
    """The determinant times the inverse's transpose."""
    return [[m[(i + 1) % 3][(j + 1) % 3] * m[(i + 2) % 3][(j + 2) % 3] - m[(i + 1) % 3][(j + 2) % 3] * m[(i + 2) % 3][(j + 1) % 3]
             for j in range(3)] for i in range(3)]


def times(m, v):
    return [sum(a * b for a, b in zip(row, v)) for row in m]


def place(o, m):
    """Moves the vertices of a mesh; one that is mirrored keeps its outside."""
    normals = cofactors(m)
    side = 1 if sum(a * b for a, b in zip(m[0], normals[0])) > 0 else -1
    o["positions"] = [[a + row[3] for a, row in zip(times(m, p), m)] for p in o["positions"]]
    if "normals" in o:
        o["normals"] = [[side * a for a in times(normals, n)] for n in o["normals"]]
    if "tangents" in o:
        o["tangents"] = [times(m, t[:3]) + [side * t[3]] for t in o["tangents"]]
    if side < 0:
        o["indices"] = [[a, c, b] for a, b, c in o["indices"]]
    return o
