# SPDX-License-Identifier: Apache-2.0
"""Node trees as materials of the scene format."""
import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import Case, built, np, run  # noqa: E402

from caustics import closures, switches  # noqa: E402
from caustics.errors import Notes  # noqa: E402
from caustics.materials import Materials  # noqa: E402

NEW = bpy.app.version >= (4, 0, 0)


class Surfaces(Case):
    def read(self, m):
        """(material of the scene format, notes)."""
        self.new() if not hasattr(bpy.types.Scene, "caustics") else None
        notes = Notes()
        made = Materials(notes)
        return made.items[made.name_of(m)], notes.lines

    def principled(self, **values):
        self.new()
        renamed = {"Transmission": "Transmission Weight", "Specular": "Specular IOR Level"} if NEW else {}
        m = built.material("m", "ShaderNodeBsdfPrincipled", **{renamed.get(k, k).replace(" ", "_"): v for k, v in values.items()})
        return self.read(m)

    def test_principled(self):
        made, notes = self.principled(Base_Color=(0.5, 0.25, 0.1, 1), Roughness=0.3)
        self.assertEqual((made["type"], made["fresnel"], notes), ("plastic", "dielectric", []))
        self.assertEqual(made.get("base"), None if NEW else "burley")
        np.testing.assert_allclose([made["roughness"], made["specular"], *made["color"]], [0.3, 0.5, 0.5, 0.25, 0.1], rtol=1e-5)
        made, notes = self.principled(Base_Color=(1, 0.8, 0.5, 1), Metallic=1.0, Roughness=0.1)
        self.assertEqual((made["type"], made["edge_color"], notes), ("metal", [1, 1, 1], []))
        made, notes = self.principled(Base_Color=(1, 0.81, 0.64, 1), Transmission=1.0, Roughness=0.0, IOR=1.4)
        self.assertEqual((made["type"], notes), ("glass", []))
        np.testing.assert_allclose(made["color"], [1, 0.9, 0.8] if NEW else [1, 0.81, 0.64], rtol=1e-5)
        made, notes = self.principled(Metallic=0.5)
        self.assertTrue(any("mix of" in line for line in notes), notes)

    def mixed(self, fac, kinds, connect=None):
        self.new()
        m = built.material("m", "ShaderNodeMixShader")
        tree = m.node_tree
        mix = next(n for n in tree.nodes if n.type == "MIX_SHADER")
        if fac is not None:
            mix.inputs[0].default_value = fac
        for kind, s in zip(kinds, mix.inputs[1:]):
            n = tree.nodes.new("ShaderNodeBsdf" + kind)
            if "Roughness" in n.inputs:
                n.inputs["Roughness"].default_value = 0.0
            n.inputs["Color"].default_value = (1, 1, 1, 1) if kind == "Glossy" else (0.5, 0.5, 0.5, 1)
            if "IOR" in n.inputs:
                n.inputs["IOR"].default_value = 1.3
            tree.links.new(n.outputs[0], s)
        if connect:
            connect(tree, mix.inputs[0])
        return m

    def test_mix(self):
        made, notes = self.read(self.mixed(0.0, ("Diffuse", "Glass")))
        self.assertEqual((made, notes), ({"type": "diffuse", "color": [0.5] * 3}, []))
        made, notes = self.read(self.mixed(0.25, ("Diffuse", "Diffuse")))
        self.assertEqual((made, notes), ({"type": "diffuse", "color": [0.5] * 3}, []))
        made, notes = self.read(self.mixed(0.7, ("Diffuse", "Glass")))
        self.assertEqual(made["type"], "glass")
        self.assertIn("stands in", notes[0])

    def fresnel(self, tree, to):
        n = tree.nodes.new("ShaderNodeFresnel")
        n.inputs["IOR"].default_value = 1.3
        tree.links.new(n.outputs[0], to)

    def test_by_fresnel(self):
        made, notes = self.read(self.mixed(None, ("Refraction", "Glossy"), self.fresnel))
        self.assertEqual((made["type"], round(made["ior"], 5), notes), ("glass", 1.3, []))
        made, notes = self.read(self.mixed(None, ("Diffuse", "Glossy"), self.fresnel))
        self.assertEqual((made["type"], notes), ("plastic", []))
        self.assertAlmostEqual(made["specular"], (0.3 / 2.3) ** 2 / 0.08, 5)

    def test_shadow_trick(self):
        """Glass that lets shadow rays through is glass; the link is cut for the render and put back."""
        def connect(tree, to):
            n = tree.nodes.new("ShaderNodeLightPath")
            tree.links.new(n.outputs["Is Shadow Ray"], to)
        m = self.mixed(0.4, ("Glass", "Transparent"), connect)
        made, notes = self.read(m)
        self.assertEqual((made["type"], notes), ("glass", []))
        scene = bpy.context.scene
        built.ball("Ball", m, (0, 0, 1), 0.5)
        self.assertEqual([t[:2] for t in switches.tricks_of(scene)], [("material", "m")])
        s = switches.Switches(scene)
        s.cut_tricks()
        mix = next(n for n in m.node_tree.nodes if n.type == "MIX_SHADER")
        self.assertFalse(mix.inputs[0].is_linked)
        self.assertEqual(mix.inputs[0].default_value, 0.0)
        s.restore()
        self.assertEqual(mix.inputs[0].links[0].from_node.type, "LIGHT_PATH")
        self.assertAlmostEqual(mix.inputs[0].default_value, 0.4, 5)

    def test_node_group(self):
        scene = self.new()
        built.node_group(scene)
        made = self.export()
        self.assertEqual(made.doc["materials"]["grouped"]["type"], "glass")
        self.assertAlmostEqual(made.doc["materials"]["grouped"]["ior"], 1.5, 5)
        self.assertEqual(made.notes.lines, [])

    def test_texture(self):
        scene = self.new()
        built.textured(scene)
        made = self.export()
        self.assertEqual(made.textured, {"white"})
        np.testing.assert_allclose(made.doc["materials"]["white"]["color"], [0.5, 0.3, 0.45], atol=2e-3)

    def test_numbers(self):
        """Constant maths in front of a colour."""
        self.new()
        m = built.material("m", "ShaderNodeBsdfDiffuse")
        tree = m.node_tree
        a, b, c = (tree.nodes.new(k) for k in ("ShaderNodeMath", "ShaderNodeCombineXYZ", "ShaderNodeGamma"))
        a.operation = "MULTIPLY"
        a.inputs[0].default_value, a.inputs[1].default_value = 0.5, 0.5
        for s in b.inputs:
            tree.links.new(a.outputs[0], s)
        tree.links.new(b.outputs[0], c.inputs[0])
        c.inputs[1].default_value = 0.5
        tree.links.new(c.outputs[0], tree.nodes["Diffuse BSDF"].inputs[0])
        made, notes = self.read(m)
        np.testing.assert_allclose(made["color"], [0.5] * 3, rtol=1e-6)
        self.assertEqual(notes, [])

    def test_readers_are_known(self):
        """The types of nodes that are read exist in this Blender."""
        names = {t.bl_rna.identifier for t in bpy.types.ShaderNode.__subclasses__()}
        self.assertIn("ShaderNodeBsdfGlass", names)
        self.assertIn("BSDF_GLASS", closures.READERS)


if __name__ == "__main__":
    import __main__
    run(__main__)
