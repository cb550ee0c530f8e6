# SPDX-License-Identifier: Apache-2.0
"""W, P and R on scenes that nobody chose: random casters, receivers and lights.

usage: random_scenes.py [--scenes N] [--first SEED] [--photons N] [--paths N] [--keep FOLDER] [--estimators P,W]

Each seed makes a scene: one to three casters (exact shapes, meshes smooth and flat, lathes, sheets, mirrored and stretched; glass,
metal, plastic, smooth and rough), a floor and what else receives (walls, bumps, a ball), one or two lights wide enough for R
to find their caustics. Every layer is compared in 8 x 8 blocks as agreement.py does, where R's standard error is under
2 %. Ends with the scenes that fail and how much was tested; exit code 1 when one fails. --keep writes the scene files."""
import argparse
import json
import math
import os
import random
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "tests", "exact"))

import agreement  # noqa: E402
from rig import FOLDER, Check  # noqa: E402

SIZE = [48, 32]


class Maker:
    """One random scene. Everything about a metre large, the casters over the origin."""

    def __init__(self, seed):
        self.r = random.Random(seed)

    def near(self, low, high):
        return round(self.r.uniform(low, high), 3)

    def color(self, low=0.5):
        return [self.near(low, 1) for _ in range(3)]

    def turn(self):
        return [self.near(-180, 180) for _ in range(3)]

    def caster_material(self):
        rough = self.r.choice([0, 0, 0, self.near(0.05, 0.6)])
        kind = self.r.choice(["glass", "glass", "metal", "plastic"])
        if kind == "glass":
            return {"type": "glass", "color": self.color(0.8), "ior": self.near(1.1, 2.0), "roughness": rough}
        if kind == "metal":
            return {"type": "metal", "color": self.color(), "edge_color": self.color(), "roughness": rough}
        return {"type": "plastic", "color": self.color(0.2), "roughness": rough, "specular": self.near(0.2, 1)}

    def profile(self):
        """A closed outline from axis to axis, outside on its right."""
        n = self.r.randint(2, 5)
        inner = [[self.near(0.12, 0.4), round((i + 0.5) / n * 0.7, 3)] for i in range(n)]
        return [[0, 0]] + inner + [[0, 0.7]]

    def shape(self):
        segments = self.r.choice([16, 48, 96])
        return self.r.choice([
            {"type": "sphere", "radius": self.near(0.2, 0.4)},
            {"type": "sphere", "radius": self.near(0.2, 0.4), "segments": segments},
            {"type": "cylinder", "radius": self.near(0.15, 0.4), "height": self.near(0.2, 0.6), "caps": True},
            {"type": "cylinder", "radius": self.near(0.2, 0.5), "height": self.near(0.2, 0.5), "segments": segments},
            {"type": "lathe", "profile": self.profile(), "segments": segments},
            {"type": "box", "size": [self.near(0.2, 0.6) for _ in range(3)]},
        ])

    def casters(self):
        out, materials = [], {}
        for i in range(self.r.randint(1, 3)):
            materials[f"caster{i}"] = self.caster_material()
            item = {"name": f"Caster{i}", "shape": self.shape(), "material": f"caster{i}", "rotation_deg": self.turn(),
                    "position": [self.near(-0.7, 0.7), self.near(-0.5, 0.5), self.near(0.6, 0.9)],
                    "smooth": self.r.random() < 0.7}
            if self.r.random() < 0.3:
                item["scale"] = [self.near(0.6, 1.3), self.near(0.6, 1.3), self.r.choice([-1, 1]) * self.near(0.6, 1.3)]
            out.append(item)
        if self.r.random() < 0.2:
            materials["water"] = {"type": "glass", "color": [1, 1, 1], "ior": 1.33}
            waves = [{"amplitude": self.near(0.005, 0.03), "k": self.near(2, 9), "direction_rad": self.near(0, 6),
                      "phase": self.near(0, 6)} for _ in range(3)]
            out.append({"name": "Water", "shape": {"type": "heightfield", "size": [6, 6], "waves": waves}, "material": "water",
                        "position": [0, 0, 0.25]})
        return out, materials

    def receivers(self):
        plastic = self.r.random() < 0.25
        floor = {"type": "plastic", "color": self.color(), "roughness": self.near(0.2, 0.7)} if plastic else \
            {"type": "diffuse", "color": self.color()}
        out = [{"name": "Floor", "shape": {"type": "plane", "size": [6, 6]}, "material": "floor"}]
        if self.r.random() < 0.4:
            out.append({"name": "Wall", "shape": {"type": "plane", "size": [6, 3]}, "material": "floor",
                        "position": [0, 1.4, 1.5], "rotation_deg": [90, 0, self.near(-20, 20)]})
        if self.r.random() < 0.4:
            out.append({"name": "Bead", "shape": {"type": "sphere", "radius": 0.25, "segments": self.r.choice([24, 64])},
                        "material": "floor", "position": [self.near(-1, 1), self.near(-0.8, 0), 0.25]})
        if self.r.random() < 0.3:
            out.append({"name": "Post", "shape": {"type": "box", "size": [0.1, 0.1, 1]}, "material": "floor",
                        "position": [self.near(-0.9, 0.9), self.near(-0.6, 0.6), 0.5]})
        return out, {"floor": floor}

    def lights(self):
        out = []
        for i in range(self.r.randint(1, 2)):
            angle, far = self.near(0, 6.28), self.near(1, 3)
            look = {"from": [round(far * math.cos(angle), 3), round(far * math.sin(angle), 3), self.near(2, 4)], "to": [0, 0, 0.4]}
            base = {"name": f"Light{i}", "look": look, "color": self.color(0.3)}
            out.append({**base, **self.r.choice([
                {"type": "sun", "strength": 2, "angle_deg": self.near(40, 90)},
                {"type": "area", "shape": self.r.choice(["rectangle", "disk"]), "size": [self.near(1.5, 3), self.near(1.5, 3)],
                 "power_w": 150, "spread_deg": self.r.choice([180, 180, 120])},
                {"type": "point", "power_w": 150, "radius_m": self.near(0.7, 1.2)},
                {"type": "spot", "power_w": 150, "radius_m": self.near(0.7, 1.2), "cone_deg": self.near(50, 120), "blend": 0.3},
            ])})
        return out

    def scene(self):
        casters, materials = self.casters()
        receivers, more = self.receivers()
        camera = {"type": "perspective", "hfov_deg": self.near(30, 45), "resolution": SIZE,
                  "look": {"from": [self.near(-1, 1), -3.4, self.near(1.8, 3)], "to": [0, 0, 0.25]}}
        sky = self.near(0, 1) if self.r.random() < 0.2 else 0
        out = {"caustics_scene": 1, "camera": camera, "materials": {**materials, **more}, "objects": receivers + casters,
               "lights": self.lights(), "world": {"color": self.color(), "strength": sky}}
        if self.r.random() < 0.5:
            out["bounces"] = {"total": 24, "diffuse": 4, "glossy": 16, "transmission": 16}
        return out


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--scenes", type=int, default=100)
    p.add_argument("--first", type=int, default=1)
    p.add_argument("--photons", type=float, default=4e5)
    p.add_argument("--paths", type=float, default=2e6)
    p.add_argument("--keep")
    p.add_argument("--estimators", default="P,W")
    a = p.parse_args()
    folder = a.keep or os.path.join(FOLDER.name, "random")
    os.makedirs(folder, exist_ok=True)
    failed, found = [], Check()
    for seed in range(a.first, a.first + a.scenes):
        path = os.path.join(folder, f"random{seed}.json")
        with open(path, "w") as file:
            json.dump(Maker(seed).scene(), file, indent=1)
        before = len(found.failures)
        try:
            agreement.compare(found, path, int(a.photons), int(a.paths), agreement.SMALL, a.estimators.split(","))
        except (AssertionError, subprocess.SubprocessError) as error:
            found.that(False, f"random{seed}: {error}")
        if len(found.failures) > before:
            failed.append(seed)
    print(f"{a.scenes} scenes, {len(failed)} fail: {' '.join(map(str, failed))}")
    found.end()


if __name__ == "__main__":
    main()
