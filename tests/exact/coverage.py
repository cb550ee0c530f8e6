# SPDX-License-Identifier: Apache-2.0
"""Do stated errors hold? Arguments: photons, photons of the long reference, scenes...; --small, --estimators P,W,R.

Of every layer, in regions of 8 x 8 pixels: the root mean square difference from a long reference of another seed, beside
what the render states there, the RMS over the region of noise and bias (layers _err and _bias) and of the reference's
own. The stated 95 % interval holds where the difference is at most 1.96 times that. Printed are the share of regions
that it holds in, the median of stated over true error, and the figure of the header over the true error of the whole
layer. Regions darker than a thousandth of the mean are left out. R's reference is the other estimators' (it
would need its own seed's hours), and R is left out where lights are points or suns, whose caustics it cannot find, and where it states an error of more than the
light itself: so few paths met that that they do not know their own spread.

A row is right when 90 % of its regions hold and the median is between 0.5 and 2; over all rows 93 % must hold. With
--small, a test in seconds, 80 %, and medians of 0.4 to 2.5. Exit 1 when a row or the sum is wrong."""
import json
import os
import sys

import numpy as np

from rig import SOURCE, blocks, run

SIZE, SMALL = (160, 88), (64, 40)


def findable(path):
    """R finds every light: wide ones alone."""
    with open(path) as file:
        return all(light["type"] == "area" for light in json.load(file)["lights"])


def region_rms(values):
    return np.sqrt(blocks(values ** 2, 8).mean(axis=2))


def layer_row(name, layer, estimator, test, truth, stated):
    noise, bias, own = test[layer + "_err"], test[layer + "_bias"], truth[layer + "_err"]
    own2 = own ** 2 + truth[layer + "_bias"] ** 2
    difference = region_rms(test[layer] - truth[layer])
    said = region_rms(np.sqrt(noise ** 2 + bias ** 2 + own2))
    lit = region_rms(truth[layer]) > 1e-3 * np.sqrt(np.mean(truth[layer] ** 2))
    if not lit.any():
        return None
    holds = float(np.mean(difference[lit] <= 1.96 * said[lit]))
    median = float(np.median(said[lit] / np.maximum(difference[lit], 1e-30)))
    true2 = np.mean((test[layer] - truth[layer]) ** 2) - np.mean(own2)
    true = np.sqrt(max(true2, 0) / np.mean(truth[layer] ** 2))
    figure = f"{100 * stated:6.1f} {100 * true:6.1f}"
    return (name, layer, estimator, int(lit.sum()), holds, median, figure)


def stated_errors(report):
    out = {}
    for light in report["lights"]:
        out["caustics_" + light["light"]] = light["error_direct"]
        out["caustics_" + light["light"] + "_ind"] = light["error_indirect"]
    return out


def rows_of(name, photons, long, size, estimators):
    path = os.path.join(SOURCE, "scenes", name + ".json")
    words = ["--layers", "radiance,indirect,error,bias", "--resolution", f"{size[0]}x{size[1]}"]
    truth = run(path, "--estimator", "auto", "--photons", long, "--seed", 99, *words)
    for estimator in estimators:
        if estimator == "R" and not findable(path):
            print(f"{name:14} R cannot find the light of points and suns: left out")
            continue
        test = run(path, "--estimator", estimator, "--photons", photons, "--seed", 1, *words)
        stated = stated_errors(test.report)
        for layer in sorted(stated):
            if estimator == "R" and stated[layer] > 1:
                print(f"{name:14} {layer:24} R         states {100 * stated[layer]:.0f} %: left out")
                continue
            row = layer in truth.layers and layer_row(name, layer, estimator, test, truth, stated[layer])
            if row:
                yield row


def main(words):
    small = "--small" in words
    estimators = words[words.index("--estimators") + 1].split(",") if "--estimators" in words else ["P", "W", "R"]
    scenes = [w for w in words[2:] if not w.startswith("--") and w != ",".join(estimators)]
    least, low, high = (0.8, 0.4, 2.5) if small else (0.9, 0.5, 2)
    print("scene          layer                    estimator regions  hold %  median stated/true   stated %  true %")
    wrong, regions, held = 0, 0, 0
    for name in scenes:
        for name, layer, estimator, count, holds, median, figure in rows_of(
                name, int(float(words[0])), int(float(words[1])), SMALL if small else SIZE, estimators):
            ok = holds >= least and low <= median <= high
            wrong += not ok
            regions, held = regions + count, held + holds * count
            print(f"{name:14} {layer:24} {estimator:9} {count:7} {100 * holds:7.1f} {median:10.2f}          {figure}"
                  + ("" if ok else "   WRONG"), flush=True)
    share = held / max(regions, 1)
    print(f"all: {100 * share:.1f} % of {regions} regions hold, {wrong} rows wrong")
    return 1 if wrong or regions == 0 or share < (least if small else 0.93) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
