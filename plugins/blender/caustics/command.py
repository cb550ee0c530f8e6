# SPDX-License-Identifier: Apache-2.0
"""For scripts and farms:

  blender -b shot.blend --python-expr "import caustics; caustics.generate()"
  blender -b shot.blend -- --caustics --quality good --frames 1-240
  blender -b shot.blend --command caustics --quality good        (4.2 and later)
"""
import argparse
import os
import sys

import bpy

from . import bake, engine, extract, show
from .errors import CausticsError, written
from .job import Job


def generate(scene=None, view_layer=None, nodes=False, follow_lights=False, frames=None, **options):
    """Makes the caustics of a scene, in this thread. Options that are not given are those of the scene's panel; their names
    are those of options.Options. frames: (first, last[, step]); frames whose result exists are left out. Returns the Job, or
    a list of them with frames. Raises CausticsError with a sentence."""
    scene = scene or bpy.context.scene
    layer = view_layer or (bpy.context.view_layer if scene == bpy.context.scene else scene.view_layers[0])
    chosen = scene.caustics.options(**options)
    if frames is None:
        job = Job(scene, layer, chosen).run()
        scene.caustics.show(job)
        show.images(job)
        if nodes:
            job.notes += show.nodes(job, follow_lights)
        return job
    was, made = scene.frame_current, []
    try:
        for frame in range(frames[0], frames[1] + 1, frames[2] if len(frames) > 2 else 1):
            of_frame = chosen.frame(frame)
            if os.path.exists(of_frame.path("" if chosen.beauty != "NONE" else "_caustics")):
                continue
            scene.frame_set(frame)
            made.append(Job(scene, layer, of_frame).run())
    finally:
        scene.frame_set(was)
    return made


def export(folder, scene=None, view_layer=None, pointers=True):
    """Writes the scene as FOLDER/scene.json with FOLDER/meshes. Returns the Extract: path, notes, doc."""
    scene = scene or bpy.context.scene
    layer = view_layer or (bpy.context.view_layer if scene == bpy.context.scene else scene.view_layers[0])
    if scene.render.engine != "CYCLES":
        raise CausticsError(f"The scene renders with {scene.render.engine}; only scenes of Cycles are read: choose it as the render engine.")
    meshes = os.path.join(folder, "meshes")
    try:
        os.makedirs(meshes, exist_ok=True)
        for name in os.listdir(meshes):
            if name.endswith(".ply"):
                os.unlink(os.path.join(meshes, name))
        made = extract.Extract(folder, pointers, bake.Baker(scene).run())
        engine.look_at(scene, layer.name, lambda _, depsgraph: made.read(depsgraph))
    except OSError as error:
        raise written(error, folder) from None
    return made


def parser():
    p = argparse.ArgumentParser(prog="--caustics", description="Makes caustics of the open file's scene.")
    p.add_argument("--scene", help="its name; default: the file's")
    p.add_argument("-o", "--output", help="path of the result, without ending")
    p.add_argument("--quality", help="draft, good, final, or an error as 0.05")
    p.add_argument("--time", type=float, dest="time_s", help="seconds at most per frame")
    p.add_argument("--photons", type=float, help="per light, in place of quality and time")
    p.add_argument("--beauty", choices=("render", "none"), help="render: picture and caustics; none: layers only")
    p.add_argument("--frames", help="A-B or A-BxSTEP; what exists is left out")
    p.add_argument("--seed", type=int)
    p.add_argument("--threads", type=int)
    p.add_argument("--export", metavar="FOLDER", help="write the scene file there, render nothing")
    return p


def frame_range(text):
    span, _, step = text.partition("x")
    first, _, last = span.partition("-")
    try:
        return int(first), int(last or first), int(step or 1)
    except ValueError:
        raise CausticsError(f'--frames is "{text}"; it must be A-B or A-BxSTEP.') from None


def main(words):
    """Returns the exit code."""
    try:
        given = vars(parser().parse_args(words))
    except SystemExit as end:
        return end.code
    scene_name, folder, frames = given.pop("scene"), given.pop("export"), given.pop("frames")
    options = {k: v for k, v in given.items() if v is not None}
    if "beauty" in options:
        options["beauty"] = options["beauty"].upper()
    try:
        if scene_name and scene_name not in bpy.data.scenes:
            raise CausticsError(f'There is no scene "{scene_name}"; there are {", ".join(s.name for s in bpy.data.scenes)}.')
        scene = bpy.data.scenes[scene_name] if scene_name else None
        if folder:
            made = export(os.path.abspath(folder), scene)
            say(made.notes.lines, made.path)
            return 0
        jobs = generate(scene, frames=frame_range(frames) if frames else None, **options)
        for job in jobs if frames else [jobs]:
            say(job.plan.splitlines() + job.notes, job.result or job.caustics)
        return 0
    except CausticsError as error:
        print(f"caustics: {error}", file=sys.stderr, flush=True)
        return 1


def say(lines, path):
    for line in lines:
        print("caustics:", line.strip())
    print("caustics: wrote", path, flush=True)


def asked():
    """The words behind `-- --caustics`; None where they are not there."""
    words = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    return words[1:] if words[:1] == ["--caustics"] else None


@bpy.app.handlers.persistent
def run_asked(*_):
    """Once, when the file of the command line is open."""
    bpy.app.handlers.load_post.remove(run_asked)
    code = main(asked())
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code or 0)  # sys.exit() in a handler is caught by Blender


handles = []  # of commands, given back when the add-on goes


def register():
    if hasattr(bpy.utils, "register_cli_command"):
        handles.append(bpy.utils.register_cli_command("caustics", main))
    if bpy.app.background and asked() is not None and run_asked not in bpy.app.handlers.load_post:
        bpy.app.handlers.load_post.append(run_asked)


def unregister():
    while handles:
        bpy.utils.unregister_cli_command(handles.pop())
    if run_asked in bpy.app.handlers.load_post:
        bpy.app.handlers.load_post.remove(run_asked)
