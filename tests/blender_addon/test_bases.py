# SPDX-License-Identifier: Apache-2.0
"""Bases of Principled behind diffuse rays, rough metals and rough glass. What Blender 4.0 needs is run in all."""
import math
import os
import sys
import unittest
import unittest.mock

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import Case, built, caustics, np, run  # noqa: E402

from caustics import bases, ggx, switches  # noqa: E402
from caustics.errors import Notes  # noqa: E402
from caustics.job import Job  # noqa: E402
from caustics.materials import Materials  # noqa: E402


class Bases(Case):
    def plastics(self):
        """A plain and animated, a textured, and a grouped Principled, on three objects of one scene."""
        scene = self.new()
        built.table()
        plain = built.material("plain", "ShaderNodeBsdfPrincipled", Base_Color=(0.2, 0.4, 0.6, 1))
        color = next(n for n in plain.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Base Color"]
        color.keyframe_insert("default_value", frame=1)
        color.default_value = (0.6, 0.4, 0.2, 1)
        color.keyframe_insert("default_value", frame=3)
        textured = built.material("textured", "ShaderNodeBsdfPrincipled")
        picture = textured.node_tree.nodes.new("ShaderNodeTexChecker")
        textured.node_tree.links.new(picture.outputs[0], next(n for n in textured.node_tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Base Color"])
        for i, m in enumerate((plain, textured)):
            built.ball(m.name, m, (i, 1, 0.5), 0.3)
        scene.frame_set(1)
        return scene

    @staticmethod
    def trees(scene):
        """What a user would see of every node tree."""
        return {m.name: (sorted(n.name for n in m.node_tree.nodes), sorted((l.from_socket.path_from_id(), l.to_socket.path_from_id()) for l in m.node_tree.links),
                         [tuple(s.default_value) for n in m.node_tree.nodes for s in n.inputs if s.type == "RGBA"],
                         len(m.node_tree.animation_data.drivers) if m.node_tree.animation_data else 0) for m in bpy.data.materials}

    def test_bases_behind_diffuse_rays(self):
        """Base colors are dimmed where coats are dropped, follow their keys, read as before, and are put back."""
        scene = self.plastics()
        before, plain = self.trees(scene), self.export("plain").doc["materials"]
        with unittest.mock.patch.object(bases, "needed", return_value=True):
            s = switches.Switches(scene)
            self.assertEqual(s.dim_bases(), [])
            self.assertEqual(sorted(w[1] for w in bases.trees()), ["plain", "textured"])
            self.assertEqual(self.export("dimmed").doc["materials"], plain)
            scene.frame_set(2)
            np.testing.assert_allclose(self.export("later").doc["materials"]["plain"]["color"], (0.4, 0.4, 0.4), atol=1e-5)
            scene.frame_set(1)
            switches.Switches(scene).dim_bases()  # a second time, as after a crash: still once
            self.assertEqual(len([n for n in bpy.data.materials["plain"].node_tree.nodes if n.type == "LIGHT_PATH"]), 1)
            s.restore()
        self.assertEqual(self.trees(scene), before)
        self.assertEqual(bases.trees(), [])

    def test_bases_in_a_render(self):
        """They are there for the picture alone, and go after a cancel too."""
        scene, seen = self.plastics(), []
        before = self.trees(scene)
        look = Job.look
        with unittest.mock.patch.object(bases, "needed", return_value=True), \
                unittest.mock.patch.object(Job, "look", lambda job, *a: (seen.append(len(bases.trees())), look(job, *a))):
            self.generate(photons=1000)
            self.assertEqual((seen, self.trees(scene)), ([2], before))
            job = Job(scene, scene.view_layers[0], scene.caustics.options(output=self.path("no")))
            job.cancel()
            self.assertRaises(caustics.errors.Cancelled, job.run)
            self.assertEqual((seen, self.trees(scene)), ([2, 2], before))

    def test_coats_as_cycles_counts_them(self):
        """One minus the Diffuse Color pass of white plastic in 5.2.3; its tables are coarse at grazing angles."""
        for multiscatter, roughness, cos, e in ((False, 0.35, 1.0, 0.0402), (False, 0.35, 0.5, 0.0879), (False, 0.8, 0.5, 0.0594),
                                                (True, 0.5, 1.0, 0.0374), (True, 0.35, 0.5, 0.0842), (True, 0.8, 0.2588, 0.0593)):
            self.assertAlmostEqual(bases.Coat(roughness, 0.04, multiscatter).reflected(cos) / e, 1.0, delta=0.045)

    def test_facets(self):
        """What facets that reflect all give back in a white world: measured in Cycles 5.2.3 (joint) and 3.4.1 (separate)."""
        for roughness, degrees, joint, separate in ((0.5, 0, 0.9158, 0.9158), (0.5, 60, 0.8573, 0.8550), (0.8, 60, 0.6212, 0.6009), (1.0, 85, 0.7801, 0.5645)):
            found = [x.mean() for x in ggx.lobe(math.cos(math.radians(degrees)), ggx.alpha_of(roughness))[1:]]
            np.testing.assert_allclose(found, [joint, separate], atol=0.003)
        for joint in (False, True):
            self.assertAlmostEqual(ggx.gain(0.7, 1.0, True, joint) * ggx.mirror(0.7)[1], 1.0, 6)  # nothing is lost
        self.assertEqual(ggx.gain(0.7, 0.5, False, False), 1.0)
        self.assertLess(ggx.gain(0.7, 0.5, True, False), ggx.gain(0.7, 1.0, True, False))

    def metal(self, roughness, color, multiscatter):
        self.new()
        m = built.material("m", "ShaderNodeBsdfPrincipled", Metallic=1.0, Roughness=roughness, Base_Color=(*color, 1))
        node = next(n for n in m.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
        node.distribution = "MULTI_GGX" if multiscatter else "GGX"
        notes = Notes()
        made = Materials(notes)
        return made.items[made.name_of(m)]["color"], notes.lines

    def test_rough_metal(self):
        """Its color makes up for the light that the renderer's facets lose; where that is too much it is said."""
        color, notes = self.metal(0.5, (0.8, 0.6, 0.3), True)
        self.assertTrue(all(b < c < 1.13 * b for c, b in zip(color, (0.8, 0.6, 0.3))) and color[0] / 0.8 > color[2] / 0.3, color)
        self.assertEqual(notes, [])
        color, notes = self.metal(0.5, (1.0, 0.6, 0.3), True)
        self.assertEqual(color[0], 1.0)
        self.assertIn("its facets reflect 12 % less than in Blender", notes[0])
        self.assertEqual(self.metal(0.0, (0.8, 0.6, 0.3), True)[0], self.metal(0.0, (0.8, 0.6, 0.3), False)[0])

    def test_rough_glass(self):
        """Light that meets more than one facet is given back where Blender does: Glass and Principled, rough, Multiscatter GGX."""
        self.new()
        for kind, more in (("ShaderNodeBsdfGlass", {}), ("ShaderNodeBsdfPrincipled", {"Transmission_Weight" if bpy.app.version >= (4, 0, 0) else "Transmission": 1.0})):
            for roughness, distribution, expected in ((0.5, "MULTI_GGX", "multiple"), (0.5, "GGX", None), (0.0, "MULTI_GGX", None)):
                m = built.material("m", kind, Roughness=roughness, **more)
                next(n for n in m.node_tree.nodes if n.type.startswith("BSDF")).distribution = distribution
                notes = Notes()
                made = Materials(notes)
                item = made.items[made.name_of(m)]
                named = expected and bpy.app.version < (4, 0, 0)  # where Blender's own was another
                self.assertEqual((item["type"], item.get("facets"), len(notes.lines)), ("glass", None if named else expected, 1 if named else 0))

    @unittest.skipUnless(hasattr(bpy.types, "ShaderNodeBsdfMetallic"), "4.3 on")
    def test_metallic(self):
        """By colors and by the constants of gold."""
        self.new()
        m = built.material("m", "ShaderNodeBsdfMetallic", Roughness=0.0, Base_Color=(0.9, 0.6, 0.3, 1), Edge_Tint=(1, 1, 1, 1))
        notes = Notes()
        made = Materials(notes)
        item = made.items[made.name_of(m)]
        self.assertEqual((item["type"], item["edge_color"], item["roughness"], notes.lines), ("metal", [1, 1, 1], 0.0, []))
        np.testing.assert_allclose(item["color"], (0.9, 0.6, 0.3), rtol=1e-5)
        node = next(n for n in m.node_tree.nodes if n.type == "BSDF_METALLIC")
        node.fresnel_type = "PHYSICAL_CONDUCTOR"
        node.inputs["IOR"].default_value, node.inputs["Extinction"].default_value = (0.18, 0.42, 1.37), (3.42, 2.35, 1.77)
        made = Materials(notes)
        np.testing.assert_allclose(made.items[made.name_of(m)]["color"], (0.944, 0.776, 0.374), atol=0.01)
        node.fresnel_type, node.inputs["Edge Tint"].default_value = "F82", (0.7, 0.7, 0.7, 1)
        made = Materials(notes)
        made.name_of(m)
        self.assertEqual(notes.lines, ['Material "m": its edge tint is left out; it is brighter at grazing angles'])

    @unittest.skipUnless(bpy.app.version >= (5, 2, 0), "5.2 on")
    def test_left_out(self):
        """What only late versions of Principled have is named."""
        self.new()
        m = built.material("m", "ShaderNodeBsdfPrincipled", Diffuse_Roughness=0.5, Thin_Wall=True)
        notes = Notes()
        Materials(notes).name_of(m)
        self.assertEqual(notes.lines, ['Material "m": the thin wall is left out', 'Material "m": the roughness of its base (Oren-Nayar) is left out'])


if __name__ == "__main__":
    import __main__
    run(__main__)
