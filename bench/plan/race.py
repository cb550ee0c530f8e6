# SPDX-License-Identifier: Apache-2.0
"""What a render to an error takes by the plan and its race (render_race.c), beside each estimator alone.

usage: race.py [--seconds S] [SEED...]   (default 4 seconds, seeds 1 to 40)
       race.py --hard [NAME...]          (hard.py's)

For every scene of casters.py at 64x36, one thread, direct layers: the error that photons state after S seconds beyond
loading is what all three are asked for, and CPU seconds are counted until they state it, loading and probing taken off; one
that takes ten times as long as photons did is stopped. Ends with the geometric mean of the plan's seconds over the better
one's, and over each one's.

CAUSTIC_RENDER names the program; else build/bin/caustic-render."""
import argparse
import json
import math
import os
import tempfile

import numpy as np

import casters
import hard
from renders import render

TOO_LONG = 10


def measure(folder, seconds):
    """{estimator: seconds to the error, or None}, and the error; None where nothing is seen."""
    fixed = min(render(folder, 120, "--estimator", "P", "--photons", 8, "--seed", 9)["cpu_s"] for _ in range(2))
    found = render(folder, 120 + 4 * seconds, "--estimator", "P", "--time", fixed + seconds, "--seed", 8)
    if not found or not 0 < found["error"] < 1:
        return None, 0
    row = {}
    for e in ("auto", "W", "P"):
        run = render(folder, fixed + TOO_LONG * seconds, "--estimator", e, "--error", found["error"], "--seed", 3)
        row[e] = max(run["cpu_s"] - fixed, 1e-2) if run else None
    return row, found["error"]


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("seeds", nargs="*")
    p.add_argument("--hard", action="store_true")
    p.add_argument("--seconds", type=float, default=4)
    a = p.parse_args()
    over = {"the better one": [], "W": [], "P": []}
    print("| scene | error | plan | W | P | plan / better |\n|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for seed in a.seeds or (list(hard.CASES) if a.hard else range(1, 41)):
            name, scene = (seed, hard.make(seed)) if a.hard else casters.make(int(seed))
            with open(os.path.join(folder, "scene.json"), "w", encoding="utf-8") as file:
                json.dump(scene, file)
            row, error = measure(folder, a.seconds)
            if not row:
                print(f"| {name} | nothing seen |", flush=True)
                continue
            most = TOO_LONG * a.seconds
            s = {e: row[e] or most for e in row}
            over["the better one"].append(s["auto"] / min(s["W"], s["P"]))
            for e in "WP":
                over[e].append(s["auto"] / s[e])
            shown = {e: f"{row[e]:.2f} s" if row[e] else f"over {most:.0f} s" for e in row}
            print(f"| {name} | {100 * error:.2g} % | {shown['auto']} | {shown['W']} | {shown['P']} | {over['the better one'][-1]:.2f} |", flush=True)
    for what, ratios in over.items():
        print(f"plan / {what}: geometric mean {math.exp(np.mean(np.log(ratios))):.2f}, worst {max(ratios):.3g}, "
              f"over 1.5 in {sum(x > 1.5 for x in ratios)} of {len(ratios)}")


if __name__ == "__main__":
    main()
