# SPDX-License-Identifier: Apache-2.0
"""Make the meshes of the scene files again: python3 make_meshes.py [--check]. Needs numpy, not Blender.

Writes meshes/*.ply and puts the generated parts (lathe profiles) into the scene files that hold them. The same bytes
every time; --check writes nothing and exits with 1 if a file differs.
"""
import io
import json
import math
import os
import re
import sys

import numpy as np

import shapes

HERE = os.path.dirname(os.path.abspath(__file__))


def bezier(points, steps):
    """A chain of cubic Bezier curves (3n + 1 points) as a polyline, `steps` pieces each."""
    p = np.array(points, float)
    out = [p[0]]
    for i in range(0, len(p) - 1, 3):
        for j in range(1, steps + 1):
            t = j / steps
            out.append((1 - t) ** 3 * p[i] + 3 * t * (1 - t) ** 2 * p[i + 1] + 3 * t * t * (1 - t) * p[i + 2]
                       + t ** 3 * p[i + 3])
    return out


def wineglass():
    """A wine glass 0.21 m high: foot, stem, bowl with a rounded rim, outside first, then down the inside."""
    mm = [(0, 0), (12, 0), (24, 0), (33, 0),
          (36, 0), (36, 2.2), (33.5, 2.4),                  # the foot's edge
          (20, 3.6), (5.2, 5.5), (4.2, 16),                 # up the foot into the stem
          (3.6, 30), (3.6, 60), (4.0, 78),                  # the stem
          (4.6, 88), (12, 91), (20, 96),                    # under the bowl
          (33, 104), (42, 119), (42, 140),                  # the bowl's belly
          (42, 165), (36, 188), (32.5, 209),                # towards the rim
          (32.3, 210.2), (31.3, 210.2), (31.1, 209),        # the rim
          (34.6, 188), (40.4, 165), (40.4, 140),            # down inside
          (40.4, 121), (31.5, 107), (19, 99),
          (12, 95.2), (6, 94), (0, 94)]
    return [[round(r / 1000, 6), round(z / 1000, 6)] for r, z in bezier(mm, 10)]


def band():
    """The outline of a finger ring, closed: 52 mm inside, 5 mm thick, 24 mm high, edges rounded by 1.2 mm."""
    r0, r1, z0, z1, e = 52.0, 57.0, 0.2, 24.2, 1.2
    out = []
    for cr, cz, a in ((r1 - e, z0 + e, -90), (r1 - e, z1 - e, 0), (r0 + e, z1 - e, 90), (r0 + e, z0 + e, 180)):
        for j in range(9):
            t = math.radians(a + 90 * j / 8)
            out.append((cr + e * math.cos(t), cz + e * math.sin(t)))
    out.append(out[0])
    return [[round(r / 1000, 6), round(z / 1000, 6)] for r, z in out]


def cyclorama():
    """A table that bends up into a backdrop, extruded along X; front side towards the set."""
    side, front, back, radius, top = 2.5, -1.2, 1.2, 0.5, 2.0
    outline = [(front, 0.0), (back - radius, 0.0)]
    outline += [(back - radius + radius * math.sin(t), radius - radius * math.cos(t))
                for t in np.linspace(0, math.pi / 2, 33)[1:]]
    outline.append((back, top))
    o = np.array(outline)
    n = len(o)
    v = np.concatenate([np.column_stack([np.full(n, x), o]) for x in (-side, side)])
    i = np.arange(n - 1)
    return v, [np.stack([i, i + n, i + n + 1, i + 1], -1)]


def tiles(parity):
    """Every second tile of a basin: floor, far wall and side walls, as quads with gaps for the grout behind."""
    x0, x1, y0, y1, z0, z1, size, gap = -2.0, 2.0, -1.5, 2.0, -1.25, 0.25, 0.25, 0.008
    faces = []

    def sheet(origin, u, v, nu, nv, shift):
        o, u, v = (np.array(a, float) for a in (origin, u, v))
        for j in range(nv):
            for i in range(nu):
                if (i + j + shift) % 2 == parity:
                    a, b = i * size + gap / 2, (i + 1) * size - gap / 2
                    c, d = j * size + gap / 2, (j + 1) * size - gap / 2
                    faces.append([o + a * u + c * v, o + b * u + c * v, o + b * u + d * v, o + a * u + d * v])

    nx, ny, nz = (round((b - a) / size) for a, b in ((x0, x1), (y0, y1), (z0, z1)))
    lift = 0.002  # in front of the grout
    sheet((x0, y0, z0 + lift), (1, 0, 0), (0, 1, 0), nx, ny, 0)
    sheet((x0, y1 - lift, z0), (1, 0, 0), (0, 0, 1), nx, nz, 1)
    sheet((x0 + lift, y0, z0), (0, 1, 0), (0, 0, 1), ny, nz, 1)
    sheet((x1 - lift, y1, z0), (0, -1, 0), (0, 0, 1), ny, nz, 0)
    v = np.array(faces).reshape(-1, 3)
    return v, [np.arange(len(v)).reshape(-1, 4)]


def basin():
    """What shows between the tiles: floor and four walls, their front sides towards the water."""
    x0, x1, y0, y1, z0, z1 = -2.0, 2.0, -1.5, 2.0, -1.25, 0.25
    p = lambda *q: list(q)
    quads = [
        [p(x0, y0, z0), p(x1, y0, z0), p(x1, y1, z0), p(x0, y1, z0)],
        [p(x0, y1, z0), p(x1, y1, z0), p(x1, y1, z1), p(x0, y1, z1)],
        [p(x0, y0, z0), p(x0, y1, z0), p(x0, y1, z1), p(x0, y0, z1)],
        [p(x1, y1, z0), p(x1, y0, z0), p(x1, y0, z1), p(x1, y1, z1)],
        [p(x1, y0, z0), p(x0, y0, z0), p(x0, y0, z1), p(x1, y0, z1)],
    ]
    v = np.array(quads, float).reshape(-1, 3)
    return v, [np.arange(len(v)).reshape(-1, 4)]


MESHES = {"cyclorama": cyclorama, "pool_tiles_light": lambda: tiles(0), "pool_tiles_dark": lambda: tiles(1),
          "pool_basin": basin}
PROFILES = {("still_life.json", "WineGlass"): wineglass, ("still_life.json", "Band"): band}


def put_profile(text, name, profile):
    """The scene file's text with the `profile` of the object `name` replaced, everything else as it stands."""
    at = text.index('"name": "%s"' % name)
    m = re.compile(r'([ ]*)"profile": \[.*?\]\s*\](?=\s*[,}\n])', re.S).search(text, at)
    pad, line, lines = m.group(1) + "  ", "", []
    for i, q in enumerate(profile):
        t = json.dumps(q) + (", " if i + 1 < len(profile) else "")
        if len(pad + line + t) > 118:
            lines.append(pad + line.rstrip())
            line = ""
        line += t
    lines.append(pad + line)
    return text[:m.start()] + m.group(1) + '"profile": [\n' + "\n".join(lines) + "\n" + m.group(1) + "]" + text[m.end():]


def main():
    check, bad = "--check" in sys.argv[1:], []

    def put(path, data):
        old = open(path, "rb").read() if os.path.exists(path) else None
        if old != data:
            bad.append(os.path.relpath(path, HERE))
            if not check:
                with open(path, "wb") as f:
                    f.write(data)

    os.makedirs(os.path.join(HERE, "meshes"), exist_ok=True)
    for name, make in MESHES.items():
        b = io.BytesIO()
        shapes.write_ply(b, *make(), "Caustics scene mesh " + name)
        put(os.path.join(HERE, "meshes", name + ".ply"), b.getvalue())
    for (scene, name), make in PROFILES.items():
        path = os.path.join(HERE, scene)
        with open(path, encoding="utf-8") as f:
            text = f.read()
        put(path, put_profile(text, name, make()).encode("utf-8"))
    print(("differs: " if check else "written: ") + (", ".join(bad) or "nothing"))
    return 1 if check and bad else 0


if __name__ == "__main__":
    sys.exit(main())
