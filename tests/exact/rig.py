# SPDX-License-Identifier: Apache-2.0
"""What the exact tests share: scenes as dictionaries, runs of caustic-render, means over seeds with their error.

Every random run has a fixed seed. A figure is the mean of several seeds, its error their standard error, so the
intervals below are Student's."""
import json
import math
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
    import OpenImageIO as oiio
except ImportError:
    print("not run: this Python has no numpy or OpenImageIO")
    sys.exit(77)

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("CAUSTIC_RENDER", os.path.join(SOURCE, "build", "bin", "caustic-render"))

# Two-sided quantiles of Student's t: what 95 % and 99.9 % of sound runs stay within, by degrees of freedom.
T95 = {1: 12.71, 2: 4.303, 3: 3.182, 4: 2.776, 5: 2.571, 6: 2.447, 7: 2.365, 11: 2.201, 15: 2.131, 31: 2.040}
T999 = {1: 636.6, 2: 31.60, 3: 12.92, 4: 8.610, 5: 6.869, 6: 5.959, 7: 5.408, 11: 4.437, 15: 4.073, 31: 3.633}

FOLDER = tempfile.TemporaryDirectory(prefix="caustics_exact_")


class Result:
    """Layers as float64 arrays (height, width, 3) by the name in the file, and the report."""

    def __init__(self, layers, report, path):
        self.layers, self.report, self.path = layers, report, path

    def __getitem__(self, name):
        return self.layers[name]

    def light(self, index=0):
        return self.report["lights"][index]


def read_exr(path):
    planes, file = {}, oiio.ImageInput.open(path)
    assert file, oiio.geterror()
    part = 0
    while file.seek_subimage(part, 0):
        spec = file.spec()
        data = file.read_image(part, 0, 0, spec.nchannels, "float")
        for i, name in enumerate(spec.channelnames):
            planes[name] = data[:, :, i].astype(np.float64)
        part += 1
    file.close()
    layers = {}
    for name in planes:
        layer = name.rpartition(".")[0]
        if name.endswith("R"):
            dot = layer + "." if layer else ""
            layers[layer] = np.stack([planes[dot + c] for c in "RGB"], axis=2)
        elif name.endswith("Y"):
            layers[layer] = planes[name][:, :, None]
    return layers


_runs = 0


def run(scene, *words, expect=0):
    """caustic-render of a scene (a dictionary, or a file), output in a new file. Returns the Result."""
    global _runs
    _runs += 1
    stem = os.path.join(FOLDER.name, f"run{_runs}")
    if isinstance(scene, dict):
        with open(stem + ".json", "w") as file:
            json.dump(scene, file)
        scene = stem + ".json"
    command = [PROGRAM, scene, "-o", stem + ".exr", "--report", stem + "_report.json", "--quiet"] + [str(w) for w in words]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == expect, f"{' '.join(command)}: exit {done.returncode}: {done.stderr}"
    if expect:
        return None
    with open(stem + "_report.json") as file:
        report = json.load(file)
    return Result(read_exr(stem + ".exr"), report, stem + ".exr")


# ---- scenes ----

def down_camera(x, y, z, width, resolution):
    """Orthographic, straight down: its picture's row 0 is at the largest y, its column 0 at the smallest x."""
    return {"type": "orthographic", "look": {"from": [x, y, z], "to": [x, y, z - 1]}, "ortho_width": width,
            "resolution": resolution, "clip": [1e-6, 1e6], "filter": {"type": "box", "width": 1}}


def look_camera(start, to, width, resolution):
    camera = down_camera(0, 0, 0, width, resolution)
    camera["look"] = {"from": start, "to": to}
    return camera


# Albedo 1: irradiance is pi times the radiance that the camera sees.
MATERIALS = {
    "white": {"type": "diffuse", "color": [1, 1, 1]},
    "black": {"type": "diffuse", "color": [0, 0, 0]},
    "glass": {"type": "glass", "color": [1, 1, 1], "ior": 1.5},
    "air": {"type": "glass", "color": [1, 1, 1], "ior": 1.0},
    "mirror": {"type": "metal", "color": [1, 1, 1], "roughness": 0},
}


def plane(name, size, position, material="white", rotation=(0, 0, 0), **more):
    return {"name": name, "shape": {"type": "plane", "size": list(size)}, "position": list(position),
            "rotation_deg": list(rotation), "material": material, **more}


def box(name, size, position, material, **more):
    return {"name": name, "shape": {"type": "box", "size": list(size)}, "position": list(position), "material": material,
            **more}


def ball(name, radius, position, material="glass", **more):
    return {"name": name, "shape": {"type": "sphere", "radius": radius}, "position": list(position),
            "material": material, **more}


def sun(direction, strength=1.0, angle=0.0, name="Sun", **more):
    """`direction`: the way the light flies."""
    return {"name": name, "type": "sun", "look": {"from": [0, 0, 0], "to": list(direction)}, "strength": strength,
            "angle_deg": angle, **more}


def scene(camera, objects, lights, bounces=None, materials=None, world=0.0):
    out = {"caustics_scene": 1, "camera": camera, "materials": {**MATERIALS, **(materials or {})}, "objects": objects,
           "lights": lights, "world": {"color": [1, 1, 1], "strength": world}}
    if bounces:
        out["bounces"] = bounces
    return out


# ---- statistics ----

class Figure:
    """The mean of one number over seeds."""

    def __init__(self, values):
        self.values = np.asarray(values, float)
        self.n = len(self.values)
        self.mean = float(self.values.mean())
        self.error = float(self.values.std(ddof=1) / math.sqrt(self.n)) if self.n > 1 else math.inf

    def half_width(self, table=T95):
        return table[self.n - 1] * self.error

    def agrees(self, truth, bias=0.0):
        """Within what 99.9 % of sound runs stay, plus a stated bias."""
        return abs(self.mean - truth) <= self.half_width(T999) + bias


def over_seeds(seeds, measure):
    """measure(seed) gives a dictionary of numbers; returns a dictionary of Figures."""
    rows = [measure(seed) for seed in seeds]
    return {key: Figure([row[key] for row in rows]) for key in rows[0]}


def blocks(image, size):
    """Means over size x size blocks of a (height, width[, channels]) array; an incomplete rim is left out."""
    h, w = image.shape[0] // size * size, image.shape[1] // size * size
    cut = image[:h, :w]
    shape = (h // size, size, w // size, size) + cut.shape[2:]
    return cut.reshape(shape).mean(axis=(1, 3))


class Check:
    """Collects failures so that one run shows them all."""

    def __init__(self):
        self.failures = []

    def that(self, ok, text):
        print(("ok    " if ok else "WRONG ") + text)
        if not ok:
            self.failures.append(text)

    def close(self, what, figure, truth, bias=0.0, sharp=None):
        """`sharp`: the largest error (relative) at which the test still says something."""
        self.that(figure.agrees(truth, bias),
                  f"{what}: {figure.mean:.6g} +- {figure.half_width():.2g} (95 %), truth {truth:.6g}"
                  + (f", bias allowed {bias:.2g}" if bias else ""))
        if sharp is not None:
            self.that(figure.error <= sharp * abs(truth), f"{what}: standard error {figure.error:.2g} of {truth:.6g}"
                      f" is under {100 * sharp:.3g} %")

    def end(self):
        if self.failures:
            print(f"{len(self.failures)} wrong")
        sys.exit(1 if self.failures else 0)
