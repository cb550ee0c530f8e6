# SPDX-License-Identifier: Apache-2.0
"""CPU seconds to an error, W beside P and POV-Ray, where the answer is known: ball lens, mirror ring, water.

usage: peers.py [--threads N] [--suns delta,0.53] [--cache FOLDER] [SCENE...]     (default: every scene, both suns)

Scenes: exact, 64x32, 256x128, 1024x512, flat (a glass ball of radius 1, n = 1.5, its focus on the floor; as an exact
shape, as smooth meshes, and 64x32 with flat faces), ring (a mirror of radius 1 and height 1.2, sun 50 degrees off zenith),
water (601 x 601 vertices, 8 sines, depth 1, sun 20 degrees off zenith). 512x512 pixels straight down, no more than light,
caster, floor, camera; radiance as in nature (--physical: water). relMSE = mean (x - t)^2 / (t^2 + 0.01 mean(t)^2), a rim of 2 pixels cut. Truth t: the quadrature of
ball.py for the exact ball and for 1024x512 under the sun without extent; else W, another seed, with 4 times the rays of
the longest rung: it shares W's method, and what it does not know bounds the last rung.

CPU seconds are user time of the whole program; after the slash without loading and planning (--explain). Between
two rungs of the ladder the time is interpolated in logarithms, beyond the last extrapolated by the last two, where
the error has not fallen at every rung by the first and the last (marked ~); "-" where it does not fall. POV-Ray (Debian's povray): photon maps of 1, 4 and 16 million photons, sun without
extent alone; without loading: less the time with 1000 photons.

CAUSTIC_RENDER names the program; else build/bin/caustic-render."""
import argparse
import json
import math
import os
import resource
import shutil
import subprocess
import sys

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
os.environ.setdefault("CAUSTIC_RENDER", os.path.join(ROOT, "build", "bin", "caustic-render"))
sys.path.insert(0, os.path.join(ROOT, "tests", "exact"))
import ball as exact_ball  # noqa: E402
import povray  # noqa: E402
from rig import FOLDER, PROGRAM, down_camera, plane, run, scene, sun  # noqa: E402

SIZE, RIM, TARGETS = 512, 2, (1e-2, 1e-3, 1e-4)
LADDER = {"W": [1e4, 4e4, 1.6e5, 6.4e5, 2.56e6], "P": [1e5, 4e5, 1.6e6], "POV-Ray": [1e6, 4e6, 1.6e7]}
ENOUGH_S, TRUTH_RAYS = 25, 4 * 2.56e6
LIMITS = {"total": 16, "diffuse": 4, "glossy": 0, "transmission": 16}

# Published: peers.md's rows of pbrt-v3's SPPM, measured on the same scenes (delta sun) on another day and machine.
PBRT = {"exact": "pbrt-v3 SPPM, exact ball: 10.1 s to 7.7e-3, 34.9 s to 2.3e-3 (exponent 1)",
        "water": "pbrt-v3 SPPM, water of 513x513: 8.1 s to 7.6e-2, 31.5 s to 5.4e-2, 28.7 s to 4.1e-2 (exponent 0.25)"}


def lens(shape, angle, flat=False):
    """ball.py's scene with another ball and sun."""
    out = exact_ball.ball_scene()
    for o in out["objects"]:
        if o["name"] == "Ball" and shape:
            o["shape"]["segments"] = shape
            o["smooth"] = not flat
    out["lights"] = [sun([0, 0, -1], angle=angle)]
    return out


def ring(angle):
    tilt = math.radians(50)
    mirror = {"name": "Ring", "shape": {"type": "cylinder", "radius": 1, "height": 1.2}, "material": "mirror"}
    return scene(down_camera(0, 0, 3, 1.4, [SIZE, SIZE]), [plane("Floor", [8, 8], [0, 0, 0]), mirror],
                 [sun([-math.sin(tilt), 0, -math.cos(tilt)], angle=angle)],
                 {"total": 2, "diffuse": 1, "glossy": 0, "transmission": 0})


# Eight sines of curvature 1.2 each: the caustic has folds.
WAVES = [{"amplitude": 1.2 / k**2, "k": k, "direction_rad": d, "phase": p} for k, d, p in
         ((3.1, 0.3, 0.0), (4.3, 1.2, 1.0), (5.9, 2.2, 2.0), (7.3, 4.0, 0.5), (8.7, 5.2, 3.0), (10.1, 0.9, 4.0),
          (12.7, 3.1, 5.0), (14.9, 4.7, 6.0))]


def water(angle):
    tilt = math.radians(20)
    sheet = {"name": "Water", "shape": {"type": "heightfield", "size": [4, 4], "waves": WAVES, "segments": 600},
             "position": [0, 0, 1], "material": "water"}
    return scene(down_camera(0, 0, 0.5, 2, [SIZE, SIZE]), [plane("Floor", [8, 8], [0, 0, 0]), sheet],
                 [sun([-math.sin(tilt), 0, -math.cos(tilt)], angle=angle)], LIMITS,
                 {"water": {"type": "glass", "color": [1, 1, 1], "ior": 1.33}})


SCENES = {"exact": lambda a: lens(0, a), "64x32": lambda a: lens(64, a), "256x128": lambda a: lens(256, a),
          "1024x512": lambda a: lens(1024, a), "flat": lambda a: lens(64, a, True), "ring": ring, "water": water}


def render(s, estimator, rays, threads, seed=0):
    """(irradiance, user CPU seconds)"""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    r = run(s, "--estimator", estimator, "--photons", int(rays), "--effects", "direct", "--layers", "radiance", "--threads",
            threads, "--seed", seed, "--physical")
    return math.pi * r["caustics_Sun"][:, :, 1], resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def loading(s, threads):
    """User CPU seconds until the plan stands."""
    path = os.path.join(FOLDER.name, "loading.json")
    if isinstance(s, dict):
        with open(path, "w", encoding="utf-8") as file:
            json.dump(s, file)
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([PROGRAM, path if isinstance(s, dict) else s, "--explain", "--effects", "direct", "--threads", str(threads)], check=True,
                   capture_output=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def truth(name, angle, s, cache, threads):
    """(picture, words)"""
    os.makedirs(cache, exist_ok=True)
    exact = name in ("exact", "1024x512") and angle == 0
    path = os.path.join(cache, f"{'ball' if exact else name}_{angle}.npy")
    if not os.path.exists(path):
        picture = exact_ball.truth() if exact else render(s, "W", TRUTH_RAYS, threads, seed=77)[0]
        np.save(path, picture.astype(np.float32))
    return np.load(path).astype(float), "exact" if exact else "W"


def rel_mse(x, t):
    inside = (slice(RIM, -RIM), slice(RIM, -RIM))
    x, t = x[inside], t[inside]
    return float(((x - t)**2 / (t**2 + 0.01 * t.mean()**2)).mean()), float(x.mean() / t.mean())


def time_to(rows, target, column):
    """Seconds to the target, interpolated or extrapolated in logarithms; words."""
    points = [(max(r[column], 1e-3), r["error"]) for r in rows]
    if points[0][1] <= target:
        return f"<= {points[0][0]:.2f}"
    steady = all(a[1] > b[1] for a, b in zip(points, points[1:]))
    for i in range(1, len(points)):
        (s0, e0), (s1, e1) = points[i - 1], points[i]
        last = i == len(points) - 1
        if e1 > target and last and not steady:
            s0, e0 = points[0]
        if e1 <= target or last:
            slope = math.log(s1 / s0) / math.log(e1 / e0) if s1 > s0 and e1 < e0 else 0
            if slope >= 0:
                return "-"
            seconds = s1 * math.exp(slope * math.log(target / e1))
            return f"{'~' if e1 > target else ''}{seconds:.3g}"
    return "-"


def ladder(name, s, estimator, t, fixed, threads):
    rows = []
    for rays in LADDER[estimator]:
        if estimator == "POV-Ray":
            picture, seconds = povray.render(name, s, rays, SIZE)
        else:
            picture, seconds = render(s, estimator, rays, threads)
        error, energy = rel_mse(picture, t)
        rows.append({"rays": rays, "whole": seconds, "bare": max(seconds - fixed, 1e-3), "error": error, "energy": energy})
        if error < TARGETS[-1] or seconds > ENOUGH_S:
            break
    return rows


def measure(name, angle, cache, threads):
    s = SCENES[name](angle)
    t, how = truth(name, angle, s, cache, threads)
    fixed = loading(s, threads)
    estimators = ["W", "P"] + (["POV-Ray"] if angle == 0 and shutil.which("povray") and name in povray.SCENES else [])
    for e in estimators:
        if e == "POV-Ray":
            fixed = povray.render(name, s, 1000, SIZE)[1]
        rows = ladder(name, s, e, t, fixed, threads)
        steps = "; ".join(f"{r['whole']:.2f} s {r['error']:.1e}" for r in rows)
        cells = [f"{time_to(rows, target, 'whole')} / {time_to(rows, target, 'bare')}" for target in TARGETS]
        print(f"| {name} | {angle or 'none'} | {e} | {steps} | {' | '.join(cells)} | {rows[-1]['energy']:.4f} | {how} |", flush=True)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("scenes", nargs="*", metavar="SCENE", default=list(SCENES))
    p.add_argument("--threads", type=int, default=1)
    p.add_argument("--suns", default="0,0.53")
    p.add_argument("--cache", default=os.path.join(ROOT, "build", "peers"))
    a = p.parse_args()
    print("| scene | sun, degrees | estimator | CPU s and relMSE | to 1e-2 | to 1e-3 | to 1e-4 | energy | truth |\n" + "|---" * 9 + "|")
    for name in a.scenes:
        for angle in (float(w) for w in a.suns.split(",")):
            measure(name, angle, a.cache, a.threads)
    for line in PBRT.values():
        print(line)


if __name__ == "__main__":
    main()
