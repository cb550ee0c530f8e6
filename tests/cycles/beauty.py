# SPDX-License-Identifier: Apache-2.0
"""Estimator R, without caustics, against Cycles' small beauties: is the camera, each lamp, the pixel filter the same?

  beauty.py [NAME...] [--off field|shift|exposure|light|filter] [--expect-wrong]

Comparing pixel by pixel needs minutes (bench/cycles/compare_off.py). Here each quantity gets a pattern, how the picture
changes with it (two renders, the same random numbers), and the difference to Cycles is fitted by the pattern: the answer is
by how much our quantity is off, with an error from the residuals themselves. At 128 samples per pixel a lamp is known
to 0.03 %, a field of view to 0.01 %, the width of a filter to 0.4 %. Whatever has no pattern shows in blocks of 8x8
pixels. --off makes the quantity wrong by 2 %, which has to be noticed."""
import argparse
import copy
import json
import os
import sys
import tempfile

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(SOURCE, "bench", "cycles"))
from compare_common import BEAUTIES, Picture, around, block_error, blocks, np, render_off, scene_file  # noqa: E402

# What may remain: Cycles' round things are meshes, its numbers single, its filter a table.
ALLOWED, SIGMAS = 0.005, 3.5
# A quantity that is off by this must be noticed.
NOTICED = 0.02
BLOCK_ALLOWED, BLOCK_SIGMAS = 0.015, 4.5

QUANTITIES = {  # samples per pixel, quantities
    "shift": (128, ("light 0", "field", "shift x", "shift y")),
    "orthographic": (128, ("light 0", "field", "shift x", "shift y")),
    "sun10": (128, ("light 0", "field")),
    "spot_blend": (128, ("light 0", "light 1")),
    "area_spread": (128, ("light 0",)),
    "filter_gauss": (384, ("light 0", "filter")),
    "filter_bh": (384, ("light 0", "filter")),
    "filter_box": (128, ("light 0",)),
}
# How far a quantity moves for its pattern: far where the pattern is faint.
STEP = {"filter": 0.25}


def changed(scene, quantity, by):
    """The scene with one quantity made larger by a share; a shift is a share of half the picture's width."""
    out = copy.deepcopy(scene)
    camera, (kind, _, which) = out["camera"], quantity.partition(" ")
    if kind == "field":
        camera["hfov_deg" if "hfov_deg" in camera else "ortho_width"] *= 1 + by
    elif kind == "shift":
        shift = list(camera.get("shift", (0, 0)))
        shift["xy".index(which or "x")] += 0.5 * by
        camera["shift"] = shift
    elif kind == "exposure":
        camera["exposure"] = camera.get("exposure", 1) * (1 + by)
    elif kind == "filter":
        camera["filter"]["width"] *= 1 + by
    elif kind == "light":
        lamp = out["lights"][int(which or 0)]
        lamp["strength" if lamp["type"] == "sun" else "power_w"] *= 1 + by
    else:
        raise SystemExit(f"unknown quantity {quantity}")
    return out


class Comparison:
    def __init__(self, name, folder, off=None):
        self.name, self.folder = name, folder
        self.spp, self.quantities = QUANTITIES[name]
        reference = Picture(os.path.join(BEAUTIES, name + ".exr"))
        theirs, theirs_error = reference.layer(), reference.layer("se")
        self.size = theirs.shape[:2]
        with open(scene_file(name), encoding="utf-8") as file:
            self.scene = json.load(file)
        ours, error = self.render(changed(self.scene, off, NOTICED) if off else self.scene, 1)
        self.difference, self.theirs = ours - theirs, theirs
        self.error = np.hypot(error, theirs_error)
        # Weights from smoothed errors: a pixel where nothing rare was found yet does not know its own.
        spread2 = around(error ** 2, 2) + around(theirs_error ** 2, 2) + (.005 * around(theirs, 1)) ** 2
        spread2 += (.002 * theirs.mean()) ** 2
        self.kept = np.abs(self.difference) < 4 * np.sqrt(spread2)
        self.weights = self.kept / spread2
        self.plain = {}

    def render(self, scene, seed):
        path = os.path.join(self.folder, "scene.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(scene, file)
        return render_off(path, self.size, self.spp, seed)[:2]

    def pattern(self, quantity, seed):
        if seed not in self.plain:
            self.plain[seed] = self.render(self.scene, seed)[0]
        alone = len(self.scene["lights"]) == 1 and self.scene.get("world", {}).get("color", [0, 0, 0]) == [0, 0, 0]
        if quantity.startswith("light") and alone:  # the picture is linear in its only light
            return self.plain[seed]
        step = STEP.get(quantity, NOTICED)
        out = (self.render(changed(self.scene, quantity, step), seed)[0] - self.plain[seed]) / step
        limit = 3 * around(np.abs(out), 1)  # rare finds
        return np.clip(out, -limit, limit)

    def fit(self, quantity):
        """How much too large ours is, and the standard error. Two patterns from different random numbers, so that
        their noise does not make the answer smaller."""
        first, second = self.pattern(quantity, 2), self.pattern(quantity, 3)
        power = (self.weights * first * second).sum()
        off = (self.weights * first * self.difference).sum() / power
        pixels = (self.weights * first * (self.difference - off * second)).sum(-1)
        return off, float(np.sqrt((pixels ** 2).sum()) / power)

    def wrong_blocks(self):
        """Blocks (row, column, difference, sigma) that are off, of those with little noise."""
        d, c = blocks(self.difference * self.kept).mean(-1), blocks(self.theirs).mean(-1)
        e = block_error(np.sqrt(around(self.error ** 2, 1))).mean(-1)
        bad = (np.abs(d) > BLOCK_ALLOWED * c + BLOCK_SIGMAS * e) & (c > .05 * self.theirs.mean())
        return [(row, column, d[row, column] / c[row, column], e[row, column] / c[row, column])
                for row, column in np.argwhere(bad)]


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("names", nargs="*", metavar="NAME")
    p.add_argument("--off", help="make this wrong by 2 %%")
    p.add_argument("--expect-wrong", action="store_true", help="exit code 0 when something is wrong")
    a = p.parse_args()
    failures = 0
    with tempfile.TemporaryDirectory(prefix="caustics_cycles_") as folder:
        for name in a.names or QUANTITIES:
            c = Comparison(name, folder, a.off)
            print(f"{name}: {100 * c.kept.mean():.1f} % of the values compared")
            for quantity in c.quantities:
                off, error = c.fit(quantity)
                sharp = ALLOWED + SIGMAS * error < NOTICED
                ok = abs(off) <= ALLOWED + SIGMAS * error and sharp
                failures += not ok
                print(f"  {'ok   ' if ok else 'WRONG'} {quantity:8s} ours is {100 * off:+.3f} % off, standard error"
                      f" {100 * error:.3f} %" + ("" if sharp else ": too blunt to notice 2 %"), flush=True)
            for row, column, d, e in c.wrong_blocks():
                failures += 1
                print(f"  WRONG block {row}, {column}: {100 * d:+.2f} % off, sigma {100 * e:.2f} %")
            if c.kept.mean() < .98:
                failures += 1
                print("  WRONG too many values are far off")
    sys.exit(1 if (failures > 0) != a.expect_wrong else 0)


if __name__ == "__main__":
    main()
