# SPDX-License-Identifier: Apache-2.0
"""Making caustics for one frame, step by step: beauty, scene, layers, sum.

Job.steps() is a generator that yields whenever it waits, so that an operator can run it from a timer and a script to its
end; it owns no thread. Closing it, or an error in it, ends the child and puts all settings back."""
import os
import time

import bpy

from . import bake, engine, extract, inprocess, pictures, programs, switches, views
from .errors import Cancelled, CausticsError, written

WAIT_S = 0.05
BYTES_PER_TRIANGLE = 240  # at its peak: caustic-render with a mesh of 565,000 triangles, measured


class Job:
    """scene, view_layer: names. options: an Options. interactive: the beauty renders as Blender's own job, not blocking.
    Readable while it runs: stage, progress (0 to 1), text; afterwards caustics, beauty, result (paths), plan (text),
    notes (lines), seconds {stage: s}."""

    def __init__(self, scene, view_layer, options, interactive=False):
        self.scene, self.view_layer, self.options, self.interactive = scene.name, view_layer.name, options, interactive
        self.stage, self.progress, self.text = "start", 0.0, "Starting"
        self.beauty = self.caustics = self.result = self.extract = self.child = None
        self.plan, self.notes, self.seconds, self.said, self.said_of_picture = "", [], {}, [], []
        self.switches = switches.Switches(scene)
        self.baker = bake.Baker(scene)
        self.cancelled = False

    def run(self):
        """To the end, in this thread."""
        for _ in self.steps():
            time.sleep(WAIT_S)
        return self

    def cancel(self):
        self.cancelled = True

    def steps(self):
        self.folder = programs.scratch()
        try:
            if not self.options.in_process:
                programs.check("caustic-render")
            programs.check("caustic-merge")
            self.check_scene()
            if self.baker.wanted():
                self.text = "Baking what varies over casters"
                yield from self.timed("bake", self.baker.steps())
            yield from self.timed("beauty", self.make_beauty())
            yield from self.timed("caustics", self.make_caustics())
            if self.beauty:
                yield from self.timed("add", self.add())
            self.stage, self.progress, self.text = "done", 1.0, "Done"
        except OSError as error:
            raise written(error, self.folder) from None
        finally:
            if self.child:
                self.child.stop()
            self.switches.restore()
            programs.remove(self.folder)

    def timed(self, stage, steps):
        self.stage, start = stage, time.monotonic()
        for step in steps:
            if self.cancelled:
                raise Cancelled
            yield step
        if self.cancelled:
            raise Cancelled
        self.seconds[stage] = round(time.monotonic() - start, 3)

    # ---- the scene and its beauty ------------------------------------------------------------------------------------

    def check_scene(self):
        scene = bpy.data.scenes[self.scene]
        if scene.render.engine != "CYCLES":
            raise CausticsError(f"The scene renders with {scene.render.engine}; caustics add to pictures of Cycles: choose it as the render engine.")
        if scene.camera is None:
            raise CausticsError("The scene has no camera; add one and make it active.")
        on = scene.cycles.caustics_reflective or scene.cycles.caustics_refractive
        if self.options.beauty == "LAST" and on:
            raise CausticsError("The last render may hold caustics of Cycles' own, and would have them twice; switch reflective and "
                                "refractive caustics off and render again, or let the add-on render the picture.")

    def look(self, _, depsgraph):
        if depsgraph.scene.name == self.scene and depsgraph.view_layer.name == self.view_layer and not self.extract:
            start = time.monotonic()
            self.extract = extract.Extract(self.folder, self.options.pointers, self.baker).read(depsgraph)
            self.seconds["scene"] = round(time.monotonic() - start, 3)

    def make_beauty(self):
        scene = bpy.data.scenes[self.scene]
        self.text = "Rendering the picture without caustics" if self.options.beauty == "RENDER" else "Reading the scene"
        path = os.path.join(self.folder, "beauty.exr")
        if self.options.beauty == "RENDER":
            yield from self.render_beauty(scene)
        else:
            engine.look_at(scene, self.view_layer, self.look)
        if not self.extract:
            raise CausticsError(f'View layer "{self.view_layer}" is not rendered; switch on its "Use for Rendering".')
        if self.options.beauty != "NONE":
            self.save_render(scene, path)
            self.beauty = path
        yield

    def render_beauty(self, scene):
        self.switches.caustics_off()
        self.switches.cut_tricks()
        self.said_of_picture = self.switches.dim_bases()
        self.switches.set(("render",), "use_sequencer", False)
        self.switches.set(("view_layers", self.view_layer), "use_pass_diffuse_color", True)
        hook = engine.Hook(self.look).open()
        try:
            if self.interactive:
                yield from self.render_as_job()
            else:
                bpy.ops.render.render(scene=self.scene)
        except RuntimeError as error:
            raise CausticsError("Cycles: " + str(error).replace("Error: ", "").strip().splitlines()[-1]) from None
        finally:
            hook.close()
            self.switches.restore()
        if hook.error:
            raise hook.error
        yield

    def render_as_job(self):
        ended = []

        def done(*_):
            ended.append("done")

        def stopped(*_):
            ended.append("stopped")

        bpy.app.handlers.render_complete.append(done)
        bpy.app.handlers.render_cancel.append(stopped)
        try:
            bpy.ops.render.render("INVOKE_DEFAULT", scene=self.scene)
            while not ended or bpy.app.is_job_running("RENDER"):
                yield
        finally:
            bpy.app.handlers.render_complete.remove(done)
            bpy.app.handlers.render_cancel.remove(stopped)
        if "stopped" in ended:
            raise Cancelled

    def save_render(self, scene, path):
        image = bpy.data.images.get("Render Result")
        if image is None:
            raise CausticsError("There is no last render; let the add-on render the picture.")
        settings = ("render", "image_settings")
        kept = switches.Switches(scene)
        kept.keep(settings, ("media_type", "file_format", "color_mode", "color_depth", "exr_codec", "use_exr_interleave"))
        try:
            if hasattr(scene.render.image_settings, "media_type"):  # 5.0 on
                kept.set(settings, "media_type", "MULTI_LAYER_IMAGE")
            kept.set(settings, "file_format", "OPEN_EXR_MULTILAYER")
            kept.set(settings, "color_mode", "RGBA")
            kept.set(settings, "color_depth", "32" if self.options.full_float else "16")
            kept.set(settings, "exr_codec", "ZIP")
            if hasattr(scene.render.image_settings, "use_exr_interleave"):  # 5.0 cannot write parts of uneven pixels
                kept.set(settings, "use_exr_interleave", True)
            image.save_render(path, scene=scene)
        except RuntimeError as error:
            if self.options.beauty == "LAST":
                raise CausticsError("There is no last render; let the add-on render the picture.") from None
            raise CausticsError(f"The picture could not be saved: {str(error).replace('Error: ', '').strip()}.") from None
        finally:
            kept.restore()
        pictures.set_aspect(path, views.aspect(scene.render))

    # ---- layers and sum ----------------------------------------------------------------------------------------------

    @property
    def albedo(self):
        """Receivers with a texture take their color from the Diffuse Color pass."""
        return bool(self.extract.textured) and self.options.beauty == "RENDER"

    def check_extract(self):
        if not any(light.get("casts_caustics", True) for light in self.extract.doc["lights"]) and "world" not in self.extract.doc:
            why = [line for line in self.extract.notes.lines if line.startswith(("Light", "World"))]
            raise CausticsError("The scene has no light that can make caustics; add a sun, point, spot or area light"
                                + (f" ({why[0]})." if why else "."))
        need, have = self.extract.triangles * BYTES_PER_TRIANGLE, self.options.memory_bytes or programs.memory_bytes()
        if need > have:
            raise CausticsError(f"The scene's {self.extract.triangles / 1e6:.1f} million triangles need about {need / 2**30:.1f} GB of memory, more "
                                f"than the {have / 2**30:.1f} GB there are for it; simplify it, or raise Memory in the panel.")

    def make_caustics(self):
        self.check_extract()
        self.text, self.progress = "Tracing photons", 0.0
        path = os.path.join(self.folder, "caustics.exr")
        report = os.path.join(self.folder, "report.json")
        child = inprocess.start(self.options, self.extract, self.albedo, path, report, self.folder, polite=self.interactive)
        yield from self.wait(child, self.follow)
        self.plan = self.child.output()
        self.said = [line for line in self.child.said() if not line.startswith("wrote ")]
        self.notes = self.extract.notes.lines + self.said_of_picture + [s.partition(": ")[2] or s for s in self.said]
        self.caustics = pictures.keep(path, self.options.path("_caustics"))
        if self.options.keep_report:
            pictures.keep(report, self.options.path("_caustics", ".json"))

    def wait(self, child, follow):
        self.child = child
        while child.running():
            follow(child)
            yield
        child.check()

    def follow(self, child):
        now = child.progress()
        if not now:
            return
        self.text = sentence(now)
        self.progress = max(self.progress, fraction(now, self.options.time_s))  # a forecast may grow, a bar should not shrink

    def add(self):
        self.text, self.progress = "Adding the layers", 1.0
        scene, path = bpy.data.scenes[self.scene], os.path.join(self.folder, "out.exr")
        words = ["add", self.beauty, self.caustics, "-o", path, "--keep-layers", "--pass", f"{self.view_layer}.Combined"]
        words += ["--beauty-space", views.color_space(scene)]
        if self.albedo:
            words += ["--albedo", self.view_layer + "." + pictures.ALBEDO]
        if self.extract.region and scene.render.use_crop_to_border:
            words += ["--offset", "{},{}".format(*self.extract.region[:2])]
        yield from self.wait(programs.Child("caustic-merge", words, self.folder), lambda child: None)
        self.result = pictures.keep(path, self.options.path(""))
        if self.options.keep_beauty:
            self.beauty = pictures.keep(self.beauty, self.options.path("_beauty"))
        else:
            self.beauty = None


def sentence(now):
    """A line of caustic-render's progress in words; before the first pass has ended there are no photons to name."""
    photons = now["photons_per_light"]
    words = ["Looking for caustics" if now["stage"] == "probing" else "Tracing"]
    if photons > 0 and now["stage"] != "probing":
        words = [f"{photons / 1e6:.1f} million photons per light" if photons >= 1e5 else f"{max(photons / 1e3, 1):.0f} thousand photons per light"]
    if now["error"] is not None:
        words.append(f"error {100 * now['error']:.1f} %")
    if now["remaining_s"] is not None:
        words.append(f"{now['remaining_s']:.0f} s left")
    return ", ".join(words)


def fraction(now, time_s):
    """How far a render is: by its own forecast, or of the time that it may take."""
    elapsed = now["elapsed_s"]
    if now["remaining_s"] is not None:
        return elapsed / max(elapsed + now["remaining_s"], 1e-9)
    return min(elapsed / time_s, 1.0) if time_s else 0.0
