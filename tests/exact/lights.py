# SPDX-License-Identifier: Apache-2.0
"""A layer per light: alone or together, weak or strong, on any number of threads."""
import copy
import math
import os
import subprocess
import sys

import numpy as np

from rig import FOLDER, PROGRAM, SOURCE, Check, ball, box, down_camera, look_camera, over_seeds, plane, run, scene

PHOTONS = 60000


def two_lights():
    camera = {"type": "perspective", "look": {"from": [0, -4, 2.5], "to": [0, 0, 0.4]}, "hfov_deg": 40,
              "resolution": [64, 36]}
    key = {"name": "Key", "type": "area", "shape": "rectangle", "size": [0.6, 0.4], "power_w": 60, "color": [1, 0.8, 0.5],
           "look": {"from": [1.5, -1, 3], "to": [0, 0, 0.4]}}
    rim = {"name": "Rim", "type": "point", "power_w": 40, "color": [0.4, 0.6, 1],
           "look": {"from": [-1.5, 1.5, 2], "to": [0, 0, 0.4]}}
    materials = {"amber": {"type": "glass", "color": [1, 0.9, 0.7], "ior": 1.5, "roughness": 0.2},
                 "coat": {"type": "plastic", "color": [0.6, 0.5, 0.4], "roughness": 0.3}}
    objects = [plane("Floor", [8, 8], [0, 0, 0], "coat"), ball("Ball", 0.4, [0.3, 0, 0.5]),
               box("Block", [0.5, 0.5, 0.5], [-0.5, 0.2, 0.3], "amber")]
    return scene(camera, objects, [key, rim], materials=materials)


def with_lights(s, *names):
    out = copy.deepcopy(s)
    out["lights"] = [light for light in s["lights"] if light["name"] in names]
    return out


def alone_and_together(check, estimator):
    s = two_lights()
    words = ["--photons", PHOTONS, "--estimator", estimator, "--layers", "radiance,indirect,error", "--seed", 3]
    both = run(s, *words)
    for name in ("Key", "Rim"):
        one = run(with_lights(s, name), *words)
        for layer in (f"caustics_{name}", f"caustics_{name}_ind", f"caustics_{name}_err"):
            same = np.array_equal(one[layer], both[layer])
            check.that(same and one[layer].max() > 0, f"{estimator}: {layer} is the same to the bit without the other light")
    swapped = copy.deepcopy(s)
    swapped["lights"].reverse()
    turned = run(swapped, *words)
    check.that(all(np.array_equal(turned[k], both[k]) for k in both.layers if k), f"{estimator}: the order of the lights is no matter")


def twice_as_strong(check, estimator):
    s = two_lights()
    words = ["--photons", PHOTONS, "--estimator", estimator, "--layers", "radiance,indirect", "--seed", 4]
    strong = copy.deepcopy(s)
    strong["lights"][0]["power_w"] *= 2
    a, b = run(s, *words), run(strong, *words)
    for layer in ("caustics_Key", "caustics_Key_ind"):
        check.that(np.array_equal(2 * a[layer], b[layer]), f"{estimator}: twice the strength is exactly twice {layer}")
    for layer in ("caustics_Rim", "caustics_Rim_ind"):
        check.that(np.array_equal(a[layer], b[layer]), f"{estimator}: {layer} does not know of it")


def sum_rule(check):
    """Part 0 is the sum of all radiance layers: in float to its rounding, in half to 2^-10 total + (N+1) 2^-25."""
    words = ["--photons", PHOTONS, "--estimator", "P", "--layers", "radiance,indirect,error,irradiance", "--seed", 5]
    for kind in ("float", "half"):
        for form in ([], ["--interleave"]):
            r = run(two_lights(), *words, "--type", kind, *form)
            added = [k for k in r.layers if k and not k.endswith(("_err", "_E", "_S", "_bias"))]
            total, parts = r[""], sum(r[k] for k in added)
            allowed = np.abs(total) * (2**-10 if kind == "half" else 2**-22) + (len(added) + 1) * (2**-25 if kind == "half" else 1e-30)
            worst = float(np.max(np.abs(total - parts) - allowed))
            check.that(len(added) == 4 and worst <= 0, f"sum rule, {kind}{' interleaved' if form else ''}: {len(added)} layers, over the limit by {worst:.1e}")


def threads(check):
    """The same bytes in the file on 1, 2 and 7 threads."""
    for estimator, layers in (("P", "radiance,indirect,irradiance,error"), ("R", "radiance,indirect,error,beauty"), ("auto", "radiance")):
        files = []
        for count in (1, 2, 7):
            r = run(two_lights(), "--photons", PHOTONS, "--estimator", estimator, "--layers", layers, "--threads", count)
            with open(r.path, "rb") as file:
                files.append(file.read())
        check.that(files[0] == files[1] == files[2] and len(files[0]) > 1000,
                   f"{estimator}: the same {len(files[0])} bytes on 1, 2 and 7 threads")
    other = run(two_lights(), "--photons", PHOTONS, "--estimator", "auto", "--layers", "radiance", "--seed", 1)
    with open(other.path, "rb") as file:
        check.that(file.read() != files[0], "another seed is another file")


# ---- memory ----

def disk_lamp(check):
    """A lamp that is a disk facing what it lights, over a floor under a sheet that does not bend light: what it lights is
    the sheet. A ray of the angle a from straight under it, at a distance D, crosses the sheet beside its axis by
    (D - h) tan a, from where the lamp's half angle is atan(r / d): up to the largest a that it holds for, the floor has
    I / r^2 sin^2 a. A sphere would give I / D^2."""
    power, r, height, sheet = 100.0, 0.6, 2.2, 0.5
    h, intensity = height - sheet, power / (4 * math.pi)

    def meets(a):
        d2 = ((height - h) * math.tan(a)) ** 2 + h * h
        return (height * math.sin(a)) ** 2 * (d2 + r * r) <= r * r * d2

    low, high = 0.0, 1.5
    for _ in range(60):
        low, high = ((low + high) / 2, high) if meets((low + high) / 2) else (low, (low + high) / 2)
    truth = intensity / r**2 * math.sin(low) ** 2
    lamp = {"name": "Lamp", "type": "point", "power_w": power, "radius_m": r, "body": "disk",
            "look": {"from": [0, 0, height], "to": [0, 0, 0]}}
    things = [plane("Floor", [4, 4], [0, 0, 0]), plane("Sheet", [1.2, 1.2], [0, 0, sheet], "air")]

    def mean(width, estimator, n, seed):
        s = scene(down_camera(0, 0, 0.4, width, [8, 8]), things, [lamp])
        words = ("--estimator", estimator, "--photons", n, "--seed", seed, "--effects", "direct", "--layers", "radiance")
        return math.pi * run(s, *words)["caustics_Lamp"].mean()

    found = over_seeds(range(1, 5), lambda seed: {"center": mean(0.02, "R", 2e5, seed), **{
        e: mean(1, e, n, seed) for e, n in (("R", 2e5), ("P", 4e5), ("W", 4e5))}})
    check.close("disk lamp through a sheet, under it, R", found["center"], truth, 0.001 * truth, 0.005)
    for e, sharp in (("P", 0.005), ("W", 0.03)):  # W has few places on so wide a lamp
        check.close(f"disk lamp through a sheet, {e} against R", found[e], found["R"].mean, 0.01 * truth, sharp)


def disk_lamp_in_the_way(check):
    """Whose sphere reaches into a ball that does not bend light, with a black wall within it: light starts at the disk that
    a place sees, so the ball's top is lit from within the sphere, and the wall hides a part of it."""
    lamp = {"name": "Lamp", "type": "point", "power_w": 100.0, "radius_m": 0.6, "body": "disk",
            "look": {"from": [0, 0, 1.35], "to": [0, 0, 0]}}
    things = [plane("Floor", [4, 4], [0, 0, 0]), ball("Ball", 0.4, [0, 0, 0.5], "air"),
              box("Wall", [0.02, 0.8, 0.4], [-0.12, 0, 1.2], "black")]
    s = scene(look_camera([4, 0, 4], [0.6, 0, 0], 3, [48, 48]), things, [lamp])

    def mean(estimator, n, seed):
        words = ("--estimator", estimator, "--photons", n, "--seed", seed, "--effects", "direct", "--layers", "radiance")
        return run(s, *words)["caustics_Lamp"].mean()

    found = over_seeds(range(1, 5), lambda seed: {e: mean(e, n, seed) for e, n in (("R", 1e6), ("P", 4e5), ("W", 1e6))})
    for e in "PW":
        check.close(f"disk lamp that reaches into a ball, {e} against R", found[e], found["R"].mean, 0.01 * found["R"].mean, 0.01)


def peak_kb(photons):
    """Of a child of its own: its greatest resident set."""
    code = ("import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True); "
            "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
    path = os.path.join(SOURCE, "scenes", "a_ball.json")
    out = os.path.join(FOLDER.name, f"memory{photons}.exr")
    done = subprocess.run([sys.executable, "-c", code, PROGRAM, path, "-o", out, "--photons", str(photons), "--quiet",
                           "--resolution", "32x18", "--threads", "2", "--estimator", "P"],
                          capture_output=True, text=True, check=True)
    return int(done.stdout)


def memory(check, few, many):
    a, b = peak_kb(few), peak_kb(many)
    check.that(abs(b / a - 1) <= 0.1, f"peak memory: {a / 1024:.1f} MiB at {few:.0e} photons, {b / 1024:.1f} at {many:.0e}")


if __name__ == "__main__":
    found = Check()
    if sys.argv[1:2] == ["memory"]:
        memory(found, int(float(sys.argv[2])), int(float(sys.argv[3])))
    else:
        for which in "PR":
            alone_and_together(found, which)
            twice_as_strong(found, which)
        disk_lamp(found)
        disk_lamp_in_the_way(found)
        sum_rule(found)
        threads(found)
    found.end()
