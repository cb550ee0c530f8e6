# SPDX-License-Identifier: Apache-2.0
"""Two million triangles from Blender to the renderer's first photon, three ways:

  CAUSTICS_BIN=build/bin blender -b --factory-startup --python bench/blender/mesh_handover.py

pointer: arrays by address, binary PLY in shared memory; foreach_get: the same without addresses; obj: Blender's own exporter,
a file on disk. Seconds (wall) of the parts, from the button; "photon" is when caustic-render reports the first pass done."""
import json
import os
import subprocess
import sys
import tempfile
import time

import bpy

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(HERE)), "tests", "blender_addon"))
from support import BIN, built, caustics, np  # noqa: E402

from caustics import engine, extract, programs  # noqa: E402

SIDE = 1000


def sheet():
    """A water sheet of 2 x SIDE^2 triangles above the floor."""
    x = np.linspace(-2, 2, SIDE + 1, dtype="f4")
    x, y = np.meshgrid(x, x)
    v = np.stack([x, y, 1 + 0.02 * np.sin(7 * x) * np.cos(5 * y)], -1).reshape(-1, 3).astype("f4")
    i = np.arange(SIDE)[None] + np.arange(SIDE)[:, None] * (SIDE + 1)
    quads = np.stack([i, i + 1, i + SIDE + 2, i + SIDE + 1], -1).reshape(-1).astype("i4")
    me = bpy.data.meshes.new("Sheet")
    me.vertices.add(len(v))
    me.vertices.foreach_set("co", v.ravel())
    me.loops.add(len(quads))
    me.loops.foreach_set("vertex_index", quads)
    me.polygons.add(len(quads) // 4)
    me.polygons.foreach_set("loop_start", np.arange(0, len(quads), 4, dtype="i4"))
    if bpy.app.version < (4, 1, 0):
        me.polygons.foreach_set("loop_total", np.full(len(quads) // 4, 4, "i4"))
    me.polygons.foreach_set("use_smooth", np.ones(len(quads) // 4, bool))
    me.update(calc_edges=True)
    me.materials.append(bpy.data.materials["glass"])
    return built.link("Sheet", me)


def first_photon(path, start):
    """Seconds until the renderer's first pass is done, by its own progress."""
    out = os.path.join(os.path.dirname(path), "out.exr")
    words = [path, "-o", out, "--progress", "--photons", "100000", "--effects", "direct"]
    child = subprocess.Popen([os.path.join(BIN, "caustic-render"), *words], stderr=subprocess.PIPE, text=True)
    seen = None
    for line in child.stderr:
        if line.startswith("{") and json.loads(line)["photons_per_light"] > 0 and seen is None:
            seen = time.monotonic() - start
    child.wait()
    child.stderr.close()
    return seen


def by_arrays(scene, pointers):
    folder = programs.scratch()
    start = time.monotonic()
    made = extract.Extract(folder, pointers)
    seconds = {}

    def look(_, graph):
        seconds["blender"] = time.monotonic() - start  # its own copy of the scene for a render
        made.read(graph)
    engine.look_at(scene, scene.view_layers[0].name, look)
    seconds["written"] = time.monotonic() - start
    seconds["photon"] = first_photon(made.path, start)
    programs.remove(folder)
    return seconds


def by_obj(scene):
    with tempfile.TemporaryDirectory() as folder:
        made = caustics.export(folder)
        start = time.monotonic()
        bpy.ops.object.select_all(action="DESELECT")
        scene.objects["Sheet"].select_set(True)
        target = os.path.join(folder, "sheet.obj")
        bpy.ops.wm.obj_export(filepath=target, export_selected_objects=True, export_materials=False, export_uv=False,
                              export_normals=True, export_triangulated_mesh=True, 
                              forward_axis="Y", up_axis="Z")
        for o in made.doc["objects"]:
            if o["name"] == "Sheet":
                o["file"] = "sheet.obj"
        with open(made.path, "w", encoding="utf-8") as f:
            json.dump(made.doc, f)
        seconds = {"written": time.monotonic() - start}
        seconds["photon"] = first_photon(made.path, start)
        return seconds


scene = built.empty()
built.table()
caustics.register()
sheet()
bpy.context.view_layer.update()
for name, run in (("pointer", lambda: by_arrays(scene, True)), ("foreach_get", lambda: by_arrays(scene, False)), ("obj", lambda: by_obj(scene))):
    for _ in range(1 if name == "obj" else 2):
        print("HANDOVER", name, json.dumps({k: round(v, 2) for k, v in run().items()}), flush=True)
os._exit(0)
