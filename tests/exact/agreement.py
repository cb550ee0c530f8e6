# SPDX-License-Identifier: Apache-2.0
"""P and W against R in 8 x 8 blocks, layer by layer. Arguments: photons of P and W, camera paths of R (each per seed), scenes...

A block is tested where R's standard error (from its seeds) is under 2 % of it; the others count as untested. So does a
layer whose mean R knows to no better than 2 %: its blocks without fireflies look certain and are all too dark. P's kernel
blurs, so a block may differ by BIAS of itself or of the picture's mean beside four standard errors. A layer passes when
at most 2 % of its tested blocks are outside and its mean is right within 1.5 % + 2 standard errors. With --small
(48 x 32 pixels) a kernel is a large part of the picture: 4 %, and 6 % of an indirect layer. --soft makes every lamp six
times as wide and every sun 40 degrees, the scene otherwise as it is: what R can find. --estimators P leaves out W. --seeds N
[4]: with few, a block's own spread is an uncertain measure of its error (with four, Student's t is beyond 4 in 3 % of blocks).

What a sun under 2 degrees, or a lamp without extent, sends through a specular surface to one that the eye sees through
another, R finds by rare chance or never (reference.h): less than one camera path in 10,000 would. In an indirect layer an eye
path must meet the caster once more, which one in ten does, so that holds for suns under 6 degrees. Of such layers the pixels
that show glass or metal are untested, and left out of blocks and mean. That is known from the scene, not from the figures.
(Scene a with the sun at 5 degrees, a block at the ball's rim: 32 runs of 5e6 paths over the picture say .00184 +- .9 %, two of
6e7 into this block alone .00228 and .00227, P .00225.)"""
import argparse
import json
import os
import shutil
import sys
import tempfile

import numpy as np

from rig import FOLDER, SOURCE, Check, blocks, run

BIAS, SIZE, SMALL = 0.03, (96, 54), (48, 32)


def pictures(path, estimator, count, layers, size, left_out, seeds):
    out = {}
    for seed in range(1, seeds + 1):
        # Seeds of the two estimators differ: they must not share their camera samples.
        r = run(path, "--estimator", estimator, "--photons", count, "--seed", seed + (50 if estimator == "R" else 0),
                "--layers", layers, "--resolution", f"{size[0]}x{size[1]}")
        for name in r.layers:
            if name:
                image = np.where(left_out[name], 0, r[name]) if name in left_out else r[name]
                out.setdefault(name, []).append(blocks(image, 8).mean(axis=2))
    return {name: np.array(stack) for name, stack in out.items()}


NARROW_SUN_DEG = {"": 2, "_ind": 6}


def beyond_r(path):
    """The layers of which R finds by rare chance what is seen through specular surfaces."""
    def narrow(light, kind):
        if light["type"] == "sun":
            return light.get("angle_deg", 0) < NARROW_SUN_DEG[kind]
        return light.get("radius_m", 0) == 0 and light["type"] in ("point", "spot")

    with open(path) as file:
        lights = json.load(file)["lights"]
    return {f"caustics_{light.get('group') or light['name']}{kind}" for light in lights for kind in NARROW_SUN_DEG
            if narrow(light, kind)}


def casters_shown(path, size):
    """[height, width, 1] True where the camera sees glass or metal: the scene with those white under a white sky, all else black."""
    with open(path) as file:
        scene = json.load(file)
    for name, material in scene["materials"].items():
        white = 1 if material["type"] in ("glass", "metal") else 0
        scene["materials"][name] = {"type": "diffuse", "color": [white] * 3}
    scene.update(lights=[], world={"color": [1, 1, 1], "strength": 1})
    with tempfile.TemporaryDirectory(prefix="caustics_exact_") as folder:
        shown = os.path.join(folder, "scene.json")
        shutil.copytree(os.path.join(os.path.dirname(path), "meshes"), os.path.join(folder, "meshes"))
        with open(shown, "w") as file:
            json.dump(scene, file)
        beauty = run(shown, "--estimator", "R", "--photons", 64 * size[0] * size[1], "--layers", "beauty",
                     "--resolution", f"{size[0]}x{size[1]}")
    return beauty[""].max(axis=2, keepdims=True) > 0


def softened(path):
    """A copy of the scene, meshes and all, with wide lamps."""
    folder = os.path.join(FOLDER.name, "soft")
    if not os.path.isdir(folder):
        shutil.copytree(os.path.join(SOURCE, "scenes", "meshes"), os.path.join(folder, "meshes"))
    with open(path) as file:
        scene = json.load(file)
    for light in scene["lights"]:
        if light["type"] == "area":
            light["size"] = [6 * v for v in light["size"]]
        elif light["type"] == "sun":
            light["angle_deg"] = 40
    path = os.path.join(folder, os.path.basename(path))
    with open(path, "w") as file:
        json.dump(scene, file)
    return path


def compare(check, path, photons, paths, size, estimators=("P", "W"), seeds=4):
    beyond = beyond_r(path)
    shown = casters_shown(path, size) if beyond else None
    left_out = {layer: shown for layer in beyond}
    r = pictures(path, "R", paths, "radiance,indirect", size, left_out, seeds)
    for estimator in estimators:
        p = pictures(path, estimator, photons, "radiance,indirect", size, left_out, seeds)
        compare_with(check, path, estimator, p, r, size)


def compare_with(check, path, estimator, p, r, size):
    name = os.path.splitext(os.path.basename(path))[0]
    for layer in sorted(r):
        mean_bias = 0.015 if size == SIZE else 0.06 if layer.endswith("_ind") else 0.04
        a, b = p[layer].mean(axis=0), r[layer].mean(axis=0)
        root = np.sqrt(len(p[layer]))
        ea, eb = (x[layer].std(axis=0, ddof=1) / root for x in (p, r))
        tested = (b > 0) & (eb < 0.02 * b)
        limit = 4 * np.hypot(ea, eb) + (BIAS if size == SIZE else 2 * mean_bias) * np.maximum(b, b.mean())
        outside = tested & (np.abs(a - b) > limit)
        mean_a, mean_b = p[layer].mean(axis=(1, 2)), r[layer].mean(axis=(1, 2))
        error = np.hypot(mean_a.std(ddof=1), mean_b.std(ddof=1)) / root
        if mean_b.std(ddof=1) / root > 0.02 * b.mean() > 0:
            print(f"      {name:14} {layer:24} {estimator}/R {a.mean() / b.mean():.4f} +- {error / b.mean():.4f}; untested: R's own error")
            continue
        share = 100 * tested.sum() / tested.size
        if b.mean() == 0:
            check.that(a.mean() == 0, f"{name:14} {layer:24} both black")
            continue
        ratio, rel = a.mean() / b.mean(), error / b.mean()
        worst = np.max(np.where(tested, np.abs(a - b) / np.maximum(b, b.mean()), 0)) if tested.any() else 0
        ok = outside.sum() <= 0.02 * tested.sum() and abs(ratio - 1) <= mean_bias + 2 * rel
        word = "untested" if not tested.any() else f"{outside.sum()} of {tested.sum()} outside, worst {100 * worst:.1f} %"
        check.that(ok, f"{name:14} {layer:24} {estimator}/R {ratio:.4f} +- {rel:.4f}; tested {share:3.0f} % of blocks: {word}")
    sys.stdout.flush()


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("photons", type=float)
    words.add_argument("paths", type=float)
    words.add_argument("scenes", nargs="+")
    words.add_argument("--estimators", default="P,W")
    words.add_argument("--seeds", type=int, default=4)
    words.add_argument("--small", action="store_true")
    words.add_argument("--soft", action="store_true")
    a, found = words.parse_args(), Check()
    for name in a.scenes:
        path = os.path.join(SOURCE, "scenes", name + ".json")
        compare(found, softened(path) if a.soft else path, int(a.photons), int(a.paths), SMALL if a.small else SIZE,
                a.estimators.split(","), a.seeds)
    found.end()


if __name__ == "__main__":
    main()
