# SPDX-License-Identifier: Apache-2.0
"""Which share of the light that Cycles drops is smooth and direct, rough and direct, indirect, and what each costs.

usage: shares.py [--photons N,N,...] SCENE...

Shares are means of the layers over the picture, all lights and channels together. The split of the direct layers:
casters whose material is rough (roughness > 0) are rendered without casting and the rest is "smooth"; what is missing
then has met a rough surface: "rough". A scene of one kind alone is not split.

Cost is CPU seconds (user time, whole program) at a ladder of photons. Indirect layers are never rendered alone: their
seconds are those of the render with them less those of the render without. Errors are RMS over the RMS of the sum of
the share's layers:
  noise   the standard error that the render itself states; c t^-a is fitted to the ladder;
  bias    how much farther apart the runs lie than their noise explains. The longest run holds the passes of a shorter
          one (k times fewer), so noise alone gives the square (1 - 2/k) V(shorter) + V(longest). Bias is taken to
          fall as N^-p; p, between 1/3 (a shrinking kernel on a smooth picture) and 1 (a start that is too wide), is
          what fits the distances of the first two runs from the longest. Sharp edges leave more.
A time to 5 % beyond the longest run is an extrapolation and marked so."""
import argparse
import json
import math
import os
import subprocess
import sys
import tempfile

import numpy as np
import OpenImageIO as oiio

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("CAUSTIC_RENDER", os.path.join(ROOT, "build", "bin", "caustic-render"))
TARGET = 0.05


def is_rough(material):
    return material.get("roughness", 0.5 if material["type"] == "plastic" else 0) > 0


def is_caster(material):
    return material["type"] in ("plastic", "metal", "glass")


def without(scene, rough):
    """A copy in which the rough (or the smooth) casters block light and no more; None when there are none."""
    copy, found = json.loads(json.dumps(scene)), False
    for thing in copy["objects"]:
        material = copy["materials"][thing["material"]]
        if is_caster(material) and is_rough(material) == rough:
            thing["casts_caustics"] = False
            found = True
    return copy if found else None


def layers_of(path, indirect):
    """Sum of the direct or of the indirect layers and the variance of its mean, (height, width, 3) each."""
    file, total, variance = oiio.ImageInput.open(path), 0, 0
    part = 1  # part 0 is the sum of all
    while file.seek_subimage(part, 0):
        kind = file.spec().getattribute("name").split("_")[2:]
        if ("ind" in kind) == indirect:
            data = file.read_image(part, 0, 0, -1, "float").astype(np.float64)
            if "err" in kind:
                variance = variance + data**2
            else:
                total = total + data
        part += 1
    file.close()
    return total, variance


def render(path, photons, effects, folder):
    """{"cpu": s, "photons": per light, "direct": (total, variance), "indirect": the same if asked for}"""
    out, report = os.path.join(folder, "out.exr"), os.path.join(folder, "out.json")
    layers = "radiance,error" + (",indirect" if effects != "direct" else "")
    subprocess.run([PROGRAM, path, "-o", out, "--photons", str(photons), "--effects", effects, "--layers", layers,
                    "--seed", "1", "--quiet", "--report", report], check=True)
    with open(report, encoding="utf-8") as file:
        figures = json.load(file)
    row = {"photons": figures["photons_per_light"], "cpu": figures["cpu_s"], "direct": layers_of(out, False)}
    if effects != "direct":
        row["indirect"] = layers_of(out, True)
    return row


def ladder(scene, name, label, photons, effects):
    """Runs of one variant, which lies beside the scene for a moment because of the meshes it names."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(ROOT, "scenes", f"_shares_{os.getpid()}_{name}_{label}.json")
        with open(path, "w", encoding="utf-8") as file:
            json.dump(scene, file)
        try:
            return [render(path, n, effects, folder) for n in photons]
        finally:
            os.remove(path)


def rms(x):
    return float(np.sqrt(np.mean(x**2)))


def distance(row, last, kind):
    """RMS between a run and the longest beyond what noise explains."""
    (x, v), (x_last, v_last), k = row[kind], last[kind], last["photons"] / row["photons"]
    return math.sqrt(max(0, np.mean((x - x_last)**2) - np.mean((1 - 2 / k) * v + v_last)))


def bias_of(rows, kind):
    """(bias of the longest run, p)"""
    last = rows[-1]
    (d1, k1), (d2, k2) = ((distance(r, last, kind), last["photons"] / r["photons"]) for r in rows[:2])
    exponents = np.linspace(1 / 3, 1, 100)
    p = float(exponents[np.argmin(np.abs((k1**exponents - 1) * d2 - (k2**exponents - 1) * d1))]) if d1 and d2 else 1 / 3
    return d1 / (k1**p - 1) / rms(last[kind][0]), p


def cost(seconds, rows, kind):
    """Steps of (CPU s, noise), noise = c t^-a, bias of the longest run, CPU s to the target without and with it."""
    steps = [(t, float(np.sqrt(np.mean(r[kind][1]))) / rms(r[kind][0])) for t, r in zip(seconds, rows)]
    slope, offset = np.polyfit(*np.log(np.array(steps)).T, 1)
    bias, p = bias_of(rows, kind)

    def total(t):
        return math.hypot(math.exp(offset) * t**slope, bias * (t / steps[-1][0])**-p)

    with_bias = next((float(t) for t in np.geomspace(1e-2, 1e7, 20000) if total(t) <= TARGET), math.inf)
    return {"steps": steps, "exponent": -float(slope), "bias": bias, "bias_exponent": p,
            "noise_s": float(math.exp((math.log(TARGET) - offset) / slope)), "total_s": with_bias}


def mean(row, kind):
    return float(np.mean(row[kind][0]))


def measure(name, photons):
    with open(os.path.join(ROOT, "scenes", name + ".json"), encoding="utf-8") as file:
        scene = json.load(file)
    direct = ladder(scene, name, "direct", photons, "direct")
    both = ladder(scene, name, "both", photons, "direct,indirect")
    smooth_only, rough_only = without(scene, rough=True), without(scene, rough=False)
    all_direct, indirect = mean(direct[-1], "direct"), mean(both[-1], "indirect")
    shares = []

    def share(kind, rows, part, seconds=None, layer="direct"):
        figures = cost(seconds or [r["cpu"] for r in rows], rows, layer)
        shares.append({"kind": kind, "share": part / (all_direct + indirect), **figures})

    if smooth_only is None or rough_only is None:
        share("rough direct" if rough_only is None else "smooth direct", direct, all_direct)
    else:
        smooth = ladder(smooth_only, name, "smooth", photons, "direct")
        rough = ladder(rough_only, name, "rough", photons, "direct")
        share("smooth direct", smooth, mean(smooth[-1], "direct"))
        share("rough direct", rough, all_direct - mean(smooth[-1], "direct"))
        shares[-1]["alone"] = mean(rough[-1], "direct") / (all_direct + indirect)
    share("indirect", both, indirect, [b["cpu"] - d["cpu"] for b, d in zip(both, direct)], "indirect")
    return {"scene": name, "photons": [r["photons"] for r in both], "shares": shares}


def show(result):
    for s in result["shares"]:
        longest = s["steps"][-1][0]

        def words(seconds):
            return f"{seconds:.3g}" + (" (extrapolated)" if seconds > longest else "")

        steps = ", ".join(f"{t:.1f} s {100 * e:.1f} %" for t, e in s["steps"])
        bias = f"{100 * s['bias']:.1f} %, {s['bias_exponent']:.2f}"
        print(f"| {result['scene']} | {s['kind']} | {100 * s['share']:.1f} % | {steps} | {s['exponent']:.2f} | {bias} | "
              f"{words(s['noise_s'])} | {words(s['total_s'])} |", flush=True)
    for s in result["shares"]:
        if "alone" in s:
            print(f"{result['scene']}: {100 * s['alone']:.1f} of the {100 * s['share']:.1f} points of rough light have "
                  "met no smooth caster; the ladder of \"rough direct\" is theirs.", file=sys.stderr)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photons", default="1048576,2097152,4194304,8388608",
                        help="per light, rising; from 1048576 on a pass has its full size")
    parser.add_argument("scene", nargs="+", metavar="SCENE")
    arguments = parser.parse_args()
    photons = [int(n) for n in arguments.photons.split(",")]
    print("| scene | part | of the dropped light | CPU seconds and noise | exponent | bias of the longest, exponent | "
          "CPU s to 5 % noise | CPU s to 5 % with bias |\n|---|---|---|---|---|---|---|---|", flush=True)
    for name in arguments.scene:
        show(measure(name, photons))


if __name__ == "__main__":
    main()
