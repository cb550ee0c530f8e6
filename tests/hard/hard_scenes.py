# SPDX-License-Identifier: Apache-2.0
"""Numerically hard cases that show in a picture. Rows: the numbers of the list in docs/testing.md; the rows about rays,
rounding and random numbers alone are in test_rays.c.

  2 tiny, huge and far scenes       7 ior near 1             8 the threshold of total reflection
  9 suns of any size                10 roughness near 0      13 mirrored and scaled scenes
  14 camera in water, lamp in glass 18 half overflow         28 passes and seeds"""
import copy
import math
import sys

import numpy as np
import OpenImageIO as oiio

import truth
from rig import (Check, Figure, ball, blocks, box, down_camera, look_camera, plane, run, scene, sun)


def figure(s, layer, *words):
    return run(s, "--layers", "radiance", "--effects", "direct", *words)[layer][:, :, 1]


# ---- row 2 ----

def moved(s, scale, offset):
    """The same scene, every length times `scale`, everything moved by `offset` metres along x and y."""
    out = copy.deepcopy(s)

    def point(p):
        return [p[0] * scale + offset, p[1] * scale + offset, p[2] * scale]

    for item in [out["camera"]] + out["lights"]:
        item["look"] = {k: point(v) for k, v in item["look"].items()}
    for key in ("ortho_width",):
        out["camera"][key] *= scale
    out["camera"]["clip"] = [c * scale for c in out["camera"]["clip"]]
    for o in out["objects"]:
        o["position"] = point(o["position"])
        o["scale"] = scale
    for light in out["lights"]:
        if light["type"] == "area":
            light["size"] = [v * scale for v in light["size"]]
            light["power_w"] *= scale**2
    return out


def tiny_and_far(check):
    lamp = {"name": "Sun", "type": "area", "shape": "rectangle", "size": [0.3, 0.3], "power_w": 20,
            "look": {"from": [0.5, -0.25, 2], "to": [0, 0, 0.5]}}
    base = scene(down_camera(0, 0, 0.125, 2, [32, 32]),
                 [plane("Floor", [3, 3], [0, 0, 0]), ball("Ball", 0.25, [0.25, 0, 0.5]),
                  {"name": "Mesh", "shape": {"type": "sphere", "radius": 0.25, "segments": 48}, "position": [-0.375, 0, 0.5],
                   "material": "glass"}], [lamp])
    words = ["--photons", 100000, "--estimator", "P"]
    want = figure(base, "caustics_Sun", *words)
    for scale, offset in ((1e-6, 0), (2.0**-20, 0), (1e6, 0), (2.0**20, 0), (1, 1e6), (1, 2.0**20), (1e6, 1e6), (2.0**20, 2.0**20)):
        e = figure(moved(base, scale, offset), "caustics_Sun", *words)
        off = np.abs(e - want)
        # A photon that rounds into another pixel's kernel is all that may differ.
        ok = np.sqrt((off**2).mean()) <= 1e-3 * np.sqrt((want**2).mean())
        check.that(ok, f"row 2: scene times {scale:g} plus {offset:g} m: RMS difference {np.sqrt((off**2).mean() / (want**2).mean()):.1e},"
                   f" {'the same to the bit' if not off.any() else f'largest {off.max() / want.max():.1e} of the brightest'}")
    # Given in double, 1e-6 large and 1e6 away is beyond what even double holds (1e-10): a centimetre there is not.
    e = figure(moved(base, 1e-2, 1e6), "caustics_Sun", *words)
    check.that(abs(e.mean() / want.mean() - 1) < 2e-3, f"row 2: scene times 0.01, 1e6 m away: mean {e.mean() / want.mean():.5f} of it")


# ---- rows 7 to 10 ----

def sheet(material, direction, angle=0.0, materials=None):
    return scene(down_camera(0, 0, 0.05, 0.2, [8, 8]),
                 [plane("Floor", [2, 2], [0, 0, 0]), box("Slab", [1, 1, 0.1], [0, 0, 0.2], material)],
                 [sun(direction, angle=angle)], materials=materials)


def ior_near_one(check):
    words = ["--photons", 100000, "--estimator", "P"]
    for ior in (1.0, 1 + 1e-7, 1 - 1e-7, 1 + 9.9e-5, 1 + 1.01e-4, 1 - 1.01e-4, 1.001, 0.999):
        s = sheet("near", [0.5, 0, -math.sqrt(0.75)], materials={"near": {"type": "glass", "color": [1, 1, 1], "ior": ior}})
        e = math.pi * figure(s, "caustics_Sun", *words)
        check.that(abs(e.mean() / math.sqrt(0.75) - 1) < 0.006, f"row 7: ior {ior!r}: E {e.mean():.5f}, S cos = {math.sqrt(0.75):.5f}")
    # Grazing: the usual formula calls an interface of ior 1 a mirror there.
    s = sheet("air", [1, 0, -0.02])
    r = run(s, *words, "--effects", "direct")
    flux = r.light()["flux_direct"]
    check.that(flux["absorbed_w"] == 0 and flux["non_finite"] == 0 and flux["dropped_w"] == 0, "row 7: ior 1 at 89 degrees: nothing lost")


def total_reflection(check):
    """A plane of relative ior 1 / 1.5 under light at the critical angle and a few ulp beside it."""
    critical = math.asin(1 / 1.5)
    bright = []
    for name, angle in [("critical", critical)] + [(f"{k:+d} ulp", critical + k * 2**-53) for k in (-8, -2, -1, 1, 2, 8)] + \
            [("- 1e-3", critical - 1e-3), ("+ 1e-3", critical + 1e-3)]:
        s = scene(down_camera(0, 0, 0.05, 0.5, [8, 8]), [plane("Floor", [8, 8], [0, 0, 0]), plane("Face", [8, 8], [0, 0, 0.1], "out")],
                  [sun([math.sin(angle), 0, -math.cos(angle)])], materials={"out": {"type": "glass", "color": [1, 1, 1], "ior": 1 / 1.5}})
        r = run(s, "--photons", 30000, "--estimator", "P", "--effects", "direct", "--layers", "radiance")
        e, flux = r["caustics_Sun"], r.light()["flux_direct"]
        total = sum(flux[k] for k in ("landed_w", "straight_w", "absorbed_w", "escaped_w", "cut_w", "bent_w", "dropped_w"))
        # Where the plan's probes saw nothing pass, nothing was emitted.
        gap = abs(total - flux["emitted_w"]) / max(flux["emitted_w"], 1e-30)
        ok = np.isfinite(e).all() and flux["non_finite"] == 0 and gap < 1e-9
        check.that(ok, f"row 8: {name} from the critical angle: finite, R + T - 1 = {gap:.0e}, E {e.mean():.4f}")
        bright.append(e.mean())
    check.that(bright[-1] == 0 and bright[-2] > 0.01, f"row 8: light passes below ({bright[-2]:.4f}) and none above the threshold")


def suns(check):
    """A ball of ior 1 catches S pi r^2 of any sun; every photon of a ball target carries the same."""
    for angle in (0, 1e-7, 1e-4, 0.01, 0.2, 0.533, 5, 90, 179):
        s = scene(down_camera(0, 0, 0.01, 4, [8, 8]), [plane("Floor", [40, 40], [0, 0, 0]), ball("Ball", 0.5, [0, 0, 1], "air")],
                  [sun([0, 0, -1], 3, angle)])
        r = run(s, "--photons", 20000, "--estimator", "P", "--effects", "direct", "--layers", "radiance")
        emitted, want = r.light()["flux_direct"]["emitted_w"], 3 * math.pi * 0.25
        # Beyond a beam, the ball sees the sun's disk whole: per unit of irradiance it catches pi r^2 / mean cosine.
        half = math.radians(angle / 2)
        want *= 2 / (1 + math.cos(half))
        check.that(abs(emitted / want - 1) <= 1e-4, f"row 9: sun of {angle:g} degrees: flux on a ball {emitted:.6f} W, exact {want:.6f}")


def rough_to_smooth(check):
    """The flux that a mirror and a glass ball throw on the floor, over the switch from rough to smooth."""
    for kind in ("metal", "glass"):
        flux = {}
        for rough in (0, 1e-4, 3e-3, 5e-3, 1e-2, 3.2e-2, 5e-2):
            m = {"type": kind, "color": [0.9] * 3, "roughness": rough}
            s = scene(down_camera(0, 0, 0.05, 8, [8, 8]), [plane("Floor", [20, 20], [0, 0, 0]), ball("Ball", 0.5, [0, 0, 1], "m")],
                      [sun([1, 0, -1])], materials={"m": m})
            r = run(s, "--photons", 60000, "--estimator", "P", "--effects", "direct", "--layers", "radiance")
            account = r.light()["flux_direct"]
            flux[rough] = account["landed_w"]
            check.that(account["non_finite"] == 0 and np.isfinite(r["caustics_Sun"]).all(), f"row 10: {kind}, roughness {rough:g}: finite")
        spread = max(flux.values()) / min(flux.values()) - 1
        check.that(spread <= 0.005, f"row 10: {kind}: landed {flux[0]:.5f} W smooth, spread {100 * spread:.2f} % up to roughness 0.05")


# ---- row 13 ----

def matrix(*rows):
    return [list(r) for r in rows] + [[0, 0, 0, 1]]


def mirrored(check):
    """A scene and its mirror image in x: the picture is mirrored too. Sheared, turned and stretched objects."""
    turn = np.array([[0.8, -0.6, 0.1], [0.5, 0.7, -0.3], [0.2, 0.3, 0.6]]) * 0.5
    flip = np.diag([-1.0, 1, 1])

    def build(m):
        def place(linear, at):
            a, p = m @ linear, m @ np.array(at)
            return matrix(*[list(a[i]) + [p[i]] for i in range(3)])
        look = {"from": list(m @ [0.6, -2, 1.6]), "to": list(m @ [0.0, 0, 0.3])}
        camera = {"type": "perspective", "look": look, "hfov_deg": 45, "resolution": [48, 32], "filter": {"type": "box", "width": 1}}
        egg = {"name": "Egg", "shape": {"type": "sphere", "radius": 0.6}, "material": "glass", "matrix": place(turn, [0.5, 0.2, 0.5])}
        facets = {"name": "Facets", "shape": {"type": "sphere", "radius": 0.5, "segments": 24}, "material": "glass",
                  "matrix": place(turn.T, [-0.4, 0.1, 0.4])}
        block = {"name": "Block", "shape": {"type": "box", "size": [0.4, 0.3, 0.5]}, "material": "mirror",
                 "matrix": place(turn, [0.1, 0.6, 0.3])}
        lamp = {"name": "Sun", "type": "area", "shape": "rectangle", "size": [0.5, 0.5], "power_w": 30,
                "look": {"from": list(m @ [1.0, -0.5, 2]), "to": list(m @ [0.0, 0, 0.3])}}
        floor = {"name": "Floor", "shape": {"type": "plane", "size": [4, 4]}, "material": "white", "matrix": place(np.eye(3), [0, 0, 0])}
        return scene(camera, [floor, egg, facets, block], [lamp])

    # Eight seeds each: blocks of the difference against its own standard error.
    diff = [blocks(figure(build(np.eye(3)), "caustics_Sun", "--photons", 60000, "--estimator", "P", "--seed", k)
                   - figure(build(flip), "caustics_Sun", "--photons", 60000, "--estimator", "P", "--seed", 100 + k)[:, ::-1], 8)
            for k in range(1, 9)]
    mean, error = np.mean(diff, axis=0), np.std(diff, axis=0, ddof=1) / math.sqrt(8)
    scale = figure(build(np.eye(3)), "caustics_Sun", "--photons", 60000, "--estimator", "P").mean()
    wrong = np.abs(mean) > 5.4 * error + 1e-3 * scale
    check.that(not wrong.any(), f"row 13: mirrored scene: {wrong.sum()} of {wrong.size} blocks differ; total by"
               f" {100 * mean.mean() / scale:+.2f} +- {100 * 2.4 * np.std([d.mean() for d in diff], ddof=1) / math.sqrt(8) / scale:.2f} %")


def scaled_lamp(check):
    """A lamp's matrix that scales: an area light is as large as its size times the scale; its power is its power."""
    def with_lamp(size, scale):
        m = np.diag([float(scale)] * 3)
        lamp = {"name": "Sun", "type": "area", "shape": "rectangle", "size": [size, size], "power_w": 30,
                "matrix": matrix(*[list(m[i]) + [[0.2, 0, 2][i]] for i in range(3)])}
        return scene(down_camera(0, 0, 0.2, 2, [16, 16]), [plane("Floor", [4, 4], [0, 0, 0]), ball("Ball", 0.4, [0, 0, 0.7])], [lamp])
    a, b = (figure(with_lamp(*v), "caustics_Sun", "--photons", 50000, "--estimator", "P") for v in ((0.5, 1), (0.25, 2)))
    check.that(np.allclose(a, b, rtol=1e-6, atol=1e-9), "row 13: a lamp scaled by 2 is a lamp of twice the size and the same power")


# ---- row 14 ----

def snell(check):
    """From under water the sky fills a window of 48.6 degrees, as bright as Fresnel lets through; outside it the black
    walls are mirrored. (Radiance is not scaled by n^2, as in Cycles.)"""
    size, n = 64, 1.333
    camera = {"type": "perspective", "look": {"from": [0, 0, -0.5], "to": [0, 0, 1]}, "hfov_deg": 110, "resolution": [size, size],
              "filter": {"type": "box", "width": 1}}
    s = scene(camera, [box("Water", [200, 200, 10], [0, 0, -5], "water"), plane("Ground", [199, 199], [0, 0, -9], "black"),
                       plane("Far", [2, 2], [50, 50, -3])], [], world=1.0,
              materials={"water": {"type": "glass", "color": [1, 1, 1], "ior": n}})
    e = run(s, "--estimator", "R", "--photons", 64 * 64 * 64, "--layers", "beauty")[""][:, :, 1]
    at = ((np.arange(size) + 0.5) / size * 2 - 1) * math.tan(math.radians(55))
    cosine = 1 / np.sqrt(1 + at[None, :]**2 + at[:, None]**2)
    want = 1 - truth.fresnel(cosine, 1 / n)
    angle = np.degrees(np.arccos(cosine))
    inside, outside = angle < 46, (angle > 50) & (angle < 60)
    off = (e - want)[inside]
    check.that(abs(off.mean()) < 0.004 and abs(off).max() < 0.25, f"row 14: Snell's window: mean {off.mean():+.4f} off, worst pixel {abs(off).max():.3f}")
    check.that(e[outside].max() < 1e-3, f"row 14: outside the window {e[outside].max():.4f}")


def lamp_in_bulb(check):
    """A lamp in a glass bulb in a closed room: all of its light arrives."""
    def bulb(radius):
        lamp = {"name": "Sun", "type": "point", "power_w": 10, "radius_m": radius, "look": {"from": [0.05, 0.02, 1], "to": [0, 0, 0]}}
        # `ior` is relative to what surrounds: the inner face has air in front of it seen from the glass.
        return scene(down_camera(0, 0, 0.5, 2, [8, 8]),
                     [box("Room", [2, 2, 2], [0, 0, 1], "dim"), ball("Outer", 0.3, [0, 0, 1]), ball("Inner", 0.25, [0, 0, 1], "cavity")],
                     [lamp], materials={"dim": {"type": "diffuse", "color": [0.1] * 3},
                               "cavity": {"type": "glass", "color": [1, 1, 1], "ior": 1 / 1.5}})
    for radius in (0, 0.1):
        r = run(bulb(radius), "--estimator", "P", "--photons", 60000, "--effects", "direct", "--layers", "radiance")
        flux = r.light()["flux_direct"]
        check.that(abs(flux["emitted_w"] / 10 - 1) < 1e-6 and flux["escaped_w"] == 0 and flux["straight_w"] == 0 and
                   abs(flux["landed_w"] / 10 - 1) < 1e-3, f"row 14: lamp of radius {radius} in a bulb: 10 W emitted, {flux['landed_w']:.5f} W landed,"
                   f" {flux['escaped_w']:g} escaped, {flux['dropped_w']:.1e} dropped")


# ---- row 18 ----

def half_overflow(check):
    """Values beyond half's 65504: clamped, counted; in float they stay. None is ever Inf or NaN."""
    for strength in (1e5, 1e10, 1e15):
        s = scene(down_camera(0, 0, 0.05, 0.5, [16, 16]), [plane("Floor", [4, 4], [0, 0, 0]), ball("Ball", 0.5, [0, 0, 0.6])],
                  [sun([0, 0, -1], strength)])
        words = ["--photons", 30000, "--estimator", "P", "--layers", "radiance,error", "--effects", "direct"]
        full, half = run(s, *words), run(s, *words, "--type", "half")
        finite = all(np.isfinite(r[k]).all() for r in (full, half) for k in r.layers)
        over = sum(int((np.abs(full[k]) > 65504).sum()) for k in full.layers)
        head = {r: oiio.ImageInput.open(r.path).spec() for r in (full, half)}
        clamped, repaired = (head[half].getattribute(f"caustics/{k}") for k in ("clamped", "repaired_nan"))
        check.that(finite, f"row 18: sun of {strength:g} W/m2: every pixel finite")
        check.that(clamped == over and over > 0, f"row 18: {clamped} values clamped to half, {over} of the float file are beyond it")
        check.that(repaired == 0 and max(half[k].max() for k in half.layers) == 65504,
                   "row 18: clamped to 65504, nothing else repaired")


# ---- row 28 ----

def seeds(check):
    """Noise of seeds is independent, and a render knows its own: the squared difference of two seeds over the sum of
    their stated variances is 1 on average (chi-square). Twice half is the whole."""
    s = scene(down_camera(0, 0, 0.05, 1, [24, 24]), [plane("Floor", [4, 4], [0, 0, 0]), ball("Ball", 0.5, [0, 0, 0.6], "mirror"),
                                                     ball("Glass", 0.2, [0.3, 0.2, 0.4])],
              [{"name": "Sun", "type": "area", "shape": "disk", "size": [1, 1], "power_w": 30,
                "look": {"from": [1, 0, 2], "to": [0, 0, 0.5]}}])
    for estimator, n in (("P", 400000), ("R", 24 * 24 * 64)):
        words = ["--estimator", estimator, "--layers", "radiance,error", "--effects", "direct"]
        whole = [run(s, *words, "--photons", n, "--seed", k) for k in range(1, 9)]
        half = [run(s, *words, "--photons", n // 2, "--seed", k) for k in range(21, 37)]
        image = np.array([r["caustics_Sun"][:, :, 1] for r in whole])
        stated = np.mean([r["caustics_Sun_err"][:, :, 1]**2 for r in whole], axis=0)
        lit = stated > 0
        chi = float(image.var(axis=0, ddof=1)[lit].sum() / stated[lit].sum())
        check.that(0.7 < chi < 1.35, f"row 28: {estimator}: variance over seeds is {chi:.3f} of what the renders state of themselves")
        noise = image - image.mean(axis=0)
        a, b = noise[0::2].reshape(4, -1), noise[1::2].reshape(4, -1)
        # The mean was taken off: two of 8 seeds then correlate by -1/7.
        correlation = [float(np.corrcoef(x, y)[0, 1]) + 1 / 7 for x, y in zip(a, b)]
        check.that(abs(np.mean(correlation)) < 0.15, f"row 28: {estimator}: neighbouring seeds correlate by {np.mean(correlation):+.3f}")
        pairs = np.array([(half[i]["caustics_Sun"] + half[i + 1]["caustics_Sun"])[:, :, 1] / 2 for i in range(0, 16, 2)])
        gap = Figure([p.mean() - w.mean() for p, w in zip(pairs, image)])
        bias = 0.01 * image.mean() if estimator == "P" else 0
        check.that(gap.agrees(0, bias), f"row 28: {estimator}: 2 x N/2 - N = {gap.mean:+.2e} +- {gap.half_width():.1e} of {image.mean():.3f}")
        spread = float(pairs.var(axis=0, ddof=1).sum() / image.var(axis=0, ddof=1).sum())
        check.that(0.6 < spread < 1.7, f"row 28: {estimator}: variance of 2 x N/2 is {spread:.3f} of that of N")


ROWS = [tiny_and_far, ior_near_one, total_reflection, suns, rough_to_smooth, mirrored, scaled_lamp, snell, lamp_in_bulb,
        half_overflow, seeds]

if __name__ == "__main__":
    found = Check()
    for row in ROWS:
        if len(sys.argv) < 2 or row.__name__ in sys.argv[1:]:
            row(found)
            sys.stdout.flush()
    found.end()
