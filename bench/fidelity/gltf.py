"""Writes small glTF files: buffers, accessors, images and meshes made by rule. Needs Debian's python3-numpy and
python3-openimageio."""
import base64
import json
import os
import shutil
import struct
import tempfile
import zlib

import numpy as np
import OpenImageIO as oiio

NEAREST, LINEAR, TRILINEAR = 9728, 9729, 9987
REPEAT, MIRROR, CLAMP = 10497, 33648, 33071
COMPONENTS = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def quad(width=1.0, height=1.0, repeat=1.0):
    """Corners, normals and uvs of a rectangle in the plane z = 0 that faces +z; the image stands upright on it."""
    x, y = width / 2, height / 2
    return {"POSITION": np.float32([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]]),
            "NORMAL": np.float32([[0, 0, 1]] * 4),
            "TEXCOORD_0": np.float32([[0, 1], [1, 1], [1, 0], [0, 0]]) * np.float32(repeat),
            "indices": np.uint16([0, 1, 2, 0, 2, 3])}


def sphere(radius=1.0, across=128, down=64):
    v, u = np.meshgrid(np.linspace(0, 1, down + 1), np.linspace(0, 1, across + 1), indexing="ij")
    theta, phi = v * np.pi, u * 2 * np.pi
    n = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(down), np.arange(across), indexing="ij")
    a = (i * (across + 1) + j).ravel()
    b, c, d = a + 1, a + across + 1, a + across + 2
    upper, lower = np.stack([a, c, b], 1)[across:], np.stack([b, c, d], 1)[:-across]
    return {"POSITION": np.float32(n * radius), "NORMAL": np.float32(n),
            "TEXCOORD_0": np.float32(np.stack([u, v], -1).reshape(-1, 2)),
            "indices": np.uint16(np.concatenate([upper, lower]).ravel())}


def cube(size=1.0):
    """24 corners, flat."""
    points, normals, uvs, indices = [], [], [], []
    for axis in range(3):
        for sign in (-1, 1):
            n, s, t = np.zeros(3), np.zeros(3), np.zeros(3)
            n[axis], s[(axis + 1) % 3], t[(axis + 2) % 3] = sign, sign, 1
            first = len(points)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                points.append((n + a * s + b * t) * size / 2)
                normals.append(n)
                uvs.append([(a + 1) / 2, (1 - b) / 2])
            indices += [first + k for k in (0, 1, 2, 0, 2, 3)]
    return {"POSITION": np.float32(points), "NORMAL": np.float32(normals), "TEXCOORD_0": np.float32(uvs),
            "indices": np.uint16(indices)}


def patches(across=8, down=8, channels=3, seed=1):
    """An image without any symmetry: patches of colours far from black and white."""
    return np.random.RandomState(seed).randint(40, 230, (down, across, channels)).astype(np.uint8)


def bumps(size=64, waves=3, height=0.35):
    """A normal map of waves that differ in both directions, as glTF has it: x to the right, y up, z outwards."""
    v, u = np.meshgrid((np.arange(size) + 0.5) / size, (np.arange(size) + 0.5) / size, indexing="ij")
    x = -height * np.cos(2 * np.pi * waves * u)
    y = 0.6 * height * np.sin(2 * np.pi * (waves - 1) * v + 1)
    n = np.stack([x, y, np.ones_like(x)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return np.round((n * 0.5 + 0.5) * 255).astype(np.uint8)


def png(pixels):
    """Written here, because other writers add colour profiles."""
    height, width, channels = pixels.shape
    chunk = lambda tag, data: (struct.pack(">I", len(data)) + tag + data
                               + struct.pack(">I", zlib.crc32(tag + data)))
    head = struct.pack(">IIBBBBB", width, height, 8 * pixels.dtype.itemsize, {1: 0, 3: 2, 4: 6}[channels], 0, 0, 0)
    rows = b"".join(b"\0" + row.astype(pixels.dtype.newbyteorder(">")).tobytes() for row in pixels)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def encoded(pixels, suffix):
    """The bytes of an image file by OpenImageIO."""
    path = os.path.join(tempfile.mkdtemp(), "image" + suffix)
    out = oiio.ImageOutput.create(path)
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], "uint8")
    spec.attribute("CompressionQuality", 100)
    spec.attribute("compression", "lossless" if suffix == ".webp" else "jpeg:100")
    if not (out and out.open(path, spec) and out.write_image(pixels) and out.close()):
        raise SystemExit(f"fidelity: {path}: {oiio.geterror() or out.geterror()}")
    with open(path, "rb") as file:
        data = file.read()
    shutil.rmtree(os.path.dirname(path))
    return data


def decoded(data, suffix):
    """The 8-bit texels that OpenImageIO finds in a file of these bytes."""
    with tempfile.NamedTemporaryFile(suffix=suffix) as file:
        file.write(data)
        file.flush()
        return np.uint8(oiio.ImageBuf(file.name).get_pixels(oiio.UINT8)[..., :3])


def packed_vertices(data, stride):
    """A stream of KHR_meshopt_compression with the mode ATTRIBUTES, version 1: differences of bytes as they are."""
    rows = np.frombuffer(data, np.uint8).reshape(-1, stride)
    steps = np.diff(rows, axis=0, prepend=np.zeros((1, stride), np.uint8))
    codes = steps << 1 ^ np.where(steps & 128, 255, 0).astype(np.uint8)
    most = min(8192 // stride & ~15, 256)
    blocks = [b"\xff" * (stride // 4) + codes[k:k + most].T.tobytes() for k in range(0, len(codes), most)]
    return b"\xa1" + b"".join(blocks) + bytes(max(stride + stride // 4, 24))


def packed_indices(data):
    """A stream of the mode INDICES: differences to the index before."""
    out = bytearray(b"\xd1")
    for step in np.diff(data.astype(np.int64), prepend=0).tolist():
        code = (step << 1 ^ step >> 63) << 1
        while code > 127:
            out.append(code & 127 | 128)
            code >>= 7
        out.append(code)
    return bytes(out) + bytes(4)


class Scene:
    """One file. `shading` says how Cycles shades: "matt" by a Lambert BSDF, "blender" by what its importer makes."""

    def __init__(self, name, says, shading="matt", background=(0.5, 0.6, 0.7), size=(96, 96)):
        self.name, self.says, self.shading = name, says, shading
        self.background, self.size, self.twin, self.embed = background, size, None, False
        self.options = []  # of `fathom render`
        self.blob, self.files = bytearray(), {}
        self.json = {"asset": {"version": "2.0", "generator": "bench/fidelity"}, "scene": 0, "scenes": [{"nodes": []}]}

    def push(self, key, value):
        self.json.setdefault(key, []).append(value)
        return len(self.json[key]) - 1

    def uses(self, extension, required=False):
        for key in ["extensionsUsed"] + ["extensionsRequired"] * required:
            if extension not in self.json.setdefault(key, []):
                self.json[key].append(extension)

    def view(self, data):
        self.blob += b"\0" * (-len(self.blob) % 4)
        self.blob += data
        return self.push("bufferViews", {"buffer": 0, "byteOffset": len(self.blob) - len(data), "byteLength": len(data)})

    def packed(self, data, mode="ATTRIBUTES", filter="NONE"):
        """The number of an accessor whose values only KHR_meshopt_compression has; the view itself has zeros."""
        self.uses("KHR_meshopt_compression", True)
        at = self.accessor(data, mode == "ATTRIBUTES" and data.dtype.itemsize < 4)
        view = self.json["bufferViews"][self.json["accessors"][at]["bufferView"]]
        stride = view.get("byteStride", data[0].nbytes)
        plain = slice(view["byteOffset"], view["byteOffset"] + view["byteLength"])
        self.view(packed_indices(data) if mode == "INDICES" else packed_vertices(self.blob[plain], stride))
        self.blob[plain] = bytes(view["byteLength"])
        view["extensions"] = {"KHR_meshopt_compression": {**self.json["bufferViews"].pop(), "mode": mode,
                                                          "filter": filter, "byteStride": stride, "count": len(data)}}
        return at

    def accessor(self, data, normalized=False):
        data = np.ascontiguousarray(data)
        width = data.shape[1] if data.ndim == 2 else 1
        stride = -(-data.itemsize * width // 4) * 4
        what = {"componentType": COMPONENTS[str(data.dtype)], "count": len(data), "type": KINDS[width]}
        if data.ndim == 2 and stride != data.itemsize * width:  # vertices start at multiples of 4
            padded = np.zeros((len(data), stride // data.itemsize), data.dtype)
            padded[:, :width] = data
            what["bufferView"] = self.view(padded.tobytes())
            self.json["bufferViews"][-1]["byteStride"] = stride
        else:
            what["bufferView"] = self.view(data.tobytes())
        if normalized:
            what["normalized"] = True
        if data.dtype == np.float32:
            what["min"], what["max"] = np.atleast_1d(data.min(0)).tolist(), np.atleast_1d(data.max(0)).tolist()
        return self.push("accessors", what)

    def mesh(self, *primitives):
        """Each primitive: (arrays, material) or (arrays, material, mode). Arrays may be numbers of accessors."""
        made = []
        for arrays, material, *mode in primitives:
            made.append({"attributes": {}})
            for key, data in arrays.items():
                small = not isinstance(data, int) and data.dtype.itemsize < 4 and key != "indices"
                at = data if isinstance(data, int) else self.accessor(data, small)
                (made[-1] if key == "indices" else made[-1]["attributes"])[key] = at
            if material is not None:
                made[-1]["material"] = material
            if mode:
                made[-1]["mode"] = mode[0]
        return self.push("meshes", {"primitives": made})

    def node(self, parent=None, **keys):
        at = self.push("nodes", keys)
        if parent is None:
            self.json["scenes"][0]["nodes"].append(at)
        else:
            self.json["nodes"][parent].setdefault("children", []).append(at)
        return at

    def animate(self, node, path, times, values, interpolation="LINEAR"):
        animation = self.json.setdefault("animations", [{"channels": [], "samplers": []}])[0]
        animation["samplers"].append({"input": self.accessor(np.float32(times)), "output": self.accessor(np.float32(values)),
                                      "interpolation": interpolation})
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": {"node": node, "path": path}})

    def camera(self, translation=(0, 0, 4), rotation=(0, 0, 0, 1), yfov=0.6, aspect=None):
        lens = {"yfov": yfov, "znear": 0.01}
        if aspect:
            lens["aspectRatio"] = aspect
        camera = self.push("cameras", {"type": "perspective", "perspective": lens})
        self.node(camera=camera, translation=list(translation), rotation=list(rotation))

    def light(self, kind, intensity, color=(1, 1, 1), parent=None, cone=None, **place):
        self.uses("KHR_lights_punctual")
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {}).setdefault("lights", [])
        lights.append({"type": kind, "intensity": intensity, "color": list(color)})
        if cone:
            lights[-1]["spot"] = {"innerConeAngle": cone[0], "outerConeAngle": cone[1]}
        self.node(parent, extensions={"KHR_lights_punctual": {"light": len(lights) - 1}}, **place)

    def sun(self, intensity=2.0):
        """From the upper left, in front."""
        self.light("directional", intensity, rotation=turn((0.6, -0.5, -0.6)))

    def image(self, data, suffix=".png", how="file"):
        mime = {".png": "image/png", ".jpg": "image/jpeg", ".webp": "image/webp"}[suffix]
        if how == "view":
            return self.push("images", {"bufferView": self.view(data), "mimeType": mime})
        if how == "data":
            return self.push("images", {"uri": f"data:{mime};base64," + base64.b64encode(data).decode()})
        file = f"{self.name}-{len(self.files)}{suffix}"
        self.files[file] = data
        return self.push("images", {"uri": file})

    def texture(self, image, mag=NEAREST, low=None, s=REPEAT, t=REPEAT, **info):
        """A reference to a texture, as materials have it. `image`: pixels, or the number of an image."""
        image = image if isinstance(image, int) else self.image(png(image))
        sampler = self.push("samplers", {"magFilter": mag, "minFilter": low or mag, "wrapS": s, "wrapT": t})
        return {"index": self.push("textures", {"source": image, "sampler": sampler}), **info}

    def material(self, color=(0.8, 0.8, 0.8, 1), texture=None, metallic=0.0, roughness=1.0, extensions=None, pbr=(),
                 **keys):
        """Matt, unless the scene is shaded by Blender: a specular factor of 0 leaves the diffuse base alone."""
        made = {"baseColorFactor": list(color) + [1] * (4 - len(color)), "metallicFactor": metallic,
                "roughnessFactor": roughness, **dict(pbr)}
        if texture:
            made["baseColorTexture"] = texture
        extensions = dict(extensions or {})
        if self.shading == "matt":
            extensions["KHR_materials_specular"] = {"specularFactor": 0}
        for name in extensions:
            self.uses(name)
        keys = {"doubleSided": True, "pbrMetallicRoughness": made, **keys}
        return self.push("materials", {**keys, "extensions": extensions} if extensions else keys)

    def write(self, folder):
        out = dict(self.json)
        path = os.path.join(folder, self.name + (".glb" if self.embed == "glb" else ".gltf"))
        buffer = {"byteLength": len(self.blob)}
        if self.embed == "data":
            buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(self.blob).decode()
        elif not self.embed:
            buffer["uri"] = self.name + ".bin"
            self.files[buffer["uri"]] = bytes(self.blob)
        out["buffers"] = [buffer]
        text = json.dumps(out, indent=1).encode()
        if self.embed == "glb":
            text += b" " * (-len(text) % 4)
            blob = bytes(self.blob) + b"\0" * (-len(self.blob) % 4)
            text = (struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(blob)) + struct.pack("<I4s", len(text), b"JSON")
                    + text + struct.pack("<I4s", len(blob), b"BIN\0") + blob)
        for name, data in {path: text, **self.files}.items():
            with open(os.path.join(folder, name), "wb") as file:
                file.write(data)
        return path


def turn(forward, roll=0.0):
    """The quaternion that turns -z to `forward`."""
    z = -np.float64(forward) / np.linalg.norm(forward)
    x = np.cross([0, 1, 0] if abs(z[1]) < 0.99 else [0, 0, 1], z)
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    x, y = np.cos(roll) * x + np.sin(roll) * y, np.cos(roll) * y - np.sin(roll) * x
    m = np.stack([x, y, z], 1)
    w, v = np.linalg.eigh(np.array([
        [m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0], [m[0, 1] + m[1, 0], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
        [m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], m[2, 2] - m[0, 0] - m[1, 1], 0],
        [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m.trace()]]) / 3)
    return v[:, -1].tolist()


def about(axis, degrees):
    """The quaternion of a turn around an axis."""
    half = np.radians(degrees) / 2
    return [*(np.sin(half) * np.float64(axis) / np.linalg.norm(axis)), np.cos(half)]
