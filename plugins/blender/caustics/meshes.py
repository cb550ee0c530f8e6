# SPDX-License-Identifier: Apache-2.0
"""Evaluated meshes as arrays, and as binary PLY files.

Arrays come from Blender's own memory where its layout is what it is known to be, and by foreach_get otherwise. The layout is
not trusted: strides are measured between neighbours, and elements spread over the array compared with what Python's
own access says."""
import ctypes

from .errors import CausticsError

SAMPLES = 16


def numpy():
    try:
        import numpy as np
    except ImportError:
        raise CausticsError("Blender's Python has no numpy, which meshes are read with; install the package python3-numpy.") from None
    return np


class Triangles:
    """co: float32 (n, 3). tri: int32 (m, 3) into co. material: int32 (m). smooth: bool (m). normals: float32, (n, 3) per
    vertex or (m, 3, 3) per corner."""

    def __init__(self, co, tri, material, smooth, normals):
        self.co, self.tri, self.material, self.smooth, self.normals = co, tri, material, smooth, normals


# ---- arrays ----------------------------------------------------------------------------------------------------------

def view(items, dtype, width, check):
    """A copy of `width` numbers from each element, read by address; None where the layout is not as expected.
    check(item): the same numbers by Python's own access."""
    np = numpy()
    n = len(items)
    if n < 2:
        return None
    start, step = items[0].as_pointer(), items[1].as_pointer() - items[0].as_pointer()
    size = np.dtype(dtype).itemsize
    if step < width * size or step % size or items[n - 1].as_pointer() != start + step * (n - 1):
        return None
    raw = np.frombuffer((ctypes.c_char * (n * step)).from_address(start), dtype).reshape(n, step // size)[:, :width]
    for i in {n * k // SAMPLES for k in range(SAMPLES)} | {n - 1}:
        if not np.array_equal(raw[i], np.asarray(check(items[i]), dtype), equal_nan=np.dtype(dtype).kind == "f"):
            return None
    return raw.copy()


def by_foreach(items, name, dtype, width):
    np = numpy()
    out = np.empty(len(items) * width, dtype)
    items.foreach_get(name, out)
    return out.reshape(-1, width)


def array(items, name, dtype, width, pointers):
    found = None
    if pointers:
        found = view(items, dtype, width, lambda item: getattr(item, name))
    return by_foreach(items, name, dtype, width) if found is None else found


def positions(mesh, pointers):
    attribute = mesh.attributes.get("position") if hasattr(mesh, "attributes") else None
    if attribute:
        return array(attribute.data, "vector", "f4", 3, pointers)
    return array(mesh.vertices, "co", "f4", 3, pointers)


def corners(mesh, pointers):
    """(corner indices, vertex indices) of the triangles."""
    np = numpy()
    attribute = mesh.attributes.get(".corner_vert")
    tri = array(mesh.loop_triangles, "loops", "i4", 3, pointers)
    if attribute:
        of_corner = array(attribute.data, "value", "i4", 1, False)
    else:
        of_corner = view(mesh.loops, "i4", 1, lambda loop: [loop.vertex_index]) if pointers else None
        of_corner = by_foreach(mesh.loops, "vertex_index", "i4", 1) if of_corner is None else of_corner
    return tri, np.ascontiguousarray(of_corner.ravel()[tri])


def face_flags(mesh):
    """(material index, smooth) of each polygon."""
    np = numpy()
    material, smooth = np.zeros(len(mesh.polygons), "i4"), np.zeros(len(mesh.polygons), bool)
    mesh.polygons.foreach_get("material_index", material)
    mesh.polygons.foreach_get("use_smooth", smooth)
    return material, smooth


def polygon_of_triangle(mesh):
    np = numpy()
    if hasattr(mesh, "loop_triangle_polygons"):  # 4.0 on
        return by_foreach(mesh.loop_triangle_polygons, "value", "i4", 1).ravel()
    totals = np.empty(len(mesh.polygons), "i4")  # a polygon of n corners makes n - 2 triangles, in order
    mesh.polygons.foreach_get("loop_total", totals)
    return np.repeat(np.arange(len(totals), dtype="i4"), np.maximum(totals - 2, 0))


RACES = 1024  # polygons from which on Blender 3.x shares the work
CHUNK = 1 << 18


def vertex_normals(mesh, pointers):
    """Blender 3.x sums a vertex's normal in the order in which its threads come, and another last bit each time moves
    photons: there they are summed here, in the mesh's order. Faces by their angle at the vertex, as Blender does."""
    import bpy
    np = numpy()
    if bpy.app.version >= (4, 0, 0) or len(mesh.polygons) <= RACES:
        return array(mesh.vertex_normals, "vector", "f4", 3, pointers)
    co = [np.ascontiguousarray(x) for x in positions(mesh, pointers).T]
    flat = [np.ascontiguousarray(x) for x in by_foreach(mesh.polygons, "normal", "f4", 3).T]
    of_corner = view(mesh.loops, "i4", 1, lambda loop: [loop.vertex_index]) if pointers else None
    of_corner = (by_foreach(mesh.loops, "vertex_index", "i4", 1) if of_corner is None else of_corner).ravel()
    start, total = (by_foreach(mesh.polygons, name, "i4", 1).ravel() for name in ("loop_start", "loop_total"))
    sums = [np.zeros(len(co[0])) for _ in range(3)]
    for first in range(0, len(start), CHUNK):
        some = slice(first, first + CHUNK)
        add_corners(sums, co, of_corner, start[some], total[some], [x[some] for x in flat])
    length = np.sqrt(sum(x * x for x in sums))
    alone = np.nonzero(length <= 1e-35)[0]  # of no face, or of faces back to back: Blender takes the direction from the origin
    for x, c in zip(sums, co):
        x[alone] = c[alone]
    length[alone] = np.maximum(np.sqrt(sum(x[alone]**2 for x in sums)), 1e-35)
    return np.stack([(x / length).astype("f4") for x in sums], axis=1)


def add_corners(sums, co, of_corner, start, total, flat):
    """Adds each polygon's normal to its vertices, times the angle there. Polygons of one size at a time."""
    np = numpy()
    for n in np.unique(total):
        faces = np.nonzero(total == n)[0]
        v = [of_corner[start[faces] + i] for i in range(n)]
        at = [[c[corner] for c in co] for corner in v]
        edges = [unit([b - a for a, b in zip(at[i], at[(i + 1) % n])]) for i in range(n)]
        for i in range(n):  # twice the arc sine of half the chord, which is exact for small angles too
            chord = np.sqrt(sum((a + b)**2 for a, b in zip(edges[i], edges[i - 1])))
            angle = 2 * np.arcsin(np.minimum(0.5 * chord, 1))
            for x, f in zip(sums, flat):
                x += np.bincount(v[i], angle * f[faces], len(x))


def unit(vector):
    np = numpy()
    length = np.maximum(np.sqrt(sum(x * x for x in vector)), np.float32(1e-35))
    return [x / length for x in vector]


def normals(mesh, tri_corners, pointers):
    """What Cycles interpolates: per vertex, or per corner where edges are sharp or normals are set by hand."""
    if hasattr(mesh, "corner_normals"):  # 4.1 on
        if mesh.normals_domain == "CORNER":
            return array(mesh.corner_normals, "vector", "f4", 3, pointers)[tri_corners]
    elif mesh.use_auto_smooth:
        mesh.calc_normals_split()
        return by_foreach(mesh.loops, "normal", "f4", 3)[tri_corners]
    return vertex_normals(mesh, pointers)


def read(mesh, pointers=True):
    """The Triangles of an evaluated mesh; None when it has none."""
    np = numpy()
    mesh.calc_loop_triangles()
    if not len(mesh.loop_triangles):
        return None
    tri_corners, tri = corners(mesh, pointers)
    co = positions(mesh, pointers)
    if tri.min() < 0 or tri.max() >= len(co):
        raise CausticsError(f'Mesh "{mesh.name}" uses vertices that it does not have; run its validation.')
    material, smooth = face_flags(mesh)
    if getattr(mesh, "normals_domain", "") == "FACE":  # 4.1 on: every edge is sharp, whatever the faces say
        smooth[:] = False
    if material.any() or (smooth != smooth[0]).any():
        of = polygon_of_triangle(mesh)
        material, smooth = material[of], smooth[of]
    else:
        material, smooth = np.zeros(len(tri), "i4"), np.full(len(tri), smooth[0])
    return Triangles(co, tri, material, smooth, normals(mesh, tri_corners, pointers) if smooth.any() else None)


# ---- parts -----------------------------------------------------------------------------------------------------------

def part(mesh, mask, smooth):
    """(co, tri, normals or None) of some triangles, without the vertices that they do not use."""
    np = numpy()
    co, tri, n = mesh.co, mesh.tri, mesh.normals if smooth else None
    per_corner = n is not None and n.ndim == 3
    if not mask.all():
        tri = tri[mask]
        n = n[mask] if per_corner else n
    used = np.zeros(len(co), bool)
    used[tri] = True
    if not used.all():
        tri = (np.cumsum(used, dtype="i4") - 1)[tri]
        co = co[used]
        n = n[used] if n is not None and not per_corner else n
    return split(co, tri, n) if per_corner else (co, tri, n)


def split(co, tri, n):
    """Vertices whose corners differ in their normals become several."""
    np = numpy()
    flat, vertex = np.ascontiguousarray(n.reshape(-1, 3)), tri.ravel()
    first = np.zeros((len(co), 3), "f4")
    first[vertex[::-1]] = flat[::-1]
    other = np.nonzero((flat != first[vertex]).any(axis=1))[0]
    if not len(other):
        return co, tri, first
    key = np.empty(len(other), [("v", "i4"), ("n", "V12")])
    key["v"], key["n"] = vertex[other], flat[other].view("V12").ravel()
    unique, at, which = np.unique(key.view("V16"), return_index=True, return_inverse=True)
    vertex = vertex.copy()
    chosen = other[at]
    co, first = np.concatenate([co, co[vertex[chosen]]]), np.concatenate([first, flat[chosen]])
    vertex[other] = len(co) - len(unique) + which.ravel()
    return co, vertex.reshape(-1, 3), first


def write_ply(path, co, tri, n):
    """Binary PLY, single precision; n: normals per vertex or None."""
    np = numpy()
    fields = ["x", "y", "z"] + (["nx", "ny", "nz"] if n is not None else [])
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(co)}", *[f"property float {f}" for f in fields],
              f"element face {len(tri)}", "property list uchar int vertex_indices", "end_header", ""]
    faces = np.empty(len(tri), [("n", "u1"), ("i", "<i4", 3)])
    faces["n"], faces["i"] = 3, tri
    with open(path, "wb") as f:
        f.write("\n".join(header).encode())
        f.write(np.ascontiguousarray(co if n is None else np.concatenate([co, n], axis=1), "<f4").data)
        f.write(faces.data)


def flatten(path, to, rows):
    """Writes a PLY file of write_ply() as `to`, moved by a 4 x 4 matrix, without normals and without the triangles that
    then have no area. Returns how many are left; with none there is no file."""
    np = numpy()
    with open(path, "rb") as f:
        head, data = f.read().split(b"end_header\n", 1)
    lines = head.decode().split("\n")
    n, m = (int(next(line for line in lines if line.startswith("element " + e)).split()[2]) for e in ("vertex", "face"))
    width = sum(line.startswith("property float") for line in lines)
    co = np.frombuffer(data, "<f4", n * width).reshape(n, width)[:, :3].astype("f8")
    tri = np.frombuffer(data, np.dtype([("n", "u1"), ("i", "<i4", 3)]), m, n * width * 4)["i"]
    matrix = np.array(rows)
    co = (co @ matrix[:3, :3].T + matrix[:3, 3]).astype("f4")
    a, b, c = (co[tri[:, i]].astype("f8") for i in range(3))
    area, side = np.linalg.norm(np.cross(b - a, c - a), axis=1), np.ptp(co, axis=0).max()
    tri = tri[area > 1e-10 * side * side]
    if len(tri):
        write_ply(to, co, tri, None)
    return len(tri)
