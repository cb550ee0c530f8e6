# SPDX-License-Identifier: Apache-2.0
"""Caustics with every render: F12 and Render Animation.

Each frame's layers are made before Cycles renders its picture, from the same dependency graph: a picture on disk so has its
layers, also when the render is killed and started again. When the picture is written, the layers are added to it."""
import os
import shutil
import time

import bpy
from bpy.app.handlers import persistent

from . import engine, inprocess, pictures, programs, switches, views
from .errors import Cancelled, CausticsError, written
from .extract import Extract


MARK = "caustics_relight"  # property of the nodes that caustic-merge makes


class Session:
    """One render or animation. errors: sentences, for the user at its end."""
    current = None

    def __init__(self, scene):
        self.scene, self.errors, self.made = scene.name, [], {}
        self.options = scene.caustics.options()
        self.layer = next((layer.name for layer in scene.view_layers if layer.use), "")
        self.switches = switches.Switches(scene)
        self.folder = programs.scratch()
        self.hook = engine.Hook(self.look)

    def open(self):
        if not self.options.in_process:
            programs.check("caustic-render")
        self.switches.caustics_off()
        self.switches.cut_tricks()
        self.switches.dim_bases()
        self.switches.set(("view_layers", self.layer), "use_pass_diffuse_color", True)
        self.hook.open()
        return self

    def close(self):
        self.hook.close()
        self.switches.restore()
        programs.remove(self.folder)

    def look(self, render_engine, depsgraph):
        """On the thread that renders."""
        scene = depsgraph.scene_eval
        if depsgraph.scene.name != self.scene or depsgraph.view_layer.name != self.layer:
            return
        options = self.options.frame(scene.frame_current)
        if os.path.exists(options.path("_caustics")) and os.path.exists(options.path("")):
            return
        try:
            self.frame(render_engine, depsgraph, options)
        except Cancelled:
            pass
        except CausticsError as error:
            self.errors.append(f"Frame {scene.frame_current}: {error}")
        except OSError as error:
            self.errors.append(f"Frame {scene.frame_current}: {written(error, self.folder)}")

    def frame(self, render_engine, depsgraph, options):
        place = os.path.join(self.folder, str(depsgraph.scene_eval.frame_current))
        os.makedirs(place, exist_ok=True)
        found = Extract(place).read(depsgraph)
        path = os.path.join(place, "caustics.exr")
        child = inprocess.start(options, found, bool(found.textured), path, os.path.join(place, "report.json"), place)
        try:
            while child.running():
                now = child.progress()
                if now and now["error"] is not None:
                    render_engine.update_stats("Caustics", f"error {100 * now['error']:.1f} %")
                if render_engine.test_break():
                    raise Cancelled
                time.sleep(0.05)
        finally:
            child.stop()
        child.check()
        pictures.keep(path, options.path("_caustics"))
        self.made[found.frame] = found.region, bool(found.textured)
        programs.remove(place)

    def add(self, scene):
        """When a frame's picture is written: the sum, where the picture is an EXR that `add` can read."""
        frame = scene.frame_current
        if frame not in self.made:
            return
        region, textured = self.made.pop(frame)
        options, format_ = self.options.frame(frame), scene.render.image_settings.file_format
        picture = bpy.path.abspath(scene.render.frame_path(frame=frame))
        if not format_.startswith("OPEN_EXR") or not os.path.exists(picture):
            return
        layered = format_ == "OPEN_EXR_MULTILAYER"
        path, copy = (os.path.join(self.folder, name) for name in ("out.exr", "picture.exr"))
        shutil.copyfile(picture, copy)
        pictures.set_aspect(copy, views.aspect(scene.render))
        words = ["add", copy, options.path("_caustics"), "-o", path, "--keep-layers", "--beauty-space", views.color_space(scene)]
        words += ["--pass", self.layer + ".Combined"] if layered else []
        if textured and layered:
            words += ["--albedo", self.layer + "." + pictures.ALBEDO]
        if region and scene.render.use_crop_to_border:
            words += ["--offset", "{},{}".format(*region[:2])]
        child = programs.Child("caustic-merge", words, self.folder)
        child.process.wait()
        child.check()
        pictures.keep(path, options.path(""))


class Guard:
    """While a render runs whose compositor adds our layers: caustics of Cycles' own off, or light would count twice."""
    current = None

    def __init__(self, scene):
        self.switches = switches.Switches(scene)
        self.switches.caustics_off()
        self.switches.cut_tricks()
        self.switches.dim_bases()

    def close(self):
        self.switches.restore()


def added_in_compositor(scene):
    if hasattr(scene, "compositing_node_group"):  # 5.0 on; None without compositing
        tree = scene.compositing_node_group
    else:
        tree = scene.node_tree if scene.use_nodes else None
    return bool(tree and scene.render.use_compositing
                and any(n.get(MARK) and n.bl_idname == "CompositorNodeGroup" and not n.mute for n in tree.nodes))


@persistent
def render_init(scene, *_):
    if scene.render.engine != "CYCLES" or Session.current or Guard.current:
        return
    if not scene.caustics.with_render:
        if added_in_compositor(scene):
            Guard.current = Guard(scene)
        return
    session = None
    try:
        session = Session(scene)
        session.open()
        Session.current = session
    except CausticsError as error:
        if session:
            session.close()
        print("caustics:", error, flush=True)


@persistent
def render_write(scene, *_):
    session = Session.current
    if session and scene.name == session.scene:
        try:
            session.add(scene)
        except CausticsError as error:
            session.errors.append(f"Frame {scene.frame_current}: {error}")
        except OSError as error:
            session.errors.append(f"Frame {scene.frame_current}: {written(error, session.folder)}")


@persistent
def render_end(scene, *_):
    guard, Guard.current = Guard.current, None
    if guard:
        guard.close()
    session, Session.current = Session.current, None
    if not session:
        return
    session.close()
    if session.hook.error:
        session.errors.append(str(session.hook.error))
    original = bpy.data.scenes.get(session.scene)
    if original:
        original.caustics.notes.clear()
    for line in session.errors:
        print("caustics:", line, flush=True)
        if original:
            original.caustics.notes.add().text = line


HANDLERS = (("render_init", render_init), ("render_write", render_write), ("render_complete", render_end), ("render_cancel", render_end))


def register():
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).append(handler)


def unregister():
    if Session.current or Guard.current:
        render_end(None)
    for name, handler in HANDLERS:
        getattr(bpy.app.handlers, name).remove(handler)
