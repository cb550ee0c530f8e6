# SPDX-License-Identifier: Apache-2.0
"""The shapes of the scene format as meshes, and PLY files in and out. Needs numpy, not Blender.

Every function returns (vertices, faces): an (N, 3) float array and a list of arrays of corner indices, one array per
number of corners (all triangles in one, all quads in another). The front side is where corners turn counter-clockwise.
A lathe's front side is on the right of the profile as it is walked in the (r, z) plane: an outline that starts on the
axis below and climbs has its front side outside.
"""
import math

import numpy as np

# What stands for an exact surface where the host only knows meshes (smooth normals on top).
SPHERE_SEGMENTS = 512
CYLINDER_SEGMENTS = 1024
LATHE_SEGMENTS = 128
HEIGHTFIELD_CELLS_PER_WAVE = 48
HEIGHTFIELD_CELLS_MAX = 800


def plane(size):
    x, y = 0.5 * size[0], 0.5 * size[1]
    return np.array([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)], float), [np.array([(0, 1, 2, 3)])]


def box(size):
    x, y, z = (0.5 * s for s in size)
    v = np.array([(sx * x, sy * y, sz * z) for sz in (-1, 1) for sy in (-1, 1) for sx in (-1, 1)], float)
    return v, [np.array([(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])]


def lathe(profile, segments=LATHE_SEGMENTS):
    """Revolve [[r, z], ...] about Z. Points with r = 0 become one vertex; a profile may end where it began."""
    t = 2 * np.pi * np.arange(segments) / segments
    c, s = np.cos(t), np.sin(t)
    verts, rows = [], []
    n = 0
    closed = len(profile) > 3 and list(profile[0]) == list(profile[-1])
    for i, (r, z) in enumerate(profile):
        if closed and i == len(profile) - 1:
            rows.append(rows[0])
        elif r < 1e-9:
            verts.append(np.array([(0.0, 0.0, z)]))
            rows.append(np.full(segments, n))
            n += 1
        else:
            verts.append(np.stack([r * c, r * s, np.full(segments, z)], -1))
            rows.append(np.arange(n, n + segments))
            n += segments
    tris, quads = [], []
    for a, b in zip(rows, rows[1:]):
        a1, b1 = np.roll(a, -1), np.roll(b, -1)
        pole_a, pole_b = a[0] == a[1], b[0] == b[1]
        if pole_a and pole_b:
            continue
        if pole_a:
            tris.append(np.stack([a, b1, b], -1))
        elif pole_b:
            tris.append(np.stack([a, a1, b], -1))
        else:
            quads.append(np.stack([a, a1, b1, b], -1))
    return np.concatenate(verts), [np.concatenate(f) for f in (tris, quads) if f]


def sphere(radius, segments=None):
    """A UV sphere with its poles on Z, `segments` around and half as many from pole to pole."""
    n = segments or SPHERE_SEGMENTS
    m = max(2, n // 2)
    profile = [(radius * math.sin(math.pi * i / m), -radius * math.cos(math.pi * i / m)) for i in range(m + 1)]
    profile[0], profile[-1] = (0.0, -radius), (0.0, radius)
    return lathe(profile, n)


def cylinder(radius, height, caps=False, segments=None):
    v, f = lathe([(radius, 0.0), (radius, height)], segments or CYLINDER_SEGMENTS)
    if caps:  # Own vertices, so that smooth normals do not run over the edge.
        n = segments or CYLINDER_SEGMENTS
        ring = np.arange(n)
        v = np.concatenate([v, v])
        f = f + [np.array([2 * n + ring[::-1]]), np.array([3 * n + ring])]
    return v, f


def waves_height(waves, x, y):
    z = np.zeros_like(x, dtype=float)
    for w in waves:
        d, k = w.get("direction_rad", 0.0), w["k"]
        z += w["amplitude"] * np.sin(k * (x * math.cos(d) + y * math.sin(d)) + w.get("phase", 0.0))
    return z


def heightfield(size, waves, segments=None):
    """An open sheet; `segments` cells along each side, else enough of them for the shortest wave."""
    if segments:
        nx = ny = segments
    else:
        k = max([w["k"] for w in waves] or [1.0])
        nx, ny = (int(min(max(math.ceil(s * k / (2 * math.pi) * HEIGHTFIELD_CELLS_PER_WAVE), 64),
                          HEIGHTFIELD_CELLS_MAX)) for s in size)
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, nx + 1) * size[0], np.linspace(-0.5, 0.5, ny + 1) * size[1])
    v = np.stack([x, y, waves_height(waves, x, y)], -1).reshape(-1, 3)
    a = (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    return v, [np.stack([a, a + 1, a + nx + 2, a + nx + 1], -1)]


def from_json(shape):
    """A mesh for one `shape` of a scene file."""
    kind, segments = shape["type"], shape.get("segments")
    if kind == "plane":
        return plane(shape["size"])
    if kind == "box":
        return box(shape["size"])
    if kind == "sphere":
        return sphere(shape["radius"], segments)
    if kind == "cylinder":
        return cylinder(shape["radius"], shape["height"], shape.get("caps", False), segments)
    if kind == "lathe":
        return lathe(shape["profile"], segments or LATHE_SEGMENTS)
    if kind == "heightfield":
        return heightfield(shape["size"], shape["waves"], segments)
    if kind == "mesh":
        return np.array(shape["vertices"], float), [np.array(shape["triangles"], int)]
    raise ValueError("shape type '%s' is not known here" % kind)


def triangles(faces):
    return np.concatenate([f[:, [0, i, i + 1]] for f in faces for i in range(1, f.shape[1] - 1)])


def write_ply(file, vertices, faces, comment):
    """Binary little-endian PLY: float32 positions, triangles. The same input gives the same bytes."""
    t = triangles(faces)
    head = ("ply\nformat binary_little_endian 1.0\ncomment %s\nelement vertex %d\nproperty float x\nproperty float y\n"
            "property float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n"
            % (comment, len(vertices), len(t)))
    rec = np.zeros(len(t), dtype=[("n", "u1"), ("v", "<i4", 3)])
    rec["n"], rec["v"] = 3, t
    file.write(head.encode("ascii"))
    file.write(np.asarray(vertices, "<f4").tobytes())
    file.write(rec.tobytes())


def read_ply(path):
    """Positions and triangles of a PLY as write_ply leaves it (float properties, triangles only)."""
    with open(path, "rb") as f:
        data = f.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    head = data[:end].decode("ascii").splitlines()
    if "format binary_little_endian 1.0" not in head:
        raise ValueError("%s: only binary little-endian PLY is read here" % path)
    counts = {l.split()[1]: int(l.split()[2]) for l in head if l.startswith("element")}
    props = sum(1 for l in head if l.startswith("property float"))
    n, m = counts["vertex"], counts["face"]
    v = np.frombuffer(data, "<f4", n * props, end).reshape(n, props)[:, :3].astype(float)
    rec = np.frombuffer(data, np.dtype([("n", "u1"), ("v", "<i4", 3)]), m, end + 4 * n * props)
    if (rec["n"] != 3).any():
        raise ValueError("%s: only triangles are read here" % path)
    return v, [rec["v"].astype(int)]
