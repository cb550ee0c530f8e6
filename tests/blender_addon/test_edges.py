# SPDX-License-Identifier: Apache-2.0
"""What scenes of productions have: each works, or one sentence names it."""
import errno
import os
import sys
import unittest
import unittest.mock

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import Case, built, caustics, exrlib, layers, np, run  # noqa: E402

from caustics import extract, handlers, pictures  # noqa: E402


class Edges(Case):
    def table(self):
        scene = self.new()
        built.table()
        scene.render.resolution_x, scene.render.resolution_y = 48, 27
        return scene

    def added(self, job, layer="ViewLayer"):
        return layers(job.result)[layer + ".Combined"] - layers(job.beauty)[layer + ".Combined"]

    def collection(self, scene, name):
        """Puts an object into a collection of its own: that as the view layer has it."""
        o, made = scene.objects[name], bpy.data.collections.new("Own")
        scene.collection.children.link(made)
        scene.collection.objects.unlink(o)
        made.objects.link(o)
        return scene.view_layers[0].layer_collection.children["Own"]

    def noted(self, lines, text):
        self.assertEqual(len([line for line in lines if text in line]), 1, lines)

    @unittest.skipUnless(hasattr(bpy.types.Object, "light_linking") or bpy.app.version >= (4, 0, 0), "4.0 on")
    def test_light_linking(self):
        scene = self.table()
        scene.objects["Key"].light_linking.receiver_collection = bpy.data.collections.new("Lit")
        self.noted(self.export().notes.lines, 'Light "Key": light linking is not built; it shines on everything')

    def test_holdout(self):
        """By the object or by its collection in this view layer: no light is added to what the picture leaves out."""
        for by in ("object", "collection"):
            with self.subTest(by=by):
                scene = self.table()
                if by == "object":
                    scene.objects["Floor"].is_holdout = True
                else:
                    self.collection(scene, "Floor").holdout = True
                job = self.generate(by, keep_beauty=True)
                alpha = next(p.channels[n] for p in exrlib.read(job.beauty) for n in p.channels if n.endswith("Combined.A"))
                self.assertGreater((alpha == 0).mean(), 0.3)
                self.assertEqual(abs(self.added(job)[alpha == 0]).max(), 0)
                self.noted(job.notes, 'Object "Floor": a holdout shows no caustics, in mirrors and through glass either')

    def test_indirect_only(self):
        scene = self.table()
        self.collection(scene, "Ball").indirect_only = True
        ball, = [o for o in self.export().doc["objects"] if o["name"] == "Ball"]
        self.assertIs(ball["visible_to_camera"], False)

    def test_shadow_catcher(self):
        """Its caustics are light over the plate behind it."""
        scene = self.table()
        scene.render.film_transparent = True
        scene.objects["Floor"].is_shadow_catcher = True
        job = self.generate(keep_beauty=True)
        self.noted(job.notes, 'Object "Floor": caustics on a shadow catcher are added as light over its transparent pixels')
        self.assertGreater(self.added(job).max(), 0)

    def test_film_transparent(self):
        scene = self.table()
        scene.render.film_transparent, scene.cycles.samples = True, 64
        bpy.data.objects.remove(scene.objects["Floor"])
        built.mesh("Tile", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)], built.material("white", "ShaderNodeBsdfDiffuse"))
        job = self.generate(keep_beauty=True)
        was, now = (next(p.channels[n] for p in exrlib.read(path) for n in p.channels if n.endswith("Combined.A")) for path in (job.beauty, job.result))
        self.assertTrue((was == 0).any() and (was == 1).any())
        np.testing.assert_array_equal(was, now)
        self.assertGreater(self.added(job)[was == 1].max(), 0)
        clear = was == 0  # and nothing of the tile in the filter of its neighbours
        clear[[0, -1]] = clear[:, [0, -1]] = False
        clear[1:-1, 1:-1] = np.min([clear[1 + y:26 + y, 1 + x:47 + x] for y in (-1, 0, 1) for x in (-1, 0, 1)], axis=0)
        self.assertEqual(abs(self.added(job)[clear]).max(), 0)

    def test_view_layers(self):
        """Caustics are those of one; the others' pictures are kept to the bit, and named."""
        scene = self.table()
        scene.view_layers.new("Second")
        job = self.generate(keep_beauty=True)
        self.noted(job.notes, 'View layer "Second": caustics are those of "ViewLayer"; its own picture stays as it is')
        self.assertGreater(self.added(job).max(), 0)
        self.assertEqual(abs(self.added(job, "Second")).max(), 0)
        job = self.generate("second", view_layer=scene.view_layers["Second"], keep_beauty=True)
        self.noted(job.notes, 'View layer "ViewLayer": caustics are those of "Second"')
        self.assertGreater(self.added(job, "Second").max(), 0)
        self.assertEqual(abs(self.added(job)).max(), 0)

    def test_unit_scale(self):
        """A way to show numbers: Cycles' light does not know of it."""
        scene = self.table()
        doc = self.export().doc
        scene.unit_settings.scale_length = 0.01
        self.assertEqual(self.export("scaled").doc, doc)

    def test_unicode(self):
        scene = self.table()
        names = {"Ball": "Kügelchen \"1\" 球", "Key": "Führung 光", "Floor": "Böden\\n é"}
        for old, new in names.items():
            scene.objects[old].name = new
        bpy.data.materials["glass"].name = "Glas ß/☃"
        job = self.generate("Ünï 文/é'\" $x", keep_beauty=True)
        self.assertTrue(job.result.endswith("é'\" $x.exr") and os.path.exists(job.result))
        self.assertGreater(self.added(job).max(), 0)
        self.assertIn("caustics_F_hrung__", layers(job.caustics))  # names of channels are plain everywhere
        self.assertTrue(any("Führung 光" in line for line in job.plan.splitlines()), job.plan)
        made = self.export("Szene ☃ 文")
        self.assertIn("Kügelchen \"1\" 球", {o["name"] for o in made.doc["objects"]})
        self.render_export(made, "--photons", "1000")

    def test_names_that_become_one(self):
        """Two lights whose names have no letter that a channel may have still have two layers."""
        scene = self.table()
        scene.objects["Key"].name = "光"
        built.lamp("火", "POINT", (-2, -1, 2), (0, 0, 0), 60.0)
        job = self.generate()
        self.assertEqual(len([n for n in layers(job.caustics) if n and not n.endswith("_ind")]), 2, layers(job.caustics).keys())

    def test_follow_lights(self):
        """Gains are driven by the lamps' own strength; what is two lamps' is named."""
        scene = self.table()
        built.lamp("Führung.001", "POINT", (-2, -1, 2), (0, 0, 0), 60.0)
        scene.view_layers[0].lightgroups.add(name="both")
        for i in range(2):
            built.lamp(f"Rim{i}", "POINT", (i, 2, 2), (0, 0, 0), 60.0).lightgroup = "both"
        if hasattr(scene.objects["Key"].data, "exposure"):
            scene.objects["Key"].data.exposure = 1.0
        job = self.generate(nodes=True, follow_lights=True)
        self.noted(job.notes, 'Light group "both": its gain follows no strength, as it has 2 lamps')
        tree = getattr(scene, "compositing_node_group", None) or scene.node_tree
        group = tree.nodes["Caustics Relight"]
        drivers = {d.data_path: d.driver for d in tree.animation_data.drivers}
        self.assertEqual(len(drivers), 2)
        self.assertTrue(all(d.is_valid and d.is_simple_expression for d in drivers.values()), [d.expression for d in drivers.values()])
        scene.objects["Key"].data.energy *= 3
        want = {"Key gain": 3.0, "F_hrung_001 gain": 1.0, "both gain": 1.0}
        if hasattr(scene.objects["Key"].data, "exposure"):
            scene.objects["Key"].data.exposure = 2.0
            want["Key gain"] = 6.0
        bpy.context.view_layer.update()
        now = tree.evaluated_get(bpy.context.evaluated_depsgraph_get()) if hasattr(scene, "compositing_node_group") else tree
        for name, value in want.items():
            self.assertAlmostEqual(now.nodes["Caustics Relight"].inputs[name].default_value, value, 5, name)
        self.assertEqual(group.inputs["both gain"].default_value, 1.0)

    def full(self, *_, **__):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "/somewhere/full")

    def test_full_disk(self):
        """While the scene is written, and while the result is: one sentence, settings back, nothing half."""
        for where, what in ((extract.Extract, "write"), (pictures.shutil, "copyfile")):
            scene = self.table()
            with unittest.mock.patch.object(where, what, self.full):
                self.refused("No space left on device", self.generate)
            self.assertTrue(scene.cycles.caustics_reflective)
            self.assertEqual((os.listdir(self.folder), self.scratch()), ([], []))
        with unittest.mock.patch.object(extract.Extract, "write", self.full):
            self.refused("/somewhere/full cannot be written (No space left on device)", self.export)

    def test_full_disk_in_an_animation(self):
        scene = self.table()
        scene.caustics.with_render, scene.caustics.output, scene.caustics.photons_million = True, self.path("x"), 0.001
        with unittest.mock.patch.object(extract.Extract, "write", self.full):
            bpy.ops.render.render()
        self.assertIsNone(handlers.Session.current)
        self.noted([n.text for n in scene.caustics.notes], "Frame 1: /somewhere/full cannot be written (No space left on device)")

    def test_textures_on_casters(self):
        """What is not a constant on glass or metal is named, with the mean that stands in."""
        scene = self.table()
        tree = bpy.data.materials["glass"].node_tree
        checks = tree.nodes.new("ShaderNodeTexChecker")
        glass = next(n for n in tree.nodes if n.type == "BSDF_GLASS")
        for name in ("Color", "Roughness", "IOR"):
            tree.links.new(checks.outputs["Color" if name == "Color" else "Fac"], glass.inputs[name])
        lines = self.export().notes.lines
        for what in ("color", "roughness", "index of refraction"):
            self.noted(lines, f'Material "glass": its {what} is not constant')


if __name__ == "__main__":
    import __main__
    run(__main__)
