# SPDX-License-Identifier: Apache-2.0
"""P and W against R in 8 x 8 blocks, layer by layer. Arguments: photons of P and W, camera paths of R (each per seed), scenes...

A block is tested where R's standard error (from its seeds) is under 2 % of it; the others count as untested. So does a
layer whose mean R knows to no better than 2 %: its blocks without fireflies look certain and are all too dark. P's kernel
blurs, so a block may differ by BIAS of itself or of the picture's mean beside four standard errors. A layer passes when
at most 2 % of its tested blocks are outside and its mean is right within 1.5 % + 2 standard errors. With --small
(48 x 32 pixels) a kernel is a large part of the picture: 4 %, and 6 % of an indirect layer. --soft makes every lamp six
times as wide and every sun 40 degrees, the scene otherwise as it is: what R can find."""
import json
import os
import shutil
import sys

import numpy as np

from rig import FOLDER, SOURCE, Check, blocks, run

SEEDS, BIAS, SIZE, SMALL = 4, 0.03, (96, 54), (48, 32)


def pictures(path, estimator, count, layers, size):
    out = {}
    for seed in range(1, SEEDS + 1):
        # Seeds of the two estimators differ: they must not share their camera samples.
        r = run(path, "--estimator", estimator, "--photons", count, "--seed", seed + (50 if estimator == "R" else 0),
                "--layers", layers, "--resolution", f"{size[0]}x{size[1]}")
        for name in r.layers:
            if name:
                out.setdefault(name, []).append(blocks(r[name], 8).mean(axis=2))
    return {name: np.array(stack) for name, stack in out.items()}


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


def compare(check, path, photons, paths, size, estimators=("P", "W")):
    r = pictures(path, "R", paths, "radiance,indirect", size)
    for estimator in estimators:
        compare_with(check, path, estimator, pictures(path, estimator, photons, "radiance,indirect", size), r, size)


def compare_with(check, path, estimator, p, r, size):
    name = os.path.splitext(os.path.basename(path))[0]
    for layer in sorted(r):
        mean_bias = 0.015 if size == SIZE else 0.06 if layer.endswith("_ind") else 0.04
        a, b = p[layer].mean(axis=0), r[layer].mean(axis=0)
        ea, eb = (x[layer].std(axis=0, ddof=1) / np.sqrt(SEEDS) for x in (p, r))
        tested = (b > 0) & (eb < 0.02 * b)
        limit = 4 * np.hypot(ea, eb) + (BIAS if size == SIZE else 2 * mean_bias) * np.maximum(b, b.mean())
        outside = tested & (np.abs(a - b) > limit)
        mean_a, mean_b = p[layer].mean(axis=(1, 2)), r[layer].mean(axis=(1, 2))
        error = np.hypot(mean_a.std(ddof=1), mean_b.std(ddof=1)) / np.sqrt(SEEDS)
        if mean_b.std(ddof=1) / np.sqrt(SEEDS) > 0.02 * b.mean() > 0:
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


if __name__ == "__main__":
    found = Check()
    photon_count, path_count = int(float(sys.argv[1])), int(float(sys.argv[2]))
    words = sys.argv[3:]
    for scene_name in (w for w in words if not w.startswith("--")):
        scene_path = os.path.join(SOURCE, "scenes", scene_name + ".json")
        compare(found, softened(scene_path) if "--soft" in words else scene_path, photon_count, path_count,
                SMALL if "--small" in words else SIZE)
    found.end()
