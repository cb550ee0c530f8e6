# SPDX-License-Identifier: Apache-2.0
"""The add-on as a guest: install, enable and disable, hostile scenes, handlers, command lines."""
import os
import stat
import subprocess
import sys
import threading
import unittest.mock

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import BIN, HERE, Case, built, caustics, layers, np, run  # noqa: E402

from caustics import engine, handlers, programs  # noqa: E402
from caustics.errors import Cancelled  # noqa: E402
from caustics.job import Job  # noqa: E402

BLENDER = os.environ.get("CAUSTICS_BLENDER", "blender")


def memory_kb():
    with open("/proc/self/status") as f:
        return int(next(line for line in f if line.startswith("VmRSS")).split()[1])

INSTALL = """
import os, sys
sys.path.insert(0, {tests!r})
import bpy, built
built.empty()
built.table()
if bpy.app.version >= (4, 2, 0):
    bpy.ops.extensions.package_install_files(filepath={zip!r}, repo="user_default", enable_on_install=True)
    import bl_ext.user_default.caustics as caustics
else:
    bpy.ops.preferences.addon_install(filepath={zip!r})
    bpy.ops.preferences.addon_enable(module="caustics")
    import caustics
print("INSTALLED", caustics.__file__)
for inside in (False, True):
    caustics.generate(output={out!r} + "_inside" * inside, photons=1000, in_process=inside)
with open("/proc/self/maps") as f:
    print("LOADED", *sorted({{line.split()[-1] for line in f if "libcaustics" in line}}), flush=True)
if not bpy.app.binary_path:  # the module bpy of 4.x falls at its end where a class with a path among its properties is registered
    os._exit(0)
"""


class Guests(Case):
    def table(self):
        scene = self.new()
        built.table()
        scene.render.resolution_x, scene.render.resolution_y, scene.cycles.samples = 32, 18, 1
        return scene

    def test_enable_disable(self):
        """On, render, off, again and again: the same memory, nothing left behind."""
        counts, sizes = set(), []
        for _ in range(int(os.environ.get("CAUSTICS_ROUNDS", 12))):
            scene = self.table()
            self.generate(photons=1000)
            caustics.unregister()
            h = bpy.app.handlers
            ours = [f for name in dir(h) if isinstance(getattr(h, name), list) for f in getattr(h, name) if f.__module__.startswith("caustics")]
            counts.add((len(ours), len(h.render_init), threading.active_count(), hasattr(bpy.types, "CAUSTICS_PT_render"), hasattr(bpy.types.Scene, "caustics")))
            self.assertFalse(hasattr(scene, "caustics"))
            sizes.append(memory_kb())
        self.assertEqual(len(counts), 1, counts)
        print("kB after each round:", *sizes)
        self.assertLess(sizes[-1] - sizes[3], 20000, sizes)  # kB; Blender's own undo and caches settle in the first rounds

    def test_panels_draw(self):
        """Every class is known to Blender by the name that scripts and key maps use."""
        self.table()
        for name in ("CAUSTICS_PT_render", "CAUSTICS_PT_view", "CAUSTICS_PT_object", "CAUSTICS_OT_generate", "CAUSTICS_OT_export"):
            self.assertTrue(hasattr(bpy.types, name), name)
        self.assertTrue(bpy.ops.caustics.generate.poll())
        self.assertFalse(bpy.ops.caustics.cancel.poll())

    def test_operator(self):
        scene = self.table()
        s = scene.caustics
        s.output, s.photons_million, s.threads = self.path("op"), 0.002, 2
        self.assertEqual(bpy.ops.caustics.generate(), {"FINISHED"})
        self.assertTrue(os.path.exists(self.path("op.exr")))
        self.assertEqual(bpy.data.images["Caustics"].filepath, self.path("op.exr"))
        self.assertTrue(any("1 light" in line.text for line in s.plan))
        tree = getattr(scene, "compositing_node_group", None) or scene.node_tree
        group = tree.nodes["Caustics Relight"]
        self.assertTrue({"Key EV", "Key gain", "Key tint", "Key mute"} <= set(group.inputs.keys()))
        self.assertEqual(bpy.ops.caustics.export(filepath=self.path("exported")), {"FINISHED"})
        self.assertTrue(os.path.exists(self.path("exported/scene.json")))

    def test_never_twice(self):
        """With the sliders in the compositor, F12 renders without caustics of Cycles' own, and puts the settings back."""
        scene = self.table()
        self.assertIs(handlers.added_in_compositor(scene), False)  # no compositor yet
        seen = []

        def look(s, *_):
            seen.append((s.cycles.caustics_reflective, s.cycles.caustics_refractive))
        bpy.app.handlers.render_pre.append(look)
        self.addCleanup(bpy.app.handlers.render_pre.remove, look)
        bpy.ops.render.render()
        self.generate(photons=1000, nodes=True)
        bpy.ops.render.render()
        tree = getattr(scene, "compositing_node_group", None) or scene.node_tree
        tree.nodes["Caustics Relight"].mute = True
        bpy.ops.render.render()
        self.assertEqual(seen, [(True, True), (False, False), (False, False), (True, True)])
        self.assertTrue(scene.cycles.caustics_reflective and scene.cycles.caustics_refractive)

    def test_cancel(self):
        """Half-way: settings back, no child, no file, nothing in shared memory."""
        for stage in ("start", "caustics"):
            with self.subTest(stage=stage):
                scene = self.table()
                job = Job(scene, scene.view_layers[0], scene.caustics.options(output=self.path("no"), quality=0.0001, time_s=600))
                with self.assertRaises(Cancelled):
                    for _ in job.steps():
                        if job.stage == stage or stage == "start":
                            job.cancel()
                self.assertTrue(scene.cycles.caustics_reflective and scene.cycles.caustics_refractive)
                self.assertTrue(job.child is None or job.child.process.poll() is not None)
                self.assertEqual([n for n in os.listdir(self.folder) if n.startswith("no")], [])
                self.assertEqual(self.scratch(), [])

    def test_in_process(self):
        """The renderer loaded into Blender makes the program's bytes, says the same, and leaves no thread; also after a cancel."""
        scene = self.table()
        beside, inside = self.generate("beside"), self.generate("inside", in_process=True)
        with open(beside.caustics, "rb") as a, open(inside.caustics, "rb") as b:
            self.assertEqual(a.read(), b.read())
        self.assertEqual((beside.plan, beside.notes), (inside.plan, inside.notes))
        job = Job(scene, scene.view_layers[0], scene.caustics.options(output=self.path("no"), quality=0.0001, time_s=600, in_process=True))
        with self.assertRaises(Cancelled):
            for _ in job.steps():
                if job.stage == "caustics" and job.child:
                    job.cancel()
        self.assertEqual([t.name for t in threading.enumerate() if t.name == "caustics"], [])
        self.assertEqual((self.scratch(), [n for n in os.listdir(self.folder) if n.startswith("no")]), ([], []))
        scene.caustics.with_render, scene.caustics.output, scene.caustics.photons_million = True, self.path("with"), 0.001
        with unittest.mock.patch("caustics.settings.in_process", return_value=True):
            bpy.ops.render.render()
        self.assertTrue(os.path.exists(self.path("with_0001_caustics.exr")), [n.text for n in scene.caustics.notes])

    def test_closed_generator(self):
        """As when Blender ends the operator."""
        scene = self.table()
        steps = Job(scene, scene.view_layers[0], scene.caustics.options(output=self.path("no"), quality=0.0001, time_s=600)).steps()
        for _ in range(3):
            next(steps)
        steps.close()
        self.assertTrue(scene.cycles.caustics_reflective)
        self.assertEqual(self.scratch(), [])

    def test_killed_before(self):
        """What a Blender that was killed left in shared memory goes with the next run."""
        child = subprocess.Popen(["true"])
        child.wait()
        left = f"/dev/shm/{programs.SCRATCH}{child.pid}-x"
        os.makedirs(left)
        place = programs.scratch()
        self.assertFalse(os.path.exists(left))
        programs.remove(place)

    # ---- hostile scenes and machines ---------------------------------------------------------------------------------

    def test_empty(self):
        self.new()
        self.refused("no camera", self.generate)

    def test_other_engine(self):
        scene = self.table()
        scene.render.engine = "BLENDER_WORKBENCH"
        self.refused("Cycles", self.generate)
        self.refused("Cycles", self.export)

    def test_no_light(self):
        scene = self.table()
        bpy.data.objects.remove(scene.objects["Key"])
        self.refused("no light", self.generate)
        bpy.data.objects.remove(scene.objects["Ball"])
        built.lamp("Key", "AREA", (2, 1, 3), (0, 0, 0), 10.0)
        job = self.generate()  # no caster: black layers, the picture as it is
        self.assertTrue(any("black" in line for line in job.notes), job.notes)
        self.assertEqual(layers(job.caustics)["caustics_Key"].max(), 0)

    def test_not_finite(self):
        scene = self.table()
        scene.objects["Ball"].data.vertices[7].co.x = float("nan")
        self.refused('Object "Ball" has a vertex (7)', self.generate)
        self.assertTrue(scene.cycles.caustics_reflective)
        scene = self.table()
        scene.objects["Ball"].location.x = float("inf")
        bpy.context.view_layer.update()
        self.refused('Object "Ball" is placed', self.generate)

    def test_flattened(self):
        """A scale of 0 gives a sentence or a picture, not a crash."""
        scene = self.table()
        scene.objects["Ball"].scale.z = 0
        bpy.context.view_layer.update()
        job = self.generate()
        self.assertTrue(any("scale" in line for line in job.notes), job.notes)

    def test_memory(self):
        scene = self.table()
        scene.objects["Ball"].modifiers.new("Sub", "SUBSURF").render_levels = 5
        self.refused("memory", self.generate, memory="8M")

    def test_denoiser_error(self):
        """Errors of Cycles come through as a sentence, where this Blender has one."""
        scene = self.table()
        scene.cycles.use_denoising = True
        try:
            self.generate()
        except caustics.CausticsError as error:
            self.assertTrue(str(error).startswith("Cycles: "))
        self.assertTrue(scene.cycles.caustics_reflective)

    def test_output(self):
        self.table()
        self.refused("cannot be written", caustics.generate, output="/proc/nowhere/out", photons=1000)

    def test_programs(self):
        """Missing, of another version, broken, not executable."""
        self.table()
        path, kept = os.environ["PATH"], programs.HERE
        program = self.path("caustic-render")
        try:
            os.environ["PATH"] = self.folder
            self.refused("set the folder", self.generate)
            for text, says in (("echo caustic-render 9.9.9", "version 9.9.9"), ("echo no >&2; exit 127", "does not run: no")):
                with open(program, "w") as f:
                    f.write("#!/bin/sh\n" + text + "\n")
                self.refused(says, self.generate)
                self.assertTrue(os.stat(program).st_mode & stat.S_IXUSR)
        finally:
            os.environ["PATH"], programs.HERE = path, kept

    def test_last_render(self):
        scene = self.table()
        self.refused("twice", self.generate, beauty="LAST")
        scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = False
        self.refused("no last render", self.generate, beauty="LAST")
        bpy.ops.render.render()
        job = self.generate(beauty="LAST", keep_beauty=True)
        beauty = layers(job.beauty)["ViewLayer.Combined"]
        self.assertGreater(beauty.mean(), 0.01)  # the scene was read without losing it
        job = self.generate("none", beauty="NONE")
        self.assertIsNone(job.result)
        self.assertTrue(os.path.exists(job.caustics))

    # ---- F12, animation, command line --------------------------------------------------------------------------------

    def animation(self, frames=3):
        scene = self.table()
        scene.frame_start, scene.frame_end = 1, frames
        ball = scene.objects["Ball"]
        for frame, x in ((1, -0.5), (frames, 0.5)):
            ball.location.x = x
            ball.keyframe_insert("location", frame=frame)
        s, im = scene.caustics, scene.render.image_settings
        s.with_render, s.output, s.photons_million, s.threads = True, self.path("film/shot"), 0.003, 2
        if hasattr(im, "media_type"):
            im.media_type = "MULTI_LAYER_IMAGE"
        im.file_format, im.color_depth = "OPEN_EXR_MULTILAYER", "32"
        scene.render.filepath = self.path("beauty_")
        return scene

    def test_with_render(self):
        """Render Animation: a file of layers and a sum for each frame; what is there is not made again."""
        scene = self.animation()
        bpy.ops.render.render(animation=True)
        names = sorted(os.listdir(self.path("film")))
        self.assertEqual(names, sorted(f"shot_{n:04d}{e}.exr" for n in (1, 2, 3) for e in ("", "_caustics")))
        self.assertTrue(scene.cycles.caustics_reflective)
        self.assertIsNone(handlers.Session.current)
        self.assertEqual(list(scene.caustics.notes), [])
        first, last = (layers(self.path(f"film/shot_000{n}_caustics.exr"))["caustics_Key"] for n in (1, 3))
        self.assertGreater(np.abs(first - last).max(), 0.1 * first.max())  # the ball has moved
        mine = layers(self.path("film/shot_0002.exr"))["ViewLayer.Combined"]
        beauty = layers(self.path("beauty_0002.exr"))["ViewLayer.Combined"]
        two = layers(self.path("film/shot_0002_caustics.exr"))
        added = sum(v for k, v in two.items() if k.startswith("caustics_"))
        np.testing.assert_allclose(mine, beauty + added, rtol=2e-6, atol=1e-6)
        self.assertEqual(self.scratch(), [])

    def test_frames(self):
        """generate(frames=...): the same, from a script; a lost frame is made anew, the others are left alone."""
        scene = self.animation()
        scene.caustics.with_render = False
        jobs = caustics.generate(output=self.path("f"), frames=(1, 3))
        self.assertEqual(len(jobs), 3)
        with open(self.path("f_0002.exr"), "rb") as f:
            bytes_2 = f.read()
        os.remove(self.path("f_0002.exr"))
        self.assertEqual(len(caustics.generate(output=self.path("f"), frames=(1, 3))), 1)
        with open(self.path("f_0002.exr"), "rb") as f:
            again = f.read()
        self.assertEqual(len(bytes_2), len(again))

    def test_hook_is_gone(self):
        from cycles import CyclesRender
        kept = CyclesRender.update
        self.table()
        self.generate(photons=1000)
        self.assertIs(CyclesRender.update, kept)
        hook = engine.Hook(lambda *a: None).open()
        self.assertIsNot(CyclesRender.update, kept)
        hook.close()
        self.assertIs(CyclesRender.update, kept)

    def test_zip(self):
        """The zip, installed in a Blender of its own that finds no programs but those in it."""
        place = os.path.join(HERE, "..", "..", "plugins", "blender")
        programs_ = [os.path.join(BIN, n) for n in ("caustic-render", "caustic-merge")]
        made = subprocess.run([sys.executable, os.path.join(place, "make_zip.py"), self.folder, "0.1.0", "linux-x64",
                               os.path.join(place, "..", "..", "LICENSE"), *programs_], capture_output=True, text=True)
        self.assertEqual(made.returncode, 0, made.stderr)
        script = self.path("install.py")
        with open(script, "w") as f:
            f.write(INSTALL.format(tests=HERE, zip=self.path("caustics-0.1.0-linux-x64.zip"), out=self.path("zipped")))
        env = {**os.environ, "BLENDER_USER_RESOURCES": self.path("user"), "PATH": "/usr/bin:/bin", "HOME": self.folder}
        p = subprocess.run([BLENDER, "-b", "--factory-startup", "--python-exit-code", "3", "--python", script], env=env, capture_output=True,
                           text=True, timeout=300)
        self.assertEqual(p.returncode, 0, p.stdout[-2000:] + p.stderr[-2000:])
        self.assertIn("INSTALLED " + self.path("user"), p.stdout)
        self.assertTrue(os.path.exists(self.path("zipped.exr")) and os.path.exists(self.path("zipped_inside.exr")))
        loaded = next(line for line in p.stdout.splitlines() if line.startswith("LOADED")).split()[1:]
        self.assertEqual([os.path.dirname(path).startswith(self.path("user")) for path in loaded], [True, True], loaded)

    def test_command_line(self):
        """blender -b FILE -- --caustics ... in a Blender of its own, where the add-on is enabled by name."""
        if bpy.app.binary_path == "":
            self.skipTest("the module bpy has no command line")
        self.table()
        blend, start = self.path("shot.blend"), self.path("user/scripts/addons")
        bpy.ops.wm.save_as_mainfile(filepath=blend)
        os.makedirs(start)
        os.symlink(os.path.join(HERE, "..", "..", "plugins", "blender", "caustics"), os.path.join(start, "caustics"))
        env = {**os.environ, "BLENDER_USER_SCRIPTS": os.path.dirname(start), "PATH": BIN + os.pathsep + os.environ["PATH"]}

        def blender(*words):
            return subprocess.run([BLENDER, "-b", "--factory-startup", "--addons", "caustics", blend, "--", "--caustics", *words],
                                  env=env, capture_output=True, text=True, timeout=300)
        p = blender("--photons", "1000", "-o", self.path("cli"))
        self.assertEqual(p.returncode, 0, p.stdout + p.stderr)
        self.assertIn("caustics: wrote " + self.path("cli.exr"), p.stdout)
        self.assertTrue(os.path.exists(self.path("cli.exr")))
        p = blender("--quality", "splendid")
        self.assertEqual(p.returncode, 1)
        self.assertIn("quality is splendid", p.stderr)


if __name__ == "__main__":
    import __main__
    run(__main__)
