# SPDX-License-Identifier: Apache-2.0
"""The add-on in a real window: the button pressed, cancelled half-way, pressed again; pictures of the panels.

  CAUSTICS_BIN=build/bin xvfb-run -a -s "-screen 0 1600x1000x24" blender --factory-startup \
      --window-geometry 0 0 1600 1000 --python bench/blender/window.py -- PICTURES_FOLDER

Prints WINDOW {json}: ticks of a timer of 50 per second and the longest gap between two while the operator ran, and what was left
after the cancel; ends with 1 when something was."""
import json
import os
import sys
import threading
import time
import traceback
import types

import bpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(HERE)), "tests", "blender_addon"))
from support import caustics  # noqa: E402

import blender_scenes  # noqa: E402

from caustics.programs import SCRATCH  # noqa: E402
from caustics.operators import CAUSTICS_OT_generate  # noqa: E402

PICTURES = sys.argv[sys.argv.index("--") + 1]
TICK_S, SLOWEST = 0.02, 10  # ticks a second that the issue asks for
times, stage = [], "none"


def beat():
    job = CAUSTICS_OT_generate.job
    times.append((stage, time.monotonic()))
    if job and stage != "none":
        times.append((f"{stage} {job.stage}", time.monotonic()))
    return TICK_S


def responsiveness(name):
    at = [t for s, t in times if s == name]
    if len(at) < 2:
        return None
    gaps = [b - a for a, b in zip(at, at[1:])]
    return {"seconds": round(at[-1] - at[0], 2), "ticks_per_s": round(len(gaps) / (at[-1] - at[0]), 1), "longest_gap_s": round(max(gaps), 3)}


def window():
    return bpy.context.window_manager.windows[0]


def override(kind):
    area = next(a for a in window().screen.areas if a.type == kind)
    region = next(r for r in area.regions if r.type == "WINDOW")
    return bpy.context.temp_override(window=window(), area=area, region=region)


def screenshot(name, kind=None):
    path = os.path.join(PICTURES, name)
    if kind:
        with override(kind):
            bpy.ops.screen.screenshot_area(filepath=path)
    else:
        with bpy.context.temp_override(window=window()):
            bpy.ops.screen.screenshot(filepath=path)


def scene_state(scene):
    im = scene.render.image_settings
    return [scene.cycles.caustics_reflective, scene.cycles.caustics_refractive, scene.render.engine, im.file_format, im.color_depth,
            scene.render.use_sequencer, scene.view_layers[0].use_pass_diffuse_color]


def prepare():
    path = os.path.join(os.path.dirname(blender_scenes.__file__), "a_ball.json")
    scene, doc = blender_scenes.build(path, types.SimpleNamespace(groups=False))
    blender_scenes.settings(scene, doc, types.SimpleNamespace(spp=16, seed=0, mode="on", res="480x270", threads=0, half=False, multilayer=False))
    caustics.register()
    bpy.context.preferences.view.render_display_type = "NONE"
    bpy.context.preferences.view.show_splash = False
    s = scene.caustics
    s.output, s.quality, s.error_percent = os.path.join(PICTURES, "scene"), "ERROR", 0.1
    return scene


def press():
    with override("PROPERTIES"):
        return bpy.ops.caustics.generate("INVOKE_DEFAULT")


def wait(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        yield


def until(test, seconds):
    end = time.monotonic() + seconds
    while not test() and time.monotonic() < end:
        yield
    assert test(), "timed out"


def arrange():
    for area in window().screen.areas:
        if area.type == "VIEW_3D":
            area.spaces.active.show_region_ui = True
            area.spaces.active.shading.type = "SOLID"
            area.spaces.active.region_3d.view_perspective = "CAMERA"
            region = next(r for r in area.regions if r.type == "UI")
            try:
                region.active_panel_category = "Caustics"  # settable since 4.2
            except (AttributeError, TypeError):
                pass
        if area.type == "PROPERTIES":
            area.spaces.active.context = "RENDER"


def only_our_panel():
    """The Render properties with our panel alone: it comes last, and pictures do not scroll."""
    for name in dir(bpy.types):
        c = getattr(bpy.types, name)
        if getattr(c, "bl_context", "") == "render" and not name.startswith("CAUSTICS") and name != "RENDER_PT_context":
            try:
                bpy.utils.unregister_class(c)
            except RuntimeError:
                pass


def steps():
    global stage
    scene = prepare()
    yield from wait(1.0)
    arrange()
    only_our_panel()
    yield from wait(1.0)
    screenshot("blender_panel.png", "PROPERTIES")
    view = next(a for a in window().screen.areas if a.type == "VIEW_3D")
    view.type = "TEXT_EDITOR"  # drawing the scene in software would be all that is measured
    stage = "idle"
    yield from wait(5.0)
    stage = "none"
    before, threads, figures = scene_state(scene), threading.active_count(), {}
    stage = "cancelled"
    press()
    yield from until(lambda: CAUSTICS_OT_generate.job is None or "error" in CAUSTICS_OT_generate.job.text, 120)
    yield from wait(2.0)  # the panel is drawn twice a second
    screenshot("blender_progress.png", "PROPERTIES")
    child = CAUSTICS_OT_generate.job.child
    bpy.ops.caustics.cancel()
    asked = time.monotonic()
    yield from until(lambda: CAUSTICS_OT_generate.job is None, 20)
    figures["cancel_s"] = round(time.monotonic() - asked, 2)
    stage = "none"
    left = [n for n in os.listdir("/dev/shm") if n.startswith(f"{SCRATCH}{os.getpid()}-")]
    figures.update(idle=responsiveness("idle"), cancelled=responsiveness("cancelled"), restored=scene_state(scene) == before, threads_left=threading.active_count() - threads,
                   child_left=child.process.poll() is None, files_left=[n for n in os.listdir(PICTURES) if n.startswith("scene")], shared_memory_left=left)
    scene.caustics.photons_million = 2.0
    stage = "whole"
    press()
    yield from until(lambda: CAUSTICS_OT_generate.job is None, 300)
    stage = "none"
    figures["stages"] = {s: responsiveness(s) for s in sorted({s for s, _ in times if " " in s})}
    figures.update(whole=responsiveness("whole"), result=os.path.exists(scene.caustics.result), restored_again=scene_state(scene) == before)
    yield from wait(0.5)
    screenshot("blender_plan.png", "PROPERTIES")
    area = view
    area.type = "IMAGE_EDITOR"
    area.spaces.active.image = bpy.data.images["Caustics"]
    yield from wait(1.0)
    with override("IMAGE_EDITOR"):
        bpy.ops.image.view_all(fit_view=True)
    yield from wait(1.0)
    screenshot("blender_result.png")
    area.ui_type = "CompositorNodeTree"
    yield from wait(0.5)
    with override("NODE_EDITOR"):
        bpy.ops.node.view_all()
    yield from wait(1.0)
    screenshot("blender_nodes.png", "NODE_EDITOR")
    print("WINDOW " + json.dumps(figures), flush=True)
    ok = figures["restored"] and figures["restored_again"] and figures["result"] and not (figures["threads_left"] or figures["child_left"] or left) \
        and min(figures[s]["ticks_per_s"] for s in ("cancelled", "whole")) >= SLOWEST
    os._exit(0 if ok else 1)


running = steps()


def drive():
    try:
        next(running)
    except Exception:
        traceback.print_exc()
        os._exit(2)
    return 0.05


bpy.app.timers.register(drive, first_interval=1.0, persistent=True)
bpy.app.timers.register(beat, persistent=True)
