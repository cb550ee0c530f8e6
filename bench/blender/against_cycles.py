# SPDX-License-Identifier: Apache-2.0
"""The add-on's sum against Cycles' own caustics, in the same Blender:

  CAUSTICS_BIN=build/bin blender -b --factory-startup --python bench/blender/against_cycles.py -- [--spp N] [--seeds K] [NAME...]

For each scene of tests/blender_addon/built.py, and files of scenes/, at 96x54: what the add-on adds (its result less its
picture), against (caustics on - that picture at as many samples) of Cycles by the same seeds, K times; and estimator R's beauty of
the exported scene against the picture, which checks camera, lights, filter and materials. "Picture / Cycles off": what the
add-on switches besides Cycles' own caustics (bases.py). A scene passes when the
means differ by at most 2 % + 2 standard errors of both. Blocks of 8x8 pixels: the share beyond 5 % of the mean + 3 of their own
standard errors. A few seeds know their own scatter badly (scene a: 4 of 512 samples are 2.5 % off and say .7 %): where
bench/cycles/reference holds a longer render by this Blender, the mean is judged by that. Prints one line a scene; exit code 1 when
one fails."""
import argparse
import csv
import os
import sys
import tempfile
import time
import types

import bpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(HERE)), "tests", "blender_addon"))
from support import Case, built, caustics, layers, np  # noqa: E402

import blender_scenes  # noqa: E402

from caustics import bases, switches  # noqa: E402

FILES = ("a_ball_sun5", "b_ring", "d_wineglass", "plastic_room")
RELATIVE, SIGMAS, BLOCK = 0.02, 2.0, 8
PATHS = 96 * 54 * 512  # of estimator R


def build(name):
    if name not in FILES:
        built.SCENES[name](built.empty())
        scene = bpy.context.scene
    else:
        scene, doc = blender_scenes.build(os.path.join(os.path.dirname(blender_scenes.__file__), name + ".json"), types.SimpleNamespace(groups=False))
        blender_scenes.settings(scene, doc, types.SimpleNamespace(spp=1, seed=0, mode="on", res="96x54", threads=2, half=False, multilayer=False))
    if hasattr(bpy.types.Scene, "caustics"):
        caustics.unregister()
    caustics.register()
    c = scene.cycles
    c.light_sampling_threshold, c.blur_glossy, c.sample_clamp_indirect, c.sample_clamp_direct = 0.0, 0.0, 0.0, 0.0
    for o in bpy.data.objects:  # Blender's crutches against the terminator of coarse smooth meshes move shadows
        if hasattr(o.cycles, "shadow_terminator_offset"):
            o.cycles.shadow_terminator_offset = o.cycles.shadow_terminator_geometry_offset = 0.0
        elif hasattr(o, "shadow_terminator_shading_offset"):
            o.shadow_terminator_shading_offset = o.shadow_terminator_geometry_offset = 0.0
    return scene


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


def blocks(x):
    h, w = (n // BLOCK * BLOCK for n in x.shape[:2])
    return x[:h, :w].mean(-1).reshape(h // BLOCK, BLOCK, w // BLOCK, BLOCK).mean((1, 3))


def long_reference(name):
    """(mean, standard error) of on - off from bench/cycles, if this Blender made it."""
    with open(os.path.join(os.path.dirname(HERE), "cycles", "reference", "table.tsv")) as file:
        for row in csv.DictReader(file, delimiter="\t"):
            if row["file"] == name + ".exr" and row["blender"] == bpy.app.version_string:
                return float(row["mean"]), float(row["se_of_mean"])
    return None


def against_long(name, mine):
    """As verdict(), the means alone; None without such a reference."""
    found = long_reference(name)
    if not found:
        return None
    a, (mean, error) = np.array([p.mean() for p in mine]), found
    ratio = a.mean() / mean
    sigma = np.hypot(a.std(ddof=1) / len(a)**0.5 / a.mean(), error / mean) * ratio
    print(f"  {name}: caustics / long render of Cycles {ratio:.4f} +- {sigma:.4f}", flush=True)
    return abs(ratio - 1) <= RELATIVE + SIGMAS * sigma


def verdict(mine, theirs, shares=True):
    """mine, theirs: lists of pictures. (ratio, standard error, share of blocks or 0, passes)."""
    a, b = (np.array([p.mean() for p in x]) for x in (mine, theirs))
    ratio = a.mean() / b.mean()
    sigma = np.hypot(a.std(ddof=1) / len(a)**0.5 / a.mean(), b.std(ddof=1) / len(b)**0.5 / b.mean()) * ratio
    passes = abs(ratio - 1) <= RELATIVE + SIGMAS * sigma
    if not shares:
        return ratio, sigma, 0, passes
    ma, mb = (np.array([blocks(p) for p in x]) for x in (mine, theirs))
    sd = np.hypot(ma.std(0, ddof=1) / len(ma)**0.5, mb.std(0, ddof=1) / len(mb)**0.5)
    worst = np.abs(ma.mean(0) - mb.mean(0)) / (mb.mean() + mb.mean(0) + sd)
    at = np.unravel_index(worst.argmax(), worst.shape)
    print(f"  worst block {at[0]},{at[1]}: {ma.mean(0)[at]:.5f} against {mb.mean(0)[at]:.5f} +- {sd[at]:.5f}", flush=True)
    far = np.abs(ma.mean(0) - mb.mean(0)) > 0.05 * mb.mean() + 0.05 * mb.mean(0) + 3 * sd
    return ratio, sigma, far.mean(), passes


def seen(picture, mine, theirs):
    """Of what mirrors and glass in front show: they have no Diffuse Color."""
    albedo = next(v for k, v in picture.items() if k.endswith(("DiffCol", "Diffuse Color")))
    for what, mask in built.halves(albedo).items():
        ratio, sigma = verdict([x[mask][:, None] for x in mine], [x[mask][:, None] for x in theirs], shares=False)[:2]
        print(f"  {what}: {mask.sum()} pixels, caustics / Cycles {ratio:.4f} +- {sigma:.4f}", flush=True)


def compare(name, spp, seeds, photons):
    case = Case()
    with tempfile.TemporaryDirectory() as folder:
        start = time.time()
        scene = build(name)
        case.folder = folder
        on, off, added, beauty = [], [], [], []
        for k in range(seeds):
            off.append(cycles(scene, "picture", k, spp, folder))
            on.append(cycles(scene, "on", k, spp, folder))
        plain = cycles(scene, "off", 0, spp, folder).mean() if bases.needed() else off[0].mean()
        for k in range(seeds):
            scene.cycles.samples = 4
            job = caustics.generate(output=os.path.join(folder, "out"), photons=photons, seed=k, indirect="ON", keep_beauty=True)
            picture = layers(job.beauty)
            added.append(layers(job.result)["ViewLayer.Combined"] - picture["ViewLayer.Combined"])
            made = caustics.export(os.path.join(folder, "scene"))
            region = ["--region", ",".join(map(str, made.region))] if made.region else []
            direct = case.render_export(made, "--estimator", "R", "--layers", "beauty", "--photons", str(PATHS), "--seed", str(k), *region)
            total = direct[""]
            if made.region:
                x0, y0, x1, y1 = made.region
                total = total[y0:y1, x0:x1]
            beauty.append(total)
        c = verdict(added, [a - b for a, b in zip(on, off)])
        b = verdict(beauty, off)
        long = against_long(name, added)
    if name == "textured_seen":
        seen(picture, added, [x - y for x, y in zip(on, off)])
    textured = name.startswith("textured")  # R has the mean in place of the texture
    ok = (c[3] if long is None else long) and (b[3] or textured)
    print(f"COMPARE {name:12} caustics / Cycles {c[0]:.4f} +- {c[1]:.4f}, blocks beyond {100 * c[2]:.1f} %; "
          f"beauty / Cycles {b[0]:.4f} +- {b[1]:.4f}, blocks beyond {100 * b[2]:.1f} %; "
          f"picture / Cycles off {off[0].mean() / plain:.4f}; {time.time() - start:.0f} s: {'ok' if ok else 'FAILS'}", flush=True)
    return ok


def main():
    p = argparse.ArgumentParser()
    p.add_argument("names", nargs="*")
    p.add_argument("--spp", type=int, default=512)
    p.add_argument("--seeds", type=int, default=4)
    p.add_argument("--photons", type=float, default=5e5)
    a = p.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else [])
    good = [compare(n, a.spp, a.seeds, a.photons) for n in a.names or [*FILES, *built.SCENES]]
    sys.stdout.flush()
    os._exit(0 if all(good) else 1)


main()
