#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Do frames flicker? A glass ball under a sun that moves a quarter of a degree per frame, 48 frames by --frames.

Flicker is the second difference in time, (f[t-1] - 2 f[t] + f[t+1]) / sqrt(6): noise that is new in each frame gives its own
standard deviation, noise that moves with the picture less, the truth what it bends. Beside it the error in space: the difference of
two seeds, / sqrt(2). All as RMS over pixels and frames, relative to the RMS of the picture.

usage: flicker.py CAUSTIC_RENDER SCENES_FOLDER [--photons N] [--frames N] [--resolution WxH]
Needs numpy and OpenImageIO for Python (Debian: python3-numpy python3-openimageio)."""
import argparse
import json
import math
import os
import subprocess
import tempfile

import numpy as np
import OpenImageIO as oiio

p = argparse.ArgumentParser()
p.add_argument("program")
p.add_argument("scenes")
p.add_argument("--photons", type=int, default=100000)
p.add_argument("--frames", type=int, default=48)
p.add_argument("--resolution", default="96x54")
p.add_argument("--degrees", type=float, default=0.25)
a = p.parse_args()


def read(path):
    file = oiio.ImageInput.open(path)
    image = np.asarray(file.read_image("float"), dtype=float)[..., :3]
    file.close()
    return image


def write_scenes(folder):
    with open(os.path.join(a.scenes, "a_ball.json")) as f:
        scene = json.load(f)
    for t in range(a.frames):
        turn = math.radians(a.degrees * t)
        scene["lights"][0]["look"]["from"] = [5 * math.cos(turn), 5 * math.sin(turn), 5 * math.sqrt(3)]
        with open(os.path.join(folder, f"shot.{t:04d}.json"), "w") as f:
            json.dump(scene, f)


def frames(folder, name, estimator, photons, seeds):
    """All frames; seeds: one for all, or a function of the frame."""
    out = os.path.join(folder, name + ".####.exr")
    command = [a.program, os.path.join(folder, "shot.####.json"), "-o", out, "--estimator", estimator,
               "--photons", str(photons), "--resolution", a.resolution, "--effects", "direct", "--quiet"]
    if callable(seeds):
        for t in range(a.frames):
            subprocess.run([*command, "--frames", str(t), "--seed", str(seeds(t))], check=True)
    else:
        subprocess.run([*command, "--frames", f"0-{a.frames - 1}", "--seed", str(seeds)], check=True)
    return np.stack([read(out.replace("####", f"{t:04d}")) for t in range(a.frames)])


def rms(x):
    return math.sqrt(float(np.mean(x * x)))


def flicker(f):
    return rms(f[:-2] - 2 * f[1:-1] + f[2:]) / math.sqrt(6)


print("| estimator | error in space | flicker, one seed | flicker, a seed per frame | flicker of 16 times the photons |")
print("|---|---|---|---|---|")
with tempfile.TemporaryDirectory(prefix="caustics_flicker_") as folder:
    write_scenes(folder)
    for estimator in "WP":
        one = frames(folder, "one", estimator, a.photons, 0)
        each = frames(folder, "each", estimator, a.photons, lambda t: 1000 + t)
        long = frames(folder, "long", estimator, 16 * a.photons, 0)
        size = rms(long)
        cells = [rms(one - each) / math.sqrt(2), flicker(one), flicker(each), flicker(long)]
        print(f"| {estimator} | " + " | ".join(f"{100 * c / size:.3f} %" for c in cells) + " |", flush=True)
