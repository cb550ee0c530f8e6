# SPDX-License-Identifier: Apache-2.0
"""The Nuke script: it parses, every layer that it names is in the files, and its nodes give our picture."""
import os
import re
import shutil
import unittest

import shots
from shots import SHOTS, exrlib, np, rgb, support
import nuke_script


class Nuke(shots.Shot):
    def script(self, *words, file="out.exr", name="shot.nk"):
        self.run_merge("nuke", self.path(file), "-o", self.path(name), *words)
        return nuke_script.Script(self.path(name))

    def evaluate(self, script, frame=1):
        evaluate = nuke_script.Evaluate(script, frame)
        picture = evaluate(script.nodes["CausticsRelight"])
        for node in script.nodes.values():
            if node.kind == "Read":
                self.assertTrue(os.path.exists(evaluate.files[node.name]))
        return picture

    def colours(self, picture, layer):
        names = nuke_script.channels_of(re.sub(r"\W", "_", layer) or "rgba")[:3]
        return np.stack([picture.channels[n][::-1] for n in names], axis=2)

    def test_equals_add(self):
        for name in SHOTS:
            with self.subTest(name):
                layer, wanted = self.shot(name)
                picture = self.evaluate(self.script())
                self.assert_close(self.colours(picture, layer), wanted)
                self.assert_close(self.colours(picture, ""), wanted)
                if layer:
                    alpha = self.out()[0].channels[layer + ".A"]
                    self.assertTrue(np.array_equal(picture.channels["ViewLayer_Combined.alpha"][::-1], alpha))

    def test_layers_exist(self):
        self.shot("albedo")
        script = self.script()
        there = {nuke_script.nuke_channel(c) for f in ("beauty.exr", "caustics.exr")
                 for part in exrlib.read(self.path(f)) for c in part.channels}
        for layer, channels in script.layers.items():
            self.assertTrue(set(channels) <= there, f"{layer}: {channels}")
        used = {n.knobs[k] for n in script.nodes["CausticsRelight"].inside.values() for k in ("in", "out") if k in n.knobs}
        self.assertTrue(used - {"rgba", "rgb"} <= set(script.layers), used)
        self.assertEqual(len((used - {"rgba"}) & there_layers(there)), 8)

    def test_cropped_beauty(self):
        """What lost its place is moved to it: --offset."""
        whole, part = self.pixels(), np.s_[4:14, 7:27]
        self.make_caustics("plain")
        exrlib.write(self.path("beauty.exr"), [(None, rgb("", whole[part].copy()), dict(support.REC709))])
        self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("out.exr"), "--offset", "7,4")
        self.assert_close(self.colours(self.evaluate(self.script()), ""), self.result())

    def test_overscan_and_crop(self):
        """Data windows that differ from the display windows and from each other."""
        attrs = dict(support.REC709)
        exrlib.write(self.path("beauty.exr"), [(None, rgb("", self.pixels()), attrs)], window=(-3, -2, 26, 17), display=(0, 0, 23, 15))
        lights = {"caustics_key": self.pixels(8, 9)}
        support.write_caustics(self.path("caustics.exr"), lights, window=(2, 3, 10, 10), display=(0, 0, 23, 15))
        self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("out.exr"))
        self.assert_close(self.colours(self.evaluate(self.script()), ""), self.result())

    def test_panel(self):
        """Every light has its knobs; a changed knob is the same as the option, and is read back."""
        self.shot("plain")
        script = self.script()
        panel = {u[1]: u for u in script.nodes["CausticsRelight"].users}
        for light in ("caustics_key", "caustics_rim"):
            for knob, kind in (("ev", "7"), ("gain", "7"), ("tint", "18"), ("mute", "6"), ("solo", "6")):
                self.assertEqual(panel[f"{light}_{knob}"][0], kind)
        text = support.read_bytes(self.path("shot.nk")).decode()
        text = text.replace(" caustics_key_ev 1.25\n", " caustics_key_ev -0.75\n")
        text = text.replace(" caustics_rim_tint {1 1 1}\n", " caustics_rim_tint {0.5 1 0.125}\n")
        text = text.replace(" caustics_rim_gain 0.7\n", "")  # as Nuke saves a knob that is zero
        text = text.replace(" caustics_key_tint {1 0.8 0.25}\n", " caustics_key_tint 0.5\n")  # as it saves equal channels
        support.write_text(self.path("saved.nk"), text)
        self.run_merge("recipe", "--from-nuke", self.path("saved.nk"), "-o", self.path("recipe.json"))
        self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("new.exr"),
                       "--recipe", self.path("recipe.json"))
        self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("flags.exr"), "--ev",
                       "key=-0.75", "--tint", "key=0.5,0.5,0.5", "--gain", "rim=0", "--tint", "rim=0.5,1,0.125")
        self.assertTrue(np.array_equal(self.result("new.exr"), self.result("flags.exr")))

    def test_evaluates_changed_panel(self):
        self.shot("plain")
        self.script()
        text = support.read_bytes(self.path("shot.nk")).decode().replace("_key_mute false", "_key_mute true")
        support.write_text(self.path("shot.nk"), text)
        self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("out.exr"), *SHOTS["plain"][1],
                       "--mute", "key")
        self.assert_close(self.colours(self.evaluate(nuke_script.Script(self.path("shot.nk"))), ""), self.result())

    def test_options_win_over_the_record(self):
        self.shot("plain")
        script = self.script("--ev", "key=3")
        self.assertEqual(script.nodes["CausticsRelight"].knobs["caustics_key_ev"], "3")
        self.assertEqual(script.nodes["CausticsRelight"].knobs["caustics_rim_gain"], "0.7")

    def test_caustics_file(self):
        """Without a beauty its Read is there to be filled in."""
        self.make_caustics("plain")
        script = self.script("--gain", "rim=2", file="caustics.exr")
        self.assertEqual(nuke_script.words(script.nodes["Beauty"].knobs["file"]), [""])
        self.assertEqual(script.nodes["CausticsRelight"].knobs["caustics_rim_gain"], "2")

    def test_sequence(self):
        for frame in (3, 4):
            self.make_beauty("plain", f"b.{frame:04d}.exr")
            self.make_caustics("plain", f"c{frame:02d}.exr")
        self.run_merge("add", self.path("b.####.exr"), self.path("c%02d.exr"), "-o", self.path("out.####.exr"), "--frames",
                       "3-4", "--ev", "key=1", "--quiet")
        script = self.script("--frames", "3-4", file="out.####.exr")
        self.assertEqual((script.nodes["Beauty"].knobs["first"], script.nodes["Beauty"].knobs["last"]), ("3", "4"))
        for frame in (3, 4):
            self.assert_close(self.colours(self.evaluate(script, frame), ""), self.result(f"out.{frame:04d}.exr"))

    def test_paths(self):
        """Relative to the script where the files lie below it, else absolute; odd names survive."""
        self.shot("plain")
        odd = self.path('a b[1]$x"{')
        os.mkdir(odd)
        for name in ("beauty.exr", "caustics.exr"):
            shutil.copy(self.path(name), os.path.join(odd, name))
        self.run_merge("add", f"{odd}/beauty.exr", f"{odd}/caustics.exr", "-o", self.path("out.exr"), *SHOTS["plain"][1])
        below, beside = self.script(), self.script(name='a b[1]$x"{/shot.nk')
        self.assertIn("root.name", below.nodes["Beauty"].knobs["file"])
        self.assertTrue(beside.nodes["Beauty"].knobs["file"].endswith("]/beauty.exr\""))
        os.mkdir(self.path("else"))
        apart = self.script(name="else/shot.nk")
        self.assertNotIn("root.name", apart.nodes["Beauty"].knobs["file"])
        for script in (below, beside, apart):
            self.assert_close(self.colours(self.evaluate(script), ""), self.result())
        said = self.run_merge("nuke", self.path("out.exr")).stdout
        self.assertIn("Group {", said)

    def test_refusals(self):
        self.shot("plain")
        self.refused("nuke", self.path("beauty.exr"), "-o", self.path("x.nk"), says="neither an output of caustic-merge add")
        self.refused("nuke", self.path("out.exr"), "-o", self.path("out.exr"), says="is the input")
        self.refused("nuke", self.path("out.exr"), "--ev", "kye=1", says='did you mean "key"')
        self.refused("nuke", "-o", self.path("x.nk"), says="one file", expect=2)
        self.refused("nuke", self.path("out.exr"), "--frames", "1-4", says="####", expect=2)
        os.remove(self.path("beauty.exr"))
        self.refused("nuke", self.path("out.exr"), says="neither here nor beside it")


def there_layers(channels):
    return {c.split(".")[0] for c in channels}


if __name__ == "__main__":
    unittest.main()
