# SPDX-License-Identifier: Apache-2.0
"""References from Cycles for a scene file: mean and standard error over seeds, per light group.

  python3 reference.py SCENE.json --mode off  -o DIR/NAME  --spp N --seeds K --res WxH     the beauty without caustics
  python3 reference.py SCENE.json --mode diff -o DIR/NAME  ...                             on - off, paired seeds

off:   NAME.exr with channels R,G,B (mean) and se.R,se.G,se.B (standard error of the mean), float.
diff:  NAME.exr with R,G,B (mean of on - off), off.R.. (mean of off; on is their sum) and se.R.. (standard error of
       on - off); with --groups also NAME.GROUP.exr of each light group.
Both add a line per file to DIR/table.tsv. Renders stay in --work until they are combined, so a broken run goes on where
it stopped. Needs blender, numpy and OpenImageIO for Python (Debian: python3-numpy python3-openimageio).
"""
import argparse
import json
import os
import subprocess
import sys

import numpy as np
import OpenImageIO as oiio

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
COLUMNS = ("file", "scene", "mode", "group", "resolution", "spp", "seeds", "mean_off", "mean", "se_of_mean", "se_percent",
           "se_block8_percent", "cpu_s_off", "cpu_s_on", "blender")


def read(path):
    """{group or '': (H, W, 3)} of a Cycles EXR, single layer or MultiLayer."""
    f = oiio.ImageInput.open(path)
    if f is None:
        raise IOError(path)
    names, a = list(f.spec().channelnames), f.read_image(oiio.FLOAT)
    f.close()

    def pick(prefix):
        return a[..., [names.index(prefix + c) for c in "RGB"]].astype(np.float64)

    if "R" in names:
        return {"": pick("")}
    out = {"": pick("ViewLayer.Combined.")}
    for n in names:
        if n.startswith("ViewLayer.Combined_") and n.endswith(".R"):
            out[n[len("ViewLayer.Combined_"):-2]] = pick(n[:-1])
    return out


def write(path, images, note):
    """Float ZIP EXR; images: {prefix: (H, W, 3)}."""
    planes = [(p + c, im[..., i]) for p, im in images.items() for i, c in enumerate("RGB")]
    spec = oiio.ImageSpec(planes[0][1].shape[1], planes[0][1].shape[0], len(planes), oiio.FLOAT)
    spec.channelnames = [n for n, _ in planes]
    spec["compression"] = "zip"
    spec["comments"] = note
    out = oiio.ImageOutput.create(path + ".incomplete.exr")
    if not out.open(path + ".incomplete.exr", spec):
        raise IOError(out.geterror())
    out.write_image(np.ascontiguousarray(np.stack([p for _, p in planes], -1), np.float32))
    out.close()
    os.replace(path + ".incomplete.exr", path)


def render(a, seed, mode, work):
    """One render, unless it is there already. Returns (path, CPU seconds, Blender's version)."""
    path = os.path.join(work, "%s_%d_%d.exr" % (mode, a.spp, seed))
    side = path + ".json"
    if not os.path.exists(side):
        cmd = ["nice", "-n", "19", os.environ.get("BLENDER", "blender"), "-b", "--factory-startup", "--python",
               os.path.join(ROOT, "scenes", "blender_scenes.py"), "--", "--scene", a.scene, "--mode", mode, "--spp",
               str(a.spp), "--seed", str(seed), "--res", a.res, "--threads", str(a.threads),
               "--out", path] + (["--groups", "--multilayer"] if a.groups else [])
        r = subprocess.run(cmd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        job = [l for l in r.stdout.splitlines() if l.startswith("JOB ")]
        if r.returncode or not job:
            sys.exit(r.stdout)
        info = json.loads(job[0][4:])
        info["blender"] = next((l.split()[1] for l in r.stdout.splitlines() if l.startswith("Blender ")), "?")
        with open(side, "w", encoding="utf-8") as f:
            json.dump(info, f)
    with open(side, encoding="utf-8") as f:
        info = json.load(f)
    return path, info["user"], info["blender"]


def blocks(x, n=8):
    """Means over n x n pixels, whole blocks only; x is (..., H, W, 3), the result (..., H/n, W/n)."""
    h, w = x.shape[-3] // n * n, x.shape[-2] // n * n
    x = x[..., :h, :w, :].mean(-1)
    return x.reshape(*x.shape[:-2], h // n, n, w // n, n).mean((-3, -1))


def main():
    p = argparse.ArgumentParser()
    p.add_argument("scene")
    p.add_argument("--mode", choices=("off", "diff"), required=True)
    p.add_argument("-o", "--out", required=True, help="DIR/NAME, without .exr")
    p.add_argument("--spp", type=int, default=1024)
    p.add_argument("--seeds", type=int, default=8)
    p.add_argument("--off-seeds", type=int, help="fewer beauties without caustics, used in turn, where those hardly have noise")
    p.add_argument("--res", default="96x54")
    p.add_argument("--groups", action="store_true")
    p.add_argument("--threads", type=int, default=1)
    p.add_argument("--work", default=os.path.join(ROOT, "build-cycles"))
    a = p.parse_args()
    name, folder = os.path.basename(a.out), os.path.dirname(os.path.abspath(a.out))
    work = os.path.join(a.work, name)
    os.makedirs(work, exist_ok=True)
    os.makedirs(folder, exist_ok=True)

    seconds, version, off, on = {"off": 0.0, "on": 0.0}, "?", {}, {}
    for seed in range(a.seeds):
        for mode, store in (("off", off),) + ((("on", on),) if a.mode == "diff" else ()):
            if mode == "off" and a.off_seeds and seed >= a.off_seeds:
                continue
            path, s, version = render(a, seed, mode, work)
            seconds[mode] += s
            for g, im in read(path).items():
                if g and not a.groups:
                    continue
                store.setdefault(g, []).append(im)

    rows = []
    for g in off:
        o = np.stack(off[g])
        x = np.stack([im - o[i % len(o)] for i, im in enumerate(on[g])]) if a.mode == "diff" else o
        k = len(x)
        mean, se = x.mean(0), x.std(0, ddof=1) / np.sqrt(k)
        total = float(mean.mean())
        # Two views of the same thing: the seeds' means, and the pixels' errors, which do not know of each other.
        se_total = max(float(x.mean((1, 2, 3)).std(ddof=1) / np.sqrt(k)),
                       float(np.sqrt((se.mean(-1) ** 2).sum()) / se[..., 0].size))
        b = blocks(x)
        lit = b.mean(0) > 0.05 * b.mean(0).max() if total > 0 else np.zeros(b.shape[1:], bool)
        se_block = float(np.median((b.std(0, ddof=1) / np.sqrt(k) / np.maximum(b.mean(0), 1e-30))[lit])) if lit.any() else 0
        images = {"": mean, "off.": o.mean(0), "se.": se} if a.mode == "diff" else {"": mean, "se.": se}
        file = name + ("." + g if g else "") + ".exr"
        note = "%s, %s, %s, %d x %d samples per pixel" % (os.path.basename(a.scene), a.mode, g or "all lights", k, a.spp)
        write(os.path.join(folder, file), images, note)
        rows.append((file, os.path.basename(a.scene), a.mode, g or "all", a.res, a.spp, k, "%.6g" % o.mean(), "%.6g" % total,
                     "%.3g" % se_total, "%.3f" % (100 * se_total / total if total else 0), "%.2f" % (100 * se_block),
                     "%.1f" % seconds["off"], "%.1f" % seconds["on"], version))
    table = os.path.join(folder, "table.tsv")
    old = []
    if os.path.exists(table):
        with open(table, encoding="utf-8") as f:
            old = [l.rstrip("\n").split("\t") for l in f][1:]
    new = {r[0]: [str(c) for c in r] for r in rows}
    lines = sorted([r for r in old if r[0] not in new] + list(new.values()))
    with open(table, "w", encoding="utf-8") as f:
        f.write("\n".join("\t".join(l) for l in [COLUMNS] + lines) + "\n")
    for r in rows:
        print("\t".join(str(c) for c in r), flush=True)


if __name__ == "__main__":
    main()
