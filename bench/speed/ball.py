# SPDX-License-Identifier: Apache-2.0
"""Error against CPU time where the answer is known: a glass ball that focuses a sun without extent on the floor.

usage: ball.py [--threads N] [RAYS...]     (default 3e4 1e5 4e5 1.6e6)

A ball of radius 1, n = 1.5, at height 1.5; its focus lies on the floor exactly. 512x512 pixels over 1.3 m, straight
transmission alone. The truth is a quadrature over 4e7 rays of the closed form of one ray, averaged over each pixel.
relMSE = mean (x - t)^2 / (t^2 + 0.01 mean(t)^2), a rim of 2 pixels cut; trimmed: without the worst 1 % of the pixels.
Flux: of all but the 12x12 pixels around the focus, whose truth is good to some per cent only.
CPU seconds are user time of the whole program, loading and writing included.

CAUSTIC_RENDER names the program; else build/bin/caustic-render."""
import argparse
import math
import os
import resource
import sys

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
os.environ.setdefault("CAUSTIC_RENDER", os.path.join(ROOT, "build", "bin", "caustic-render"))
sys.path.insert(0, os.path.join(ROOT, "tests", "exact"))
from rig import ball, down_camera, plane, run, scene, sun  # noqa: E402

SIZE, WIDTH, INDEX, HEIGHT, RAYS, BINS, SUBPIXELS, RIM = 512, 1.3, 1.5, 1.5, 40_000_000, 200_000, 32, 2


def landed():
    """Cumulative flux within a radius on the floor, in BINS steps of [0, 1]; the sun gives 1 W/m2."""
    sine = np.sqrt((np.arange(RAYS) + 0.5) / RAYS)  # distance from the axis: even in area
    refracted = np.arcsin(sine / INDEX)
    ci, ct = np.sqrt(1 - sine**2), np.cos(refracted)
    rs, rp = (ci - INDEX * ct) / (ci + INDEX * ct), (INDEX * ci - ct) / (INDEX * ci + ct)
    transmitted = (1 - (rs**2 + rp**2) / 2)**2
    turn = 2 * (np.arcsin(sine) - refracted)
    around = np.arcsin(sine) + math.pi - 2 * refracted  # from the top, where the ray leaves the ball
    radius = np.abs(np.sin(around) - np.tan(turn) * (np.cos(around) + HEIGHT))
    flux, edges = np.histogram(radius, bins=BINS, range=(0, 1), weights=transmitted * math.pi / RAYS)
    return edges, np.concatenate([[0], np.cumsum(flux)])


def truth():
    edges, flux = landed()
    at = (np.arange(SIZE * SUBPIXELS) + 0.5) / (SIZE * SUBPIXELS) * WIDTH - WIDTH / 2
    step, out = 2e-4, np.zeros((SIZE, SIZE))
    for row in range(SIZE):
        r = np.hypot(at[row * SUBPIXELS:(row + 1) * SUBPIXELS, None], at[None, :])
        inner, outer = np.clip(r - step, 0, 1), np.clip(r + step, 0, 1)
        e = (np.interp(outer, edges, flux) - np.interp(inner, edges, flux)) / (math.pi * (outer**2 - inner**2))
        out[row] = e.reshape(SUBPIXELS, SIZE, SUBPIXELS).mean((0, 2))
    return out


def ball_scene():
    """A sheet of ior 1 is the scattering next to the sun, to which no limit applies; glossy 0 then cuts reflections."""
    sheet = {"name": "Sheet", "shape": {"type": "lathe", "profile": [[0, 0], [1.2, 0]], "segments": 256},
             "position": [0, 0, 3], "material": "air"}
    return scene(down_camera(0, 0, 0.4, WIDTH, [SIZE, SIZE]),
                 [plane("Floor", [8, 8], [0, 0, 0]), ball("Ball", 1, [0, 0, HEIGHT]), sheet], [sun([0, 0, -1])],
                 {"total": 16, "diffuse": 4, "glossy": 0, "transmission": 16})


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("rays", nargs="*", default=["3e4", "1e5", "4e5", "1.6e6"])
    p.add_argument("--threads", type=int, default=1)
    a = p.parse_args()
    exact, inside = truth(), (slice(RIM, -RIM), slice(RIM, -RIM))
    far = np.ones((SIZE, SIZE), bool)
    far[SIZE // 2 - 6:SIZE // 2 + 6, SIZE // 2 - 6:SIZE // 2 + 6] = False
    far = far[inside]
    print("| estimator | rays or photons | CPU s | relMSE | trimmed | flux |\n|---|---|---|---|---|---|")
    for estimator in "WP":
        for rays in a.rays:
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            r = run(ball_scene(), "--estimator", estimator, "--photons", rays, "--effects", "direct", "--layers",
                    "radiance", "--threads", a.threads)
            seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
            t, x = exact[inside], math.pi * r["caustics_Sun"][:, :, 1][inside]
            error = np.sort(((x - t)**2 / (t**2 + 0.01 * t.mean()**2)).ravel())
            print(f"| {estimator} | {rays} | {seconds:.2f} | {error.mean():.1e} | "
                  f"{error[:int(0.99 * error.size)].mean():.1e} | {x[far].mean() / t[far].mean():.4f} |", flush=True)


if __name__ == "__main__":
    main()
