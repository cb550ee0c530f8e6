# SPDX-License-Identifier: Apache-2.0
"""Runs in Blender after our script: moves sliders, renders the compositor's picture, saves the file; what to do is
JSON in CAUSTICS_JOB: sliders {name: value}, out, blend, again (a script to run once more)."""
import json
import os
import runpy

import bpy

job = json.loads(os.environ["CAUSTICS_JOB"])
scene = bpy.context.scene
if job.get("again"):
    runpy.run_path(job["again"], run_name="__main__")
tree = getattr(scene, "compositing_node_group", None) or scene.node_tree
group, = [n for n in tree.nodes if n.name == "Caustics Relight"]
for name, value in job.get("sliders", {}).items():
    group.inputs[name].default_value = value
for thing in list(bpy.data.objects):
    if thing.type != "CAMERA":
        bpy.data.objects.remove(thing)
render = scene.render
render.engine, scene.cycles.samples, scene.cycles.device, scene.cycles.use_denoising = "CYCLES", 1, "CPU", False
render.threads_mode, render.threads, render.use_sequencer = "FIXED", 1, False
if job.get("resolution"):
    render.resolution_x, render.resolution_y = job["resolution"]
if job.get("frame"):
    scene.frame_set(job["frame"])
print("BUILT " + json.dumps({"sockets": [s.name for s in group.inputs], "size": [render.resolution_x, render.resolution_y],
                             "groups": [g.name for g in bpy.data.node_groups if g.get("caustics_relight")],
                             "version": bpy.app.version_string}), flush=True)
if job.get("blend"):
    bpy.ops.wm.save_as_mainfile(filepath=job["blend"])
if job.get("out"):
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth, settings.exr_codec = "OPEN_EXR", "RGBA", "32", "NONE"
    render.filepath = job["out"]
    bpy.ops.render.render(write_still=True)
