"""Meshes made by rule, as grids of points with texture coordinates. y is up."""
import struct

import numpy as np


class Mesh:
    """Rows of points, normals and uvs, and triangles."""

    def __init__(self, points, normals, uvs, triangles):
        self.points, self.normals, self.uvs, self.triangles = points, normals, uvs, triangles

    def moved(self, turn=np.eye(3), by=(0, 0, 0)):
        """turn: a rotation, its columns the new axes."""
        return Mesh(self.points @ turn.T + by, self.normals @ turn.T, self.uvs, self.triangles)

    def save(self, path):
        vertices = np.hstack([self.points, self.normals, self.uvs]).astype("<f4")
        faces = np.zeros(len(self.triangles), np.dtype([("count", "u1"), ("corners", "<u4", 3)]))
        faces["count"], faces["corners"] = 3, self.triangles
        with open(path, "wb") as f:
            f.write(b"ply\nformat binary_little_endian 1.0\n" + b"element vertex %d\n" % len(vertices))
            f.write(b"".join(b"property float %s\n" % name for name in b"x y z nx ny nz s t".split()))
            f.write(b"element face %d\nproperty list uchar uint vertex_indices\nend_header\n" % len(faces))
            f.write(vertices.tobytes() + faces.tobytes())


def together(meshes):
    firsts = np.cumsum([0] + [len(m.points) for m in meshes])
    return Mesh(*(np.vstack([getattr(m, key) for m in meshes]) for key in ("points", "normals", "uvs")),
                np.vstack([m.triangles + first for m, first in zip(meshes, firsts)]))


def sheet(points, uvs):
    """A grid of rows × columns × 3. Its front is where rows, seen as down, and columns, seen as right, face."""
    down, right = np.gradient(points, axis=0), np.gradient(points, axis=1)
    normals = np.cross(down, right)
    # At a pole a row is a point: the next row tells the normal there.
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    for end, next_one in ((0, 1), (-1, -2)):
        if (length[end] < 1e-9).any():
            normals[end] = normals[next_one].mean(0)
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    rows, columns = points.shape[:2]
    i = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    below = i + columns
    triangles = np.vstack([np.stack([i, below, i + 1], 1), np.stack([i + 1, below, below + 1], 1)])
    points = points.reshape(-1, 3)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return Mesh(points, normals.reshape(-1, 3), uvs.reshape(-1, 2), triangles[area > 1e-12])


def spline(points, steps=16):
    """Catmull and Rom's, through all points. A point given twice is a corner."""
    p = np.array([points[0], *points, points[-1]], float)
    t = np.linspace(0, 1, steps, endpoint=False)[:, None]
    parts = [0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * (b - c) + d - a) * t**3)
             for a, b, c, d in zip(p, p[1:], p[2:], p[3:]) if not np.allclose(b, c)]
    return np.vstack([*parts, p[-1:]])


def lathe(profile, around=128):
    """Turns rows of (radius, height) about y. u runs around, v along the profile. The front is outside where the profile
    runs down."""
    angle = np.linspace(0, 2 * np.pi, around + 1)
    r, y = profile[:, 0, None], profile[:, 1, None]
    points = np.stack(np.broadcast_arrays(r * np.sin(angle), y, r * np.cos(angle)), -1)
    way = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(profile, axis=0).T))])
    v, u = np.meshgrid(way / way[-1], angle / (2 * np.pi), indexing="ij")
    mesh = sheet(points, np.stack([u, v], -1))
    # The seam's two sides are one.
    n = mesh.normals.reshape(len(profile), around + 1, 3)
    seam = n[:, 0] + n[:, -1]
    n[:, 0] = n[:, -1] = seam / np.maximum(np.linalg.norm(seam, axis=-1, keepdims=True), 1e-12)
    return mesh


def block(size, round_by, steps=6):
    """A box around the origin with rounded edges. Each face has uvs from 0 to 1."""
    half = np.array(size) / 2
    edge = np.concatenate([-1 + np.linspace(0, 0.02, steps), 1 - np.linspace(0.02, 0, steps)])
    s, t = np.meshgrid(edge, edge, indexing="xy")
    faces = []
    for axis in range(3):
        for sign in (-1, 1):
            out, right, up = sign * np.eye(3)[axis], sign * np.eye(3)[axis - 2], np.eye(3)[axis - 1]
            # Rounded edges are equally wide, whatever the size of the box.
            x, y = (np.sign(k) * (abs(way @ half) - (1 - np.abs(k)) / 0.02 * round_by)
                    for k, way in ((s, right), (t, up)))
            p = x[..., None] * right - y[..., None] * up + out * half
            core = np.clip(p, -(half - round_by), half - round_by)
            away = p - core
            points = core + round_by * away / np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), 1e-12)
            faces.append(sheet(points, np.stack([(s + 1) / 2, (t + 1) / 2], -1)))
    return together(faces)


def tube(path, radius, around=12):
    """Along rows of points; radius: one for each. It must not run straight up or down in z."""
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along, (0, 0, 1.0))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(along, side)
    angle = np.linspace(0, 2 * np.pi, around + 1)
    ring = np.cos(angle)[None, :, None] * side[:, None] + np.sin(angle)[None, :, None] * other[:, None]
    points = path[:, None] + radius[:, None, None] * ring
    v, u = np.meshgrid(np.linspace(0, 1, len(path)), angle / (2 * np.pi), indexing="ij")
    return sheet(points, np.stack([u, v], -1))


def leaf(length, width, bend, fold):
    """A rectangle for an image whose lower edge is at the origin. It grows along +y, faces +z and bends to -z."""
    t, x = np.meshgrid(np.linspace(1, 0, 13), np.linspace(-0.5, 0.5, 7), indexing="ij")
    angle = bend * t
    up = length * np.sin(angle) / bend
    back = length * (1 - np.cos(angle)) / bend
    points = np.stack([x * width, up, -back + fold * np.abs(x) * width + 0.02 * length * np.sin(9 * t + 3 * x)], -1)
    return sheet(points, np.stack([x + 0.5, 1 - t], -1))


def toward(direction, roll=0.0):
    """A rotation that takes +y to the direction, and turns about it."""
    y = np.array(direction, float) / np.linalg.norm(direction)
    x = np.cross(y, (0, 0, 1.0) if abs(y[2]) < 0.9 else (1.0, 0, 0))
    x /= np.linalg.norm(x)
    z = np.cross(x, y)
    c, s = np.cos(roll), np.sin(roll)
    return np.stack([c * x + s * z, y, c * z - s * x], 1)
