# SPDX-License-Identifier: Apache-2.0
"""CPU seconds to nMSE 0.01 of the bundled scenes a to d at 160x90, direct caustics, as the plan chooses and by P alone.

usage: scenes.py [--threads N] [--cache FOLDER] [SCENE...]     (default a_ball b_ring c_water d_wineglass)

nMSE = mean (x - r)^2 / mean r^2 of the luminance of all layers together, over the region where the
reference r, blurred over 5 x 5 pixels, is over 5 % of its 99th percentile. The reference is a long run of another seed: 3 million rays of W, for the rough wine
glass (d) 16 million photons; kept in the cache. Energy: the sum over the region over the reference's. Cycles 3.4 on the
same pictures, measured earlier and extrapolated to nMSE 0.01: a 7,600 s, b 3,000 s, c 580,000 s, d 2,500 s; MNEE reaches it on c
alone (7.5e-4 in 2.2 s).

CPU seconds are user time of the whole program; after the slash without loading and planning (--explain)."""
import argparse
import os
import resource

import numpy as np

from peers import ROOT, loading, time_to
from rig import run  # peers makes it findable

TARGET, ENOUGH_S, LUMINANCE = 0.01, 25, (0.2126, 0.7152, 0.0722)
REFERENCE = {"d_wineglass": ("P", 1.6e7)}
LADDER = {"auto": [1e4, 3e4, 1e5, 3e5, 1e6, 3e6], "P": [3e4, 1e5, 3e5, 1e6, 3e6]}
GOALS = {"a_ball": 1, "b_ring": 1, "c_water": 1, "d_wineglass": 20}


def render(name, estimator, photons, threads, seed=0):
    """(luminance of all layers, user CPU seconds)"""
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    r = run(os.path.join(ROOT, "scenes", name + ".json"), "--estimator", estimator, "--photons", int(photons), "--effects", "direct",
            "--layers", "radiance", "--resolution", "160x90", "--threads", threads, "--seed", seed)
    seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return sum(r[n] @ LUMINANCE for n in r.layers if n.startswith("caustics_")), seconds


def reference(name, cache, threads):
    os.makedirs(cache, exist_ok=True)
    path = os.path.join(cache, f"scene_{name}.npy")
    if not os.path.exists(path):
        estimator, photons = REFERENCE.get(name, ("W", 3e6))
        np.save(path, render(name, estimator, photons, threads, seed=77)[0])
    return np.load(path)


def region(r):
    padded = np.pad(r, 2, mode="edge")
    blurred = sum(padded[i:i + r.shape[0], j:j + r.shape[1]] for i in range(5) for j in range(5)) / 25
    return blurred > 0.05 * np.percentile(blurred, 99)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("scenes", nargs="*", metavar="SCENE", default=list(GOALS))
    p.add_argument("--threads", type=int, default=1)
    p.add_argument("--cache", default=os.path.join(ROOT, "build", "truth"))
    a = p.parse_args()
    print("| scene | estimator | CPU s and nMSE | CPU s to 0.01 | goal | energy |\n" + "|---" * 6 + "|")
    for name in a.scenes:
        r = reference(name, a.cache, a.threads)
        inside = region(r)
        fixed = loading(os.path.join(ROOT, "scenes", name + ".json"), a.threads)
        for estimator, budgets in LADDER.items():
            rows = []
            for photons in budgets:
                x, seconds = render(name, estimator, photons, a.threads)
                error = float(((x - r)[inside]**2).mean() / (r[inside]**2).mean())
                rows.append({"whole": seconds, "bare": max(seconds - fixed, 1e-3), "error": error,
                             "energy": x[inside].sum() / r[inside].sum()})
                if error < TARGET / 4 or seconds > ENOUGH_S:
                    break
            steps = "; ".join(f"{row['whole']:.2f} s {row['error']:.1e}" for row in rows)
            print(f"| {name} | {estimator} | {steps} | {time_to(rows, TARGET, 'whole')} / {time_to(rows, TARGET, 'bare')} | "
                  f"{GOALS.get(name, '')} | {rows[-1]['energy']:.4f} |", flush=True)


if __name__ == "__main__":
    main()
