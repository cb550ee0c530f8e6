# SPDX-License-Identifier: Apache-2.0
"""The add-on's sum against Cycles' own caustics, in the same Blender:

  CAUSTICS_BIN=build/bin blender -b --factory-startup --python bench/blender/against_cycles.py --
      [--spp N] [--within PERCENT] [--seeds MOST] [--work FOLDER] [NAME...]

For each scene of tests/blender_addon/built.py, and files of scenes/, at 96x54: what the add-on adds (its result less its
picture), against (caustics on - that picture at as many samples) of Cycles by the same seeds; and estimator R's beauty of
the exported scene against the picture, which checks camera, lights, filter and materials. "Picture / Cycles off": what the
add-on switches besides Cycles' own caustics (bases.py).

Cycles renders seeds until the standard error of its mean is within PERCENT (0.7), MOST (200) of them at most; where
bench/cycles/reference holds a long render by this Blender, that is it. Renders stay in FOLDER (build/against_cycles), so
that a broken run goes on where it stopped. So that paths from the camera find the lamps at all, those of built.py are
made wide, and the sun over the water has 5 degrees.

A scene passes when Cycles' error is within PERCENT, the means differ by at most 2 % (plastic_room before 4.0: 3 %) +
2 standard errors of both, and
at most one block of 8x8 pixels in twenty (of those brighter than a tenth of the mean) by more than 2 % + 3 standard
errors. Prints one line a scene; exit code 1 when one fails or has a reference with too much noise."""
import argparse
import csv
import os
import sys
import tempfile
import time
import types

import bpy

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
REFERENCES = os.path.join(ROOT, "bench", "cycles", "reference")
sys.path.insert(0, os.path.join(ROOT, "tests", "blender_addon"))
from support import Case, built, caustics, layers, np  # noqa: E402

import blender_scenes  # noqa: E402

from caustics import bases, switches  # noqa: E402

FILES = ("a_ball_sun5", "b_ring", "c_water", "d_wineglass", "plastic_room")
RELATIVE, SIGMAS = 0.02, 2.0
RELATIVE_PLASTIC = 0.03  # before 4.0, where Principled's coat is another: docs/cycles.md
BLOCK, BLOCK_SIGMAS, BLOCKS_BEYOND, DARK = 8, 3.0, 0.05, 0.1
FEWEST, OURS = 6, 4  # seeds: of fewer a standard error means little
PATHS = 96 * 54 * 512  # of estimator R


# ---- scenes ----

def widen(scene):
    """Lamps that paths from the camera hit now and then; a small one's caustic takes Cycles days."""
    for o in scene.objects:
        if o.type != "LIGHT":
            continue
        if o.data.type == "SUN":
            o.data.angle = max(o.data.angle, np.radians(5.0))
        elif o.data.type == "AREA":
            o.data.size = max(o.data.size, 1.0)
        else:
            o.data.shadow_soft_size = max(o.data.shadow_soft_size, 0.4)


def build(name):
    if name not in FILES:
        built.SCENES[name](built.empty())
        scene = bpy.context.scene
    else:
        scene, doc = blender_scenes.build(os.path.join(ROOT, "scenes", name + ".json"), types.SimpleNamespace(groups=False))
        blender_scenes.settings(scene, doc, types.SimpleNamespace(spp=1, seed=0, mode="on", res="96x54", threads=2, half=False, multilayer=False))
    if name not in FILES or name == "c_water":
        widen(scene)
    if hasattr(bpy.types.Scene, "caustics"):
        caustics.unregister()
    caustics.register()
    c = scene.cycles
    c.light_sampling_threshold, c.blur_glossy, c.sample_clamp_indirect, c.sample_clamp_direct = 0.0, 0.0, 0.0, 0.0
    if bpy.app.version < (3, 5, 0):  # by 512 samples a seed its default pattern has 3 % less light in c_water (docs/blender.md)
        c.sampling_pattern = "SOBOL"
    for o in bpy.data.objects:  # Blender's crutches against the terminator of coarse smooth meshes move shadows
        if hasattr(o.cycles, "shadow_terminator_offset"):
            o.cycles.shadow_terminator_offset = o.cycles.shadow_terminator_geometry_offset = 0.0
        elif hasattr(o, "shadow_terminator_shading_offset"):
            o.shadow_terminator_shading_offset = o.shadow_terminator_geometry_offset = 0.0
    return scene


# ---- Cycles ----

def cycles(scene, mode, seed, spp, folder):
    """mode: on, off, or picture: as the add-on renders it."""
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = mode == "on"
    kept = switches.Switches(scene)
    if mode == "picture":
        kept.cut_tricks()
        kept.dim_bases()
    scene.cycles.seed, scene.cycles.samples = seed, spp
    im = scene.render.image_settings
    if hasattr(im, "media_type"):
        im.media_type = "IMAGE"
    im.file_format, im.color_mode, im.color_depth = "OPEN_EXR", "RGB", "32"
    scene.render.filepath = os.path.join(folder, "cycles.exr")
    bpy.ops.render.render(write_still=True)
    kept.restore()
    return layers(scene.render.filepath)[""]


class Reference:
    """Cycles' off and on - off: means, standard errors of each pixel and of the mean."""

    def __init__(self, off, mean, error, error_of_mean, seeds):
        self.off, self.mean, self.error, self.error_of_mean, self.seeds = off, mean, error, error_of_mean, seeds

    @property
    def relative_error(self):
        return self.error_of_mean / self.mean.mean()


def long_reference(name):
    """From bench/cycles, if this Blender made it."""
    with open(os.path.join(REFERENCES, "table.tsv"), encoding="utf-8") as file:
        for row in csv.DictReader(file, delimiter="\t"):
            if row["file"] == name + ".exr" and row["blender"] == bpy.app.version_string:
                kept = layers(os.path.join(REFERENCES, row["file"]))
                return Reference(kept["off"], kept[""], kept["se"], float(row["se_of_mean"]), int(row["seeds"]))
    return None


def of_seeds(pairs):
    """pairs: [(off, on - off)] by seeds. The mean's error: by the seeds' means, or the pixels' own as if those were independent."""
    off, x = (np.stack(p) for p in zip(*pairs))
    k = len(x)
    error = x.std(0, ddof=1) / k**0.5
    whole = max(x.mean((1, 2, 3)).std(ddof=1) / k**0.5, np.sqrt((error.mean(-1)**2).sum()) / error[..., 0].size)
    return Reference(off.mean(0), x.mean(0), error, whole, k)


def reference(name, scene, folder, work, a):
    found = long_reference(name)
    if found:
        return found
    pattern = scene.cycles.sampling_pattern.lower()
    kept = os.path.join(work, f"{name}_{bpy.app.version_string}_{a.spp}_{pattern}")
    os.makedirs(kept, exist_ok=True)
    pairs = []
    for seed in range(a.seeds):
        path = os.path.join(kept, f"{seed}.npz")
        if not os.path.exists(path):
            off = cycles(scene, "picture", seed, a.spp, folder)
            np.savez(path + ".incomplete.npz", off=off, caustics=cycles(scene, "on", seed, a.spp, folder) - off)
            os.replace(path + ".incomplete.npz", path)
        with np.load(path) as file:
            pairs.append((file["off"], file["caustics"]))
        if len(pairs) >= FEWEST and of_seeds(pairs).relative_error <= a.within / 100:
            break
    return of_seeds(pairs)


# ---- ours ----

def ours(name, scene, folder, photons):
    """([what the add-on adds], [estimator R's beauty], the picture's passes), of other seeds each."""
    case, added, beauty = Case(), [], []
    case.folder = folder
    for k in range(OURS):
        scene.cycles.samples = 4
        job = caustics.generate(output=os.path.join(folder, "out"), photons=photons, seed=k, indirect="ON", keep_beauty=True)
        picture = layers(job.beauty)
        added.append(layers(job.result)["ViewLayer.Combined"] - picture["ViewLayer.Combined"])
        made = caustics.export(os.path.join(folder, "scene"))
        region = ["--region", ",".join(map(str, made.region))] if made.region else []
        total = case.render_export(made, "--estimator", "R", "--layers", "beauty", "--photons", str(PATHS), "--seed", str(k), *region)[""]
        if made.region:
            x0, y0, x1, y1 = made.region
            total = total[y0:y1, x0:x1]
        beauty.append(total)
    return added, beauty, picture


# ---- verdicts ----

def blocks(x):
    h, w = (n // BLOCK * BLOCK for n in x.shape[:2])
    return x[:h, :w].mean(-1).reshape(h // BLOCK, BLOCK, w // BLOCK, BLOCK).mean((1, 3))


def ratio(mine, theirs, error):
    """Of the means, and its standard error; mine: pictures, theirs: one and its mean's error."""
    a, b = np.array([p.mean() for p in mine]), theirs.mean()
    if b == 0:  # the sea's floor without caustics
        return (1.0 if not a.any() else np.inf), 0.0
    r = a.mean() / b
    return r, abs(r) * np.hypot(a.std(ddof=1) / len(a)**0.5 / a.mean(), error / b)


def allowed(name):
    return RELATIVE_PLASTIC if name == "plastic_room" and bpy.app.version < (4, 0, 0) else RELATIVE


def beyond(mine, cycles_of, relative):
    """(blocks beyond, blocks looked at). A block's spread over few seeds is a rough guess: at least that of its neighbourhood."""
    made = np.stack([blocks(p) for p in mine])
    spread = made.std(0, ddof=1) / len(made)**0.5
    error = np.hypot(np.sqrt(blocks(cycles_of.error**2)) / BLOCK, np.maximum(spread, 0.3 * np.sqrt((spread**2).mean())))
    theirs = blocks(cycles_of.mean)
    bright = theirs > DARK * theirs.mean()
    off = np.abs(made.mean(0) - theirs)
    at = np.unravel_index(np.argmax(np.where(bright, (off - relative * theirs) / error, -np.inf)), off.shape)
    print(f"  farthest block {at[0]},{at[1]}: {made.mean(0)[at]:.5f} against {theirs[at]:.5f} +- {error[at]:.5f}", flush=True)
    return int(((off > relative * theirs + BLOCK_SIGMAS * error) & bright).sum()), int(bright.sum())


def seen(picture, mine, cycles_of):
    """Of what mirrors and glass in front show: they have no Diffuse Color."""
    albedo = next(v for k, v in picture.items() if k.endswith(("DiffCol", "Diffuse Color")))
    for what, mask in built.halves(albedo).items():
        error = np.sqrt((cycles_of.error[mask].mean(-1)**2).sum()) / mask.sum()
        r, sigma = ratio([x[mask] for x in mine], cycles_of.mean[mask], error)
        print(f"  {what}: {mask.sum()} pixels, caustics / Cycles {r:.4f} +- {sigma:.4f}", flush=True)


def compare(name, work, a):
    start = time.time()
    with tempfile.TemporaryDirectory() as folder:
        scene = build(name)
        base = reference(name, scene, folder, work, a)
        plain = cycles(scene, "off", 0, a.spp, folder).mean() if bases.needed() else base.off.mean()
        added, beauty, picture = ours(name, scene, folder, a.photons)
    r, sigma = ratio(added, base.mean, base.error_of_mean)
    far, looked = beyond(added, base, allowed(name))
    b, b_sigma = ratio(beauty, base.off, 0)
    if name == "textured_seen":
        seen(picture, added, base)
    textured = name.startswith("textured")  # R has the mean in place of the texture
    known = base.relative_error <= a.within / 100
    good = abs(r - 1) <= allowed(name) + SIGMAS * sigma and far <= BLOCKS_BEYOND * looked and (textured or abs(b - 1) <= RELATIVE + SIGMAS * b_sigma)
    print(f"COMPARE {bpy.app.version_string} {name:13} caustics / Cycles {r:.4f} +- {sigma:.4f} (Cycles' {100 * base.relative_error:.2f} %, {base.seeds} seeds), "
          f"blocks beyond {far} of {looked}; beauty / Cycles {b:.4f} +- {b_sigma:.4f}; picture / Cycles off {base.off.mean() / plain if plain else 1:.4f}; "
          f"{time.time() - start:.0f} s: {'FAILS' if not good else 'ok' if known else 'UNTESTED: noise'}", flush=True)
    return good and known


def main():
    p = argparse.ArgumentParser()
    p.add_argument("names", nargs="*")
    p.add_argument("--spp", type=int, default=512)
    p.add_argument("--within", type=float, default=0.7, help="per cent: Cycles' standard error of the mean")
    p.add_argument("--seeds", type=int, default=200, help="at most")
    p.add_argument("--photons", type=float, default=5e5)
    p.add_argument("--work", default=os.path.join(ROOT, "build", "against_cycles"))
    a = p.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    good = [compare(n, os.path.abspath(a.work), a) for n in a.names or [*FILES, *built.SCENES]]
    sys.stdout.flush()
    os._exit(0 if all(good) else 1)


main()
