# SPDX-License-Identifier: Apache-2.0
"""Scenes with one caster and one light that nobody chose, for questions put to the plan: make(seed) gives (name, scene).

Ten families take turns: superquadrics, bottles, turned solids, noisy balls, rings, stacks, gems, sheets of water,
hammered metal, boxes. The light is a sun of 0.53 to 10 degrees, a point, or an area lamp of 0.1 to 2 m."""
import math
import random

import numpy as np

SIZE = [64, 36]


def grid_mesh(points, closed_u, closed_v):
    """Triangles over an (nu, nv, 3) array of points; open along v and closed along u, both ends close with a fan."""
    nu, nv = points.shape[:2]
    i, j = np.meshgrid(np.arange(nu if closed_u else nu - 1), np.arange(nv if closed_v else nv - 1), indexing="ij")
    i, j = i.ravel(), j.ravel()
    a, b = i * nv + j, (i + 1) % nu * nv + j
    c, d = (i + 1) % nu * nv + (j + 1) % nv, i * nv + (j + 1) % nv
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    vertices = points.reshape(-1, 3)
    if closed_u and not closed_v:
        ring, ends = np.arange(nu) * nv, nu * nv
        following = (np.arange(nu) + 1) % nu * nv
        vertices = np.concatenate([vertices, points[:, :1].mean((0, 1))[None], points[:, -1:].mean((0, 1))[None]])
        triangles = np.concatenate([triangles, np.stack([np.full(nu, ends), following, ring], 1),
                                    np.stack([np.full(nu, ends + 1), ring + nv - 1, following + nv - 1], 1)])
    return {"type": "mesh", "vertices": np.round(vertices, 6).tolist(), "triangles": triangles.tolist()}


def globe(nu, nv):
    """Longitudes and latitudes of a ball without its poles."""
    u = 2 * np.pi * np.arange(nu) / nu
    v = np.linspace(-np.pi / 2 + 2 / nv, np.pi / 2 - 2 / nv, nv)
    return np.meshgrid(u, v, indexing="ij")


class Maker:
    def __init__(self, seed):
        self.r = random.Random(seed)

    def near(self, low, high):
        return self.r.uniform(low, high)

    def glass(self):
        return {"type": "glass", "color": [1, 1, 1], "ior": round(self.near(1.3, 1.8), 3), "roughness": 0}

    def metal(self):
        return {"type": "metal", "color": [0.9, 0.9, 0.9], "edge_color": [1, 1, 1], "roughness": 0}

    def either(self):
        return self.r.choice([self.glass, self.glass, self.metal])()

    # ---- families: (objects, material) ----

    def superquadric(self):
        e, n = self.near(0.3, 2.2), self.near(0.3, 2.2)
        u, v = globe(self.r.choice([48, 96, 192]), self.r.choice([25, 49, 97]))

        def power(x, k):
            return np.sign(x) * np.abs(x)**k
        p = np.stack([power(np.cos(v), n) * power(np.cos(u), e), power(np.cos(v), n) * power(np.sin(u), e),
                      power(np.sin(v), n)], -1) * [self.near(0.3, 0.5) for _ in range(3)]
        return [{"shape": grid_mesh(p, True, False), "smooth": self.r.random() < 0.7}], self.either()

    def bottle(self):
        body, neck, wall = self.near(0.25, 0.45), self.near(0.08, 0.15), self.near(0.02, 0.05)
        height, shoulder = self.near(0.7, 1.1), self.near(0.45, 0.65)
        outer = [[0, 0], [body, 0], [body, shoulder], [neck, shoulder + 0.15], [neck, height]]
        inner = [[neck - wall, height], [neck - wall, shoulder + 0.15], [body - wall, shoulder], [body - wall, wall], [0, wall]]
        shape = {"type": "lathe", "profile": outer + inner, "segments": self.r.choice([32, 64, 128])}
        return [{"shape": shape, "smooth": self.r.random() < 0.8}], self.glass()

    def turned(self):
        n = self.r.randint(3, 8)
        inner = [[self.near(0.15, 0.5), (i + 0.5) / n] for i in range(n)]
        shape = {"type": "lathe", "profile": [[0, 0]] + inner + [[0, 1]], "segments": self.r.choice([24, 64, 128])}
        return [{"shape": shape, "smooth": self.r.random() < 0.7}], self.either()

    def noisy_ball(self):
        k = math.exp(self.near(math.log(3), math.log(60)))
        bump = math.exp(self.near(math.log(0.003), math.log(0.4))) / k
        fine = int(min(320, max(64, 6 * k)))
        u, v = globe(fine, fine // 2)
        p = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], -1)
        radius = np.ones(u.shape)
        for _ in range(6):
            d = np.array([self.r.gauss(0, 1) for _ in range(3)])
            radius += bump * np.sin(k * (p @ (d / np.linalg.norm(d))) + self.near(0, 6.28))
        return [{"shape": grid_mesh(self.near(0.35, 0.5) * p * radius[..., None], True, False)}], self.either()

    def ring(self):
        if self.r.random() < 0.4:
            shape = {"type": "cylinder", "radius": self.near(0.3, 0.7), "height": self.near(0.15, 0.5)}
            return [{"shape": shape, "position": [0, 0, 0.002]}], self.metal()
        nu, nv = self.r.choice([48, 96, 192]), self.r.choice([16, 32, 64])
        u, v = np.meshgrid(2 * np.pi * np.arange(nu) / nu, 2 * np.pi * np.arange(nv) / nv, indexing="ij")
        wide, thin = self.near(0.3, 0.5), self.near(0.06, 0.2)
        p = np.stack([(wide + thin * np.cos(v)) * np.cos(u), (wide + thin * np.cos(v)) * np.sin(u), thin * np.sin(v)], -1)
        return [{"shape": grid_mesh(p, True, True), "smooth": self.r.random() < 0.8}], self.either()

    def stack(self):
        out, z = [], 0.4
        for _ in range(self.r.randint(2, 6)):
            height = self.near(0.05, 0.2)
            out.append({"shape": {"type": "box", "size": [self.near(0.3, 0.7), self.near(0.3, 0.7), height]},
                        "position": [0, 0, z + height / 2], "rotation_deg": [0, 0, self.near(0, 90)]})
            z += height + self.near(0.01, 0.08)
        return out, self.glass()

    def gem(self):
        girdle, table, depth = self.near(0.35, 0.5), self.near(0.2, 0.3), self.near(0.3, 0.45)
        profile = [[0, 0], [girdle, depth], [girdle, depth + 0.03], [table, depth + 0.03 + self.near(0.1, 0.2)]]
        shape = {"type": "lathe", "profile": profile + [[0, profile[-1][1]]], "segments": self.r.choice([8, 12, 16, 24])}
        material = self.glass()
        material["ior"] = self.r.choice([1.5, 1.76, 2.42])
        return [{"shape": shape, "smooth": False}], material

    def sheet(self):
        waves = []
        for _ in range(self.r.randint(3, 7)):
            k = math.exp(self.near(math.log(2), math.log(40)))
            waves.append({"amplitude": self.near(0.02, 0.25) / k**1.3, "k": k, "direction_rad": self.near(0, 6.28),
                          "phase": self.near(0, 6.28)})
        shape = {"type": "heightfield", "size": [5, 5], "waves": waves}
        if self.r.random() < 0.5:
            shape["segments"] = self.r.choice([60, 150, 300])
        material = {"type": "glass", "color": [1, 1, 1], "ior": 1.33, "roughness": 0}
        return [{"shape": shape, "smooth": self.r.random() < 0.8, "position": [0, 0, self.near(0.3, 1)]}], material

    def hammered(self):
        n, k = 120, self.near(4, 40)
        x, y = np.meshgrid(np.linspace(-0.6, 0.6, n), np.linspace(-0.6, 0.6, n), indexing="ij")
        z = sum(np.sin(k * (x * math.cos(a) + y * math.sin(a)) + self.near(0, 6.28))
                for a in [self.near(0, 6.28) for _ in range(5)]) * self.near(0.003, 0.1) / k
        mesh = grid_mesh(np.stack([x, y, z], -1), False, False)
        return [{"shape": mesh, "position": [0, 0.8, 0.5], "rotation_deg": [self.near(60, 110), 0, 0]}], self.metal()

    def box(self):
        shape = {"type": "box", "size": [self.near(0.2, 0.8) for _ in range(3)]}
        return [{"shape": shape, "rotation_deg": [self.near(0, 90) for _ in range(3)]}], self.either()

    def light(self):
        turn, far, high = self.near(0, 6.28), self.near(0.3, 1.5), self.near(2, 3)
        look = {"from": [far * math.cos(turn), far * math.sin(turn), high], "to": [0, 0, 0.5]}
        kind = self.r.choice(["sun", "sun", "sun", "area", "area", "point"])
        if kind == "sun":
            angle = self.r.choice([0.53, 1, 2, 4, 7, 10])
            return f"sun {angle} deg", {"name": "Light", "type": "sun", "look": look, "strength": 2, "angle_deg": angle}
        if kind == "point":
            return "point", {"name": "Light", "type": "point", "look": look, "power_w": 100}
        side = self.r.choice([0.1, 0.2, 0.4, 1, 2])
        return f"area {side} m", {"name": "Light", "type": "area", "shape": "rectangle", "look": look, "size": [side, side],
                                  "power_w": 100}


FAMILIES = ["superquadric", "bottle", "turned", "noisy_ball", "ring", "stack", "gem", "sheet", "hammered", "box"]
STANDING = ("bottle", "turned", "ring", "stack", "gem", "sheet", "hammered")


def make(seed):
    m, family = Maker(seed), FAMILIES[seed % len(FAMILIES)]
    objects, material = getattr(m, family)()
    lift = m.near(0.02, 0.3) if family in STANDING else m.near(0.6, 1)
    for i, o in enumerate(objects):
        o.update(name=f"Caster{i}", material="caster")
        o.setdefault("position", [0, 0, lift])
        o.setdefault("rotation_deg", [m.near(-15, 15), m.near(-15, 15), m.near(0, 360)] if family == "superquadric" else [0, 0, 0])
    words, light = m.light()
    floor = {"name": "Floor", "shape": {"type": "plane", "size": [8, 8]}, "material": "floor"}
    camera = {"type": "perspective", "look": {"from": [m.near(-0.5, 0.5), -3, m.near(1.8, 3)], "to": [0, 0, 0.2]},
              "hfov_deg": m.near(20, 45), "resolution": SIZE}
    scene = {"caustics_scene": 1, "camera": camera, "objects": [floor] + objects, "lights": [light],
             "materials": {"floor": {"type": "diffuse", "color": [0.8, 0.8, 0.8]}, "caster": material}}
    if m.r.random() < 0.5:
        scene["bounces"] = {"total": 24, "diffuse": 4, "glossy": 16, "transmission": 16}
    return f"{seed} {family.replace('_', ' ')}, {material['type']}, {words}", scene
