# SPDX-License-Identifier: Apache-2.0
"""Does the plan choose well? Wavefronts (W) and photons (P), each forced, on casters that its limits were not set on.

usage: plan.py [--seconds S] [--out FILE.json] [SEED...]   (default 1 second, seeds 1 to 70)
       plan.py --hard [--seconds S] [NAME...]              (hard.py's: what wavefronts are bad at)

For every scene of casters.py at 64x36, one thread: W and P with as many rays as S CPU seconds allow beyond loading and
probing; their squared error is the mean over the pixels of (x - h1) (x - h2), where h1 and h2 are two runs four times as
long of other seeds, independent, so that their own noise drops out: W's, unless these differ by more than P states as its
error (W states too much: the replicas' places on a lamp are not independent). W's error squared falls as 1 / time, P's as time^-2/3; so the time in which P reaches W's error is
t_P (e_P / e_W)^3, and the gain of W is that over t_W. The plan is right where the estimator it takes is at most 1.1 times
as slow as the other one; where it mixes them it is measured. W that has not ended its coarsest grids in 10 seconds loses.
Ends with the share that is right and the time lost, for seeds of both parities: limits are set on even ones alone.

CAUSTIC_RENDER names the program; else build/bin/caustic-render."""
import argparse
import json
import math
import os
import re
import subprocess
import sys
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "tests", "exact"))
import casters  # noqa: E402
import hard  # noqa: E402
from renders import render  # noqa: E402
from rig import PROGRAM, read_exr  # noqa: E402

SMALLEST, LONG, RIGHT, TOO_LONG_S = 4096, 4, 1.1, 10


def spread(pair):
    """Relative standard error of one of two runs."""
    (a, _, _), (b, _, _) = pair
    return math.sqrt(float(((a - b)**2).mean()) / 2 / max(float((a * b).mean()), 1e-30))


class Bench:
    def __init__(self, folder, seconds):
        self.folder, self.seconds = folder, seconds
        self.scene = os.path.join(folder, "scene.json")

    def render(self, estimator, rays, seed, limit):
        """(picture, CPU seconds, stated error); None when it takes longer than `limit` seconds."""
        report = render(self.folder, int(limit) + 1, "--estimator", estimator, "--photons", int(rays), "--seed", seed)
        if not report:
            return None
        return read_exr(os.path.join(self.folder, "run.exr"))["caustics_Light"].mean(axis=2), report["cpu_s"], report["error"]

    def explain(self):
        return subprocess.run([PROGRAM, self.scene, "--explain", "--effects", "direct"], capture_output=True, text=True,
                              check=True).stdout

    def pace(self, estimator, fixed):
        """Rays for a second beyond the fixed ones; None: not even the coarsest grids end in time."""
        rays = SMALLEST
        while True:
            found = self.render(estimator, rays, 9, max(TOO_LONG_S, 8 * self.seconds) + fixed)
            if not found:
                return None
            spent = found[1] - fixed
            if spent > 0.25 * self.seconds or rays > 1e8:
                return rays / max(spent, 1e-3)
            rays *= 4 if spent > 0.05 * self.seconds else 16

    def measure(self):
        """The row of one scene."""
        text = self.explain()
        fixed = min(self.render("P", 8, 9, 60)[1] for _ in range(2))
        paces = {e: self.pace(e, fixed) for e in "WP"}
        runs, longs = {}, {}
        for e, pace in paces.items():
            if not pace:
                continue
            runs[e] = self.render(e, max(pace * self.seconds, SMALLEST), 3, 60 + 60 * self.seconds)
            pair = [self.render(e, max(pace * self.seconds * LONG, SMALLEST), seed, 60 + 60 * self.seconds) for seed in (1, 2)]
            if all(pair):
                longs[e] = pair
        best = "P" if "W" not in longs or ("P" in longs and spread(longs["W"]) > longs["P"][0][2]) else "W"
        h1, h2 = longs[best][0][0], longs[best][1][0]
        size = math.sqrt(max(float((h1 * h2).mean()), 1e-30))
        row = {"W": None, "P": None, "auto": None, "truth": best}

        def judge(run):
            square = float(((run[0] - h1) * (run[0] - h2)).mean())
            return {"error": math.sqrt(max(square, 1e-10 * size**2)) / size, "seconds": max(run[1] - fixed, 1e-3)}
        for e, run in runs.items():
            row[e] = judge(run) if run else None
        line = next((w for w in text.splitlines() if "direct caustics by" in w), "")
        waved = "none" if not line else "W" if "(W)" in line else "P"
        row["choice"] = "mixed" if waved == "W" and "by photons." in text else waved
        if row["choice"] == "mixed":
            run = self.render("auto", max(paces["P"] * self.seconds, SMALLEST), 3, 60 + 60 * self.seconds)
            row["auto"] = judge(run) if run else None
        row["rays"] = [float(x) for x in re.findall(r"takes ([\d.e+-]+) rays a corner", text)]
        row["left"] = [float(x) / 100 for x in re.findall(r"leaves ([\d.e+-]+) %", text)]
        for key, pattern in (("photon_rays", r"photon takes ([\d.e+-]+) rays"), ("blur", r"over ([\d.e+-]+) pixels")):
            found = re.search(pattern, text)
            row[key] = float(found.group(1)) if found else 0
        return row


def gain(row, of="W"):
    """How many times as long P takes to the same error."""
    w, p = row[of], row["P"]
    if not w:
        return 0.0
    return p["seconds"] * (p["error"] / w["error"])**3 / w["seconds"]


def slower(row):
    """The plan's time over the better one's."""
    g = gain(row)
    if row["choice"] == "W":
        return max(1, 1 / g) if g > 0 else math.inf
    if row["choice"] == "mixed":
        return max(1, g, 1) / gain(row, "auto") if row["auto"] else math.inf
    return max(1, g)


def words(run):
    return f"{100 * run['error']:.2g} %, {run['seconds']:.2f} s" if run else "not in time"


def summary(rows):
    for parity, name in ((0, "even seeds, which limits may be set on"), (1, "odd seeds, held out")):
        part = [r for r in rows if r["seed"] % 2 == parity and r["choice"] != "none"]
        if not part:
            continue
        right = sum(slower(r) <= RIGHT for r in part)
        lost = [min(slower(r), 1e3) for r in part]
        print(f"\n{name}: right in {right} of {len(part)} ({100 * right / len(part):.0f} %); time over the better one's: "
              f"geometric mean {math.exp(np.mean(np.log(lost))):.2f}, worst {max(lost):.3g}")
        for always in "WP":
            other = [min(slower({**r, 'choice': always}), 1e3) for r in part]
            print(f"  always {always}: right in {sum(x <= RIGHT for x in other)}, geometric mean "
                  f"{math.exp(np.mean(np.log(other))):.2f}, worst {max(other):.3g}")
    lost = sorted((r for r in rows if r["choice"] != "none" and slower(r) > RIGHT), key=slower, reverse=True)
    print("\nWrong: " + ("; ".join(f"{r['name']} ({r['choice']}, {min(slower(r), 1e3):.2g} times)" for r in lost) or "none"))


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("seeds", nargs="*")
    p.add_argument("--hard", action="store_true")
    p.add_argument("--seconds", type=float, default=1)
    p.add_argument("--out", help="the rows, as JSON")
    a = p.parse_args()
    rows = []
    print("| scene | rays a corner, left, blur (pixels) | W | P | gain of W | plan |\n|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(folder, a.seconds)
        for seed in a.seeds or (list(hard.CASES) if a.hard else range(1, 71)):
            name, scene = (seed, hard.make(seed)) if a.hard else casters.make(int(seed))
            with open(bench.scene, "w", encoding="utf-8") as file:
                json.dump(scene, file)
            row = {"seed": 0 if a.hard else int(seed), "name": name, **bench.measure()}
            rows.append(row)
            rays, left = max(row["rays"], default=0), max(row["left"], default=0)
            print(f"| {name} | {rays:.0f}, {left:.2g}, {row['blur']:.2g} | {words(row['W'])} | {words(row['P'])} | {gain(row):.3g} | "
                  f"{row['choice']}{f', {slower(row):.2f}' if a.hard else ''}{'' if slower(row) <= RIGHT else ' (wrong)'} |", flush=True)
            if a.out:
                with open(a.out, "w", encoding="utf-8") as file:
                    json.dump(rows, file)
    if not a.hard:
        summary(rows)


if __name__ == "__main__":
    main()
