# SPDX-License-Identifier: Apache-2.0
"""What each kind of lamp gives in this Blender, against estimator R of the exported scene:

  CAUSTICS_BIN=build/bin blender -b --factory-startup --python bench/blender/lamps.py

"off": with Normalize off. A floor under one lamp, 48x27 pixels, 512 samples a pixel by both. Prints the ratio of the means and the spread of the pixels'
ratios (noise, and a shape that is not the same); exit code 1 where a mean is 0.5 % off."""
import os
import sys

import bpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(HERE)), "tests", "blender_addon"))
from support import Case, built, layers  # noqa: E402

SAMPLES, WIDTH, HEIGHT, FAR = 512, 48, 27, 0.005
LAMPS = {
    "sun": ("SUN", 3.0, {"angle": 0.2}),
    "wide sun": ("SUN", 3.0, {"angle": 1.2}),
    "point": ("POINT", 100.0, {"shadow_soft_size": 0.05}),
    "spot": ("SPOT", 100.0, {"spot_size": 1.5, "shadow_soft_size": 0.05, "spot_blend": 0.3}),
    "wide point": ("POINT", 100.0, {"shadow_soft_size": 0.6}),
    "wide spot": ("SPOT", 100.0, {"spot_size": 1.5, "shadow_soft_size": 0.6, "spot_blend": 0.3}),
    "sphere": ("POINT", 100.0, {"shadow_soft_size": 0.6, "use_soft_falloff": False}),
    "square": ("AREA", 100.0, {"shape": "SQUARE", "size": 0.5}),
    "rectangle": ("AREA", 100.0, {"shape": "RECTANGLE", "size": 0.5, "size_y": 0.25}),
    "disk": ("AREA", 100.0, {"shape": "DISK", "size": 0.5}),
    "ellipse": ("AREA", 100.0, {"shape": "ELLIPSE", "size": 0.5, "size_y": 0.25}),
    "sun off": ("SUN", 3.0, {"angle": 0.2, "normalize": False}),
    "wide off": ("SUN", 3.0, {"angle": 1.2, "normalize": False}),
    "point off": ("POINT", 100.0, {"shadow_soft_size": 0.2, "normalize": False, "use_soft_falloff": False}),
    "point 0 off": ("POINT", 100.0, {"shadow_soft_size": 0.0, "normalize": False}),
    "spot off": ("SPOT", 100.0, {"spot_size": 1.5, "shadow_soft_size": 0.2, "normalize": False, "use_soft_falloff": False}),
    "square off": ("AREA", 100.0, {"shape": "SQUARE", "size": 0.5, "normalize": False}),
    "ellipse off": ("AREA", 100.0, {"shape": "ELLIPSE", "size": 0.5, "size_y": 0.25, "normalize": False}),
    "spread": ("AREA", 100.0, {"shape": "SQUARE", "size": 0.5, "spread": 1.0}),
}


def settings(scene, path):
    r, c = scene.render, scene.cycles
    r.resolution_x, r.resolution_y, r.resolution_percentage, r.filepath = WIDTH, HEIGHT, 100, path
    c.samples, c.use_denoising, c.use_adaptive_sampling = SAMPLES, False, False
    c.caustics_reflective = c.caustics_refractive = False
    if hasattr(r.image_settings, "media_type"):
        r.image_settings.media_type = "IMAGE"
    r.image_settings.file_format, r.image_settings.color_mode, r.image_settings.color_depth = "OPEN_EXR", "RGB", "32"


def compare(case, name, kind, energy, values):
    """(ratio of the means, spread of the pixels' ratios)."""
    scene = case.new()
    built.table()
    for o in [o for o in scene.objects if o.type != "CAMERA" and o.name != "Floor"]:
        bpy.data.objects.remove(o)
    built.lamp("Lamp", kind, (0.5, -0.5, 2), (0, 0, 0), energy, **values)
    settings(scene, case.path("cycles.exr"))
    bpy.ops.render.render(write_still=True)
    theirs = layers(scene.render.filepath)[""]
    made = case.export(name.replace(" ", "_"))
    paths = str(WIDTH * HEIGHT * SAMPLES)
    ours = case.render_export(made, "--estimator", "R", "--layers", "beauty", "--photons", paths)[""]
    lit = theirs.mean(-1) > 0.1 * theirs.mean()
    return ours.mean() / theirs.mean(), (ours[lit] / theirs[lit]).std()


def main():
    case, good = Case(), True
    case.setUp()
    for name, lamp in LAMPS.items():
        known = getattr(bpy.types, lamp[0].capitalize() + "Light").bl_rna.properties
        if not all(key in known for key in lamp[2]):  # Normalize: 4.5 on; Soft Falloff: 4.0 on
            continue
        ratio, spread = compare(case, name, *lamp)
        good &= abs(ratio - 1) < FAR
        print(f"LAMP {bpy.app.version_string} {name:11} R / Cycles {ratio:.4f}, spread of the pixels {spread:.4f}", flush=True)
    case.doCleanups()
    os._exit(0 if good else 1)


main()
