# SPDX-License-Identifier: Apache-2.0
"""Scenes that wavefronts are bad at: make(name) gives a scene. See plan.py --hard."""
import math
import random

import numpy as np

from casters import SIZE, globe, grid_mesh

GLASS = {"type": "glass", "color": [1, 1, 1], "ior": 1.5, "roughness": 0}
LOOK = {"from": [0.8, 0.4, 3], "to": [0, 0, 0.5]}


def sun(angle_deg):
    return {"name": "Light", "type": "sun", "look": LOOK, "strength": 2, "angle_deg": angle_deg}


def ball(**more):
    return [{"name": "Caster0", "shape": {"type": "sphere", "radius": 0.4}, "position": [0, 0, 0.6], "material": "caster", **more}]


def bumpy():
    u, v = globe(1000, 501)
    p = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], -1)
    r, radius = random.Random(1), np.ones(u.shape)
    for octave in range(5):
        k = 12 * 2**octave
        for _ in range(4):
            d = np.array([r.gauss(0, 1) for _ in range(3)])
            radius += 0.02 / k * np.sin(k * (p @ (d / np.linalg.norm(d))) + r.uniform(0, 6.28))
    mesh = {"shape": grid_mesh(0.4 * p * radius[..., None], True, False), "smooth": True}
    return [{"name": "Caster0", "position": [0, 0, 0.6], "material": "caster", **mesh}], sun(0.53), GLASS


def wide_sun():
    return ball(), sun(10), GLASS


def wide_lamp():
    lamp = {"name": "Light", "type": "area", "shape": "rectangle", "look": {"from": [0.3, 0.2, 3.6], "to": [0, 0, 0.6]}, "size": [2, 2],
            "power_w": 100}
    return ball(), lamp, GLASS


def rough():
    return ball(), sun(0.53), {**GLASS, "roughness": 0.3}


def stack():
    boxes = [{"name": f"Caster{i}", "shape": {"type": "box", "size": [0.6, 0.5, 0.1]}, "position": [0, 0, 0.4 + 0.13 * i],
              "rotation_deg": [0, 0, 17 * i], "material": "caster"} for i in range(6)]
    return boxes, sun(0.53), GLASS


def foliage():
    r, vertices = random.Random(2), []
    for _ in range(3000):
        at = np.array([r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(1.2, 1.8)])
        vertices += [at + [r.uniform(-0.05, 0.05) for _ in range(3)] for _ in range(3)]
    shape = {"type": "mesh", "vertices": np.round(vertices, 5).tolist(), "triangles": np.arange(9000).reshape(-1, 3).tolist()}
    return ball() + [{"name": "Leaves", "shape": shape, "material": "floor"}], sun(0.53), GLASS


def diamond():
    """The facets of a brilliant: table, stars, mains and halves above the girdle, mains and halves below."""
    def ring(n, radius, z, turn):
        return [[radius * math.cos(2 * math.pi * (i + turn) / n), radius * math.sin(2 * math.pi * (i + turn) / n), z] for i in range(n)]
    table, upper, girdle, low, lower, tip = (ring(8, 0.22, 0.56, 0.5), ring(8, 0.33, 0.47, 0), ring(16, 0.4, 0.40, 0), ring(16, 0.4, 0.385, 0),
                                             ring(8, 0.1, 0.08, 0), [[0, 0, 0]])
    v = table + upper + girdle + low + lower + tip
    t, u, g, h, w, c = 0, 8, 16, 32, 48, 56
    f = [[t, t + i, t + i + 1] for i in range(1, 7)]
    for i in range(8):
        n = (i + 1) % 8
        f += [[u + i, u + n, t + i], [t + i, u + n, t + n], [u + i, g + 2 * i, g + (2 * i + 1) % 16], [u + i, g + (2 * i + 1) % 16, u + n],
              [u + n, g + (2 * i + 1) % 16, g + (2 * i + 2) % 16]]
        f += [[h + 2 * i, w + i, h + 2 * i + 1], [h + 2 * i + 1, w + i, w + n], [h + 2 * i + 1, w + n, h + (2 * i + 2) % 16], [w + i, c, w + n]]
    for i in range(16):
        n = (i + 1) % 16
        f += [[g + i, h + i, g + n], [g + n, h + i, h + n]]
    shape = {"type": "mesh", "vertices": v, "triangles": f}
    return [{"name": "Caster0", "shape": shape, "position": [0, 0, 0.15], "rotation_deg": [20, 10, 0], "smooth": False,
             "material": "caster"}], sun(0.53), {
        **GLASS, "ior": 2.42}


CASES = {"bumps on a million triangles": bumpy, "10 degree sun": wide_sun, "2 m lamp at 3 m": wide_lamp, "rough glass, 0.3": rough,
         "stack, 12 interfaces": stack, "foliage before a ball": foliage, "diamond": diamond}


def make(name):
    objects, light, glass = CASES[name]()
    floor = {"name": "Floor", "shape": {"type": "plane", "size": [8, 8]}, "material": "floor"}
    camera = {"type": "perspective", "look": {"from": [0.2, -3, 2.2], "to": [0, 0, 0.2]}, "hfov_deg": 32, "resolution": SIZE}
    return {"caustics_scene": 1, "camera": camera, "objects": [floor] + objects, "lights": [light],
            "materials": {"floor": {"type": "diffuse", "color": [0.8, 0.8, 0.8]}, "caster": glass},
            "bounces": {"total": 24, "diffuse": 4, "glossy": 16, "transmission": 16}}
