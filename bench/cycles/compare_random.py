#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Cycles against the layers on scenes that nobody chose: bench/exact/random_scenes.py's, with materials that Cycles 3.4 has.

  compare_random.py [--scenes N] [--first SEED] [--spp N] [--seeds K] [--photons N] [--keep FOLDER]

Per scene: estimator R's beauty against Cycles without caustics, and the sum of all layers against (on - off) of paired seeds,
at 96x54. Printed: the ratio of the means with two standard errors, and the block of 8x8 farthest out in standard errors
beyond 2 %. A scene fails when a mean is off by more than 2 % + 3 standard errors. Exit code 1 then."""
import argparse
import json
import os
import subprocess
import sys
import tempfile

from compare_common import SOURCE, Picture, block_error, blocks, mean_error, np, render, render_off, worst_block

sys.path.insert(0, os.path.join(SOURCE, "bench", "exact"))
from random_scenes import Maker  # noqa: E402

SIZE = (54, 96)
BLENDER_SCENES = os.path.join(SOURCE, "scenes", "blender_scenes.py")


class CyclesMaker(Maker):
    """Cycles 3.4 has Fresnel terms at the normal only: smooth glass, metals of one colour. Small point lamps."""

    def caster_material(self):
        m = super().caster_material()
        if m["type"] == "glass":
            m["roughness"] = 0
        if m["type"] == "plastic":
            m = {"type": "metal", "color": m["color"], "roughness": m["roughness"]}
        if m["type"] == "metal":
            m["edge_color"] = m["color"]
        return m

    def scene(self):
        out = super().scene()
        for m in out["materials"].values():
            if m["type"] == "plastic":
                m.clear()
                m.update(type="diffuse", color=[0.7, 0.6, 0.5])
        for light in out["lights"]:
            if light["type"] == "sun":  # brighter towards its rim in 3.4, here even: the same when it is small
                light["angle_deg"] = round(0.2 * light["angle_deg"], 3)
            if "radius_m" in light:  # a disc in 3.4, here a ball: the same when it is small
                light["radius_m"] = round(0.1 * light["radius_m"], 3)
        out["bounces"] = {"total": 24, "diffuse": 4, "glossy": 16, "transmission": 16}
        out["camera"]["resolution"] = [SIZE[1], SIZE[0]]
        return out


def cycles(path, folder, spp, seeds):
    """off and on - off as (seeds, height, width, 3)."""
    words, jobs = ["blender", "-b", "--factory-startup", "--python", BLENDER_SCENES, "--"], []
    for seed in range(seeds):
        for mode in ("off", "on"):
            jobs.append(os.path.join(folder, f"{mode}{seed}.exr"))
            words += (["--job"] if len(jobs) > 1 else []) + ["--scene", path, "--mode", mode, "--spp", str(spp), "--seed", str(seed),
                                                             "--res", f"{SIZE[1]}x{SIZE[0]}", "--threads", "1", "--out", jobs[-1]]
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if not all(os.path.exists(j) for j in jobs):
        raise RuntimeError(done.stdout[-2000:])
    pictures = [Picture(j).layer() for j in jobs]
    off, on = np.array(pictures[::2]), np.array(pictures[1::2])
    return off, on - off


def compare(name, what, ours, ours_error, theirs):
    """Prints a line; returns whether the means agree."""
    n = len(theirs)
    mean, error = theirs.mean(0), theirs.std(0, ddof=1) / n**.5
    ratio = ours.mean() / mean.mean()
    # Of few seeds the error of the whole is the better known one.
    sigma = np.hypot(theirs.mean((1, 2, 3)).std(ddof=1) / n**.5, mean_error(ours_error)) / mean.mean()
    worst = worst_block(blocks(ours - mean), blocks(mean), np.hypot(block_error(error), block_error(ours_error)), 0.02, 0.1 * mean.mean())
    block = f"worst block {worst[0][0]},{worst[0][1]}: {100 * worst[1] / worst[2]:+.1f} % +- {100 * worst[3] / worst[2]:.1f}" if worst else ""
    ok = bool(abs(ratio - 1) <= 0.02 + 3 * sigma)
    print(f"{'ok   ' if ok else 'WRONG'} {name:10} {what:8} {ratio:.4f} +- {2 * sigma:.4f}  {block}", flush=True)
    return ok


def one(seed, a, folder):
    path, name = os.path.join(a.keep or folder, f"cycles{seed}.json"), f"cycles{seed}"
    with open(path, "w", encoding="utf-8") as file:
        json.dump(CyclesMaker(seed).scene(), file, indent=1)
    off, difference = cycles(path, folder, a.spp, a.seeds)
    beauty, beauty_error, _ = render_off(path, SIZE, max(a.spp * a.seeds // 2, 16), seed)
    ok = compare(name, "off", beauty, beauty_error, off)
    layers, _ = render(path, SIZE, "--effects", "direct,indirect", "--layers", "radiance,indirect,error", "--photons", a.photons, "--seed", seed)
    errors = [layers.layer(n) for n in layers.layers() if n.endswith("_err")]
    return compare(name, "on - off", layers.layer(), np.sqrt(sum(e**2 for e in errors)), difference) and ok


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--scenes", type=int, default=20)
    p.add_argument("--first", type=int, default=1)
    p.add_argument("--spp", type=int, default=512)
    p.add_argument("--seeds", type=int, default=4)
    p.add_argument("--photons", type=int, default=300000)
    p.add_argument("--keep")
    a = p.parse_args()
    if a.keep:
        os.makedirs(a.keep, exist_ok=True)
    failed = []
    for seed in range(a.first, a.first + a.scenes):
        with tempfile.TemporaryDirectory(prefix="caustics_random_") as folder:
            if not one(seed, a, folder):
                failed.append(seed)
    print(f"{a.scenes} scenes, {len(failed)} fail: {' '.join(map(str, failed))}")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
