# SPDX-License-Identifier: Apache-2.0
"""The scenes of peers.py that POV-Ray 3.7 renders too, with its photon maps. z and y change places: it is left-handed."""
import atexit
import math
import os
import resource
import shutil
import subprocess
import tempfile

import numpy as np
import OpenImageIO as oiio

SCENES = ("exact", "ring", "water")
FOLDER = tempfile.mkdtemp(prefix="caustics_povray_")
atexit.register(shutil.rmtree, FOLDER, ignore_errors=True)
GLASS = """pigment {{ rgbt 1 }} finish {{ ambient 0 diffuse 0 reflection {{ 0 1 fresnel on }} conserve_energy }} }}
  interior {{ ior {ior} }} photons {{ target refraction on reflection off collect off }}"""
_straight = {}


def vectors(rows):
    return ",".join("<" + ",".join(f"{x:.7g}" for x in row) + ">" for row in rows)


def water_mesh(shape, height):
    """mesh2 with the sheet's own normals."""
    n = shape["segments"]
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, n + 1) * shape["size"][0], np.linspace(-0.5, 0.5, n + 1) * shape["size"][1])
    z, dx, dy = np.full(x.shape, float(height)), np.zeros(x.shape), np.zeros(x.shape)
    for w in shape["waves"]:
        c, s, k = math.cos(w["direction_rad"]), math.sin(w["direction_rad"]), w["k"]
        at = k * (x * c + y * s) + w["phase"]
        z += w["amplitude"] * np.sin(at)
        dx += w["amplitude"] * k * c * np.cos(at)
        dy += w["amplitude"] * k * s * np.cos(at)
    points = np.stack([x, z, y], -1).reshape(-1, 3)
    normals = np.stack([-dx, np.ones(x.shape), -dy], -1).reshape(-1, 3)
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + n + 1], 1)])
    faces = ",".join(f"<{i},{j},{k}>" for i, j, k in faces.tolist())
    count = len(points)
    return (f"mesh2 {{ vertex_vectors {{ {count}, {vectors(points)} }} normal_vectors {{ {count}, {vectors(normals)} }} "
            f"face_indices {{ {2 * n * n}, {faces} }} texture {{ {GLASS.format(ior=1.33)} }}")


def caster(name, scene):
    if name == "exact":
        return f"sphere {{ <0, 1.5, 0>, 1 texture {{ {GLASS.format(ior=1.5)} }}"
    if name == "ring":
        return ("cylinder { <0, 0, 0>, <0, 1.2, 0>, 1 open pigment { rgb 0 } finish { ambient 0 diffuse 0 reflection 1 }"
                " photons { target reflection on refraction off collect off } }")
    sheet = next(o for o in scene["objects"] if o["name"] == "Water")
    return water_mesh(sheet["shape"], sheet["position"][2])


def write(name, scene, photons):
    camera, look = scene["camera"], scene["lights"][0]["look"]["to"]
    high, wide = camera["look"]["from"][2], camera["ortho_width"]
    sun = [-1000 * look[0], -1000 * look[2], -1000 * look[1]]
    path = os.path.join(FOLDER, f"{name}.pov")
    light = "photons { reflection %s refraction %s }" % (("on", "off") if name == "ring" else ("off", "on"))
    with open(path, "w", encoding="utf-8") as file:
        file.write(f"""#version 3.7;
global_settings {{ assumed_gamma 1 max_trace_level 10 {f'photons {{ count {int(photons)} }}' if photons else ''} }}
camera {{ orthographic location <0, {high}, 0> direction <0, -1, 0> up <0, 0, {wide}> right <{wide}, 0, 0> }}
light_source {{ <{sun[0]:.9g}, {sun[1]:.9g}, {sun[2]:.9g}> rgb 1 parallel point_at <0, 0, 0> {light} }}
plane {{ <0, 1, 0>, 0 pigment {{ rgb 1 }} finish {{ ambient 0 diffuse 1 }} }}
{caster(name, scene)}
""")
    return path


def run(path, size):
    """(picture, user CPU seconds)"""
    out = path + ".exr"
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(["povray", f"+I{path}", f"+O{out}", f"+W{size}", f"+H{size}", "+FE", "-D", "-A", "+WT1", "-GA"],
                          capture_output=True, text=True, cwd=FOLDER)
    assert done.returncode == 0, done.stderr[-2000:]
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return np.asarray(oiio.ImageBuf(out).get_pixels("float"))[:, :, 1].astype(float), seconds


def render(name, scene, photons, size):
    """Irradiance by the photons alone, and user CPU seconds. What the ring's floor gets straight is taken off."""
    if name == "ring" and name not in _straight:
        _straight[name] = run(write(name, scene, 0), size)[0]
    picture, seconds = run(write(name, scene, photons), size)
    return picture - _straight.get(name, 0), seconds
