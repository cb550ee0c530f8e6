# SPDX-License-Identifier: Apache-2.0
"""What varies over casters: baked by Cycles, its mean stands in, with a note; nothing of it stays."""
import os
import sys
import unittest.mock

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import Case, built, np, run  # noqa: E402

from caustics import bake  # noqa: E402


def squared(tree, to):
    """x squared, over the body from 0 to 1: its mean over a ball is 1/3, as a ball has as much surface in each slice."""
    place, gradient, power = (tree.nodes.new(k) for k in ("ShaderNodeTexCoord", "ShaderNodeTexGradient", "ShaderNodeMath"))
    power.operation = "POWER"
    power.inputs[1].default_value = 2.0
    tree.links.new(place.outputs["Generated"], gradient.inputs[0])
    tree.links.new(gradient.outputs["Fac"], power.inputs[0])
    tree.links.new(power.outputs[0], to)


class Baking(Case):
    def rough_ball(self):
        scene = self.new()
        ball = built.table()
        tree = bpy.data.materials["glass"].node_tree
        squared(tree, next(n for n in tree.nodes if n.type == "BSDF_GLASS").inputs["Roughness"])
        return scene, ball

    @staticmethod
    def state():
        return {kind: sorted(x.name for x in getattr(bpy.data, kind)) for kind in ("materials", "meshes", "objects", "scenes")}, \
            [w.scene.name for w in bpy.context.window_manager.windows], sorted(n.name for n in bpy.data.materials["glass"].node_tree.nodes)

    def test_roughness(self):
        """The mean by area, in the scene file and in words; what was made for it is gone."""
        self.rough_ball()
        before = self.state()
        made = self.export()
        self.assertAlmostEqual(made.doc["materials"]["glass"]["roughness"], 1 / 3, delta=0.01)
        note, = [line for line in made.notes.lines if "its roughness" in line]
        self.assertIn("baked by Cycles", note)
        self.assertEqual(self.state(), before)

    def test_render(self):
        """The button bakes too, and its render is that of the mean."""
        scene, _ = self.rough_ball()
        job = self.generate(photons=1000)
        self.assertTrue(any("baked by Cycles" in line for line in job.notes), job.notes)
        self.assertEqual(scene.name, bpy.context.window.scene.name)

    def test_by_area(self):
        """A flat caster of two colors, one on a ninth of it, of two faces; another object of the same material has the rest of the say."""
        self.new()
        built.table()
        glass = bpy.data.materials["glass"]
        tree = glass.node_tree
        attribute = tree.nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = "tint"
        tree.links.new(attribute.outputs["Color"], next(n for n in tree.nodes if n.type == "BSDF_GLASS").inputs["Color"])
        bpy.data.objects.remove(bpy.data.objects["Ball"])
        v = [(0, 0, 1), (1, 0, 1), (9, 0, 1), (0, 1, 1), (1, 1, 1), (9, 1, 1)]
        for name, tints in (("One", ((1, 0, 0, 1), (0, 0, 0, 1))), ("Two", ((0, 1, 0, 1), (0, 1, 0, 1)))):
            mesh = built.mesh(name, v, [(0, 1, 4, 3), (1, 2, 5, 4)], glass).data
            tint = mesh.attributes.new("tint", "FLOAT_COLOR", "CORNER")
            tint.data.foreach_set("color", np.array([tints[0]] * 4 + [tints[1]] * 4, "f4").ravel())
        np.testing.assert_allclose(self.export().doc["materials"]["glass"]["color"], (1 / 18, 0.5, 0), atol=0.01)

    def test_left_alone(self):
        """Receivers, constants, what depends on the ray, and inputs inside groups are not baked."""
        scene = self.new()
        built.textured(scene)
        self.assertEqual(bake.Baker(scene).wanted(), {})
        tree = bpy.data.materials["glass"].node_tree
        weight = tree.nodes.new("ShaderNodeLayerWeight")
        tree.links.new(weight.outputs["Facing"], next(n for n in tree.nodes if n.type == "BSDF_GLASS").inputs["Roughness"])
        self.assertEqual(bake.Baker(scene).wanted(), {})

    def test_failure(self):
        """Is said, and leaves nothing."""
        self.rough_ball()
        before = self.state()
        with unittest.mock.patch.object(bake, "weighted", side_effect=RuntimeError("Error: no memory")):
            made = self.export()
        self.assertIn('Material "glass": Cycles could not bake it (no memory)', made.notes.lines)
        self.assertEqual(self.state(), before)


if __name__ == "__main__":
    import __main__
    run(__main__)
