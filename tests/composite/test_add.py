# SPDX-License-Identifier: Apache-2.0
"""caustic-merge add: what is added, what is left alone."""
import glob
import json
import os
import struct
import subprocess
import unittest

from support import DATA, MERGE, REC709, SAMPLES, Case, int_attr, np, rgb, write_caustics, write_text
import exrlib


class Identity(Case):
    def samples(self):
        found = sorted(glob.glob(os.path.join(SAMPLES, "*.exr")))
        if not found:
            print(f"not run: no sample files in {SAMPLES}; the project's own are used")
        return found or sorted(glob.glob(os.path.join(DATA, "[ad]_*.exr")))  # others: test_blender5.py

    def check_same(self, before, after, except_channels=()):
        self.assertEqual(len(before), len(after))
        for a, b in zip(before, after):
            self.assertEqual(list(a.channels), list(b.channels))
            for name, plane in a.channels.items():
                if name not in except_channels:
                    self.assertTrue(np.array_equal(exrlib.bits(plane), exrlib.bits(b.channels[name])), name)
            for name, value in a.attrs.items():
                self.assertEqual(b.attrs.get(name), value, name)

    def test_gain_0_gives_every_beauty_back(self):
        for path in self.samples():
            with self.subTest(path):
                before = exrlib.read(path)
                x0, y0, x1, y1 = before[0].window
                caustics, _ = self.caustics({"caustics_key": self.pixels(y1 - y0 + 1, x1 - x0 + 1)})
                self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--gain", "key=0")
                self.check_same(before, self.out())

    def test_only_the_pass_changes(self):
        path = os.path.join(DATA, "d_off_ml_groups_crypto_half.exr")
        before, light = exrlib.read(path), self.pixels(180, 320)
        caustics, _ = self.caustics({"caustics_key": light})
        for words, name in [([], "Combined"), (["--pass", "Combined_key"], "Combined_key"),
                            (["--pass", "ViewLayer.Combined_fill"], "Combined_fill")]:
            self.run_merge("add", path, caustics, "-o", self.path("out.exr"), *words)
            changed = [f"ViewLayer.{name}.{c}" for c in "RGB"]
            self.check_same(before, self.out(), changed)
            for i, c in enumerate(changed):
                plane = before[0].channels[c].astype("f8") + light[:, :, i]
                self.assert_exact(self.out()[0].channels[c], plane)

    def test_odd_values_and_attributes_survive(self):
        values = self.pixels().astype("<f2")
        bits = values.view("<u2")
        bits[0, :6, 0] = [0x8000, 0x7c00, 0xfc00, 0x7e01, 0xfe55, 0x0001]  # -0, Inf, -Inf, NaN payloads, denormal
        attrs = {**REC709, "blob": ("someone's own type", b"\0\1\2\xff"), "empty": ("string", b""),
                 "nul": ("string", b"a\0b"), "m": ("m33f", struct.pack("<9f", *range(9))),
                 "d": ("double", struct.pack("<d", 1 / 3)), "r": ("rational", struct.pack("<iI", -1, 24)),
                 "t": ("timecode", struct.pack("<II", 5, 6)), "k": ("keycode", struct.pack("<7i", *range(7))),
                 "fv": ("floatvector", struct.pack("<3f", 1, 2, 3)), "b": ("box2f", struct.pack("<4f", 1, 2, 3, 4)),
                 "sv": ("stringvector", struct.pack("<i", 2) + b"ab" + struct.pack("<i", 0) + struct.pack("<i", 1) + b"c"),
                 "v": ("v3d", struct.pack("<3d", 1, 2, 3)), "env": ("envmap", b"\1"), "v2": ("v2i", b"\1\0\0\0\2\0\0\0"),
                 "m4": ("m44d", struct.pack("<16d", *range(16))), "e": ("chromaticities", struct.pack("<8f", *range(8))),
                 "preview": ("preview", struct.pack("<II", 2, 1) + bytes(range(8))),
                 "a name that is longer than thirty-one characters": ("int", b"\7\0\0\0")}
        exrlib.write(self.path("beauty.exr"), [(None, rgb("", values, "<f2"), attrs)])
        caustics, _ = self.caustics()
        before = exrlib.read(self.path("beauty.exr"))
        self.run_merge("add", self.path("beauty.exr"), caustics, "-o", self.path("out.exr"), "--gain", "key=0",
                       "--mute", "rim")
        self.check_same(before, self.out())
        self.run_merge("add", self.path("beauty.exr"), caustics, "-o", self.path("out.exr"))
        after = self.out()[0].channels["R"].view("<u2")
        self.assertTrue(np.array_equal(after[0, 1:5], bits[0, 1:5, 0]), "NaN and Inf of the beauty pass through")

    def test_multi_part_beauty(self):
        combined, other = self.pixels(), self.pixels().astype("<f2")
        depth = {"ViewLayer.Depth.Z": self.pixels()[:, :, 0], "id": np.arange(600, dtype="<u4").reshape(20, 30)}
        exrlib.write(self.path("beauty.exr"), [
            ("ViewLayer.Combined", {**rgb("ViewLayer.Combined", combined), "ViewLayer.Combined.A": combined[:, :, 0]}, REC709),
            ("ViewLayer.DiffCol", rgb("ViewLayer.DiffCol", other, "<f2"), {"x": exrlib.integer(3)}),
            ("depth", depth, {})])
        caustics, lights = self.caustics()
        before = exrlib.read(self.path("beauty.exr"))
        self.run_merge("add", self.path("beauty.exr"), caustics, "-o", self.path("out.exr"))
        self.check_same(before, self.out(), [f"ViewLayer.Combined.{c}" for c in "RGB"])
        self.assert_exact(self.result(prefix="ViewLayer.Combined"),
                          combined.astype("f8") + lights["caustics_key"] + lights["caustics_rim"])

    def test_decreasing_line_order(self):
        path, values = self.beauty(decreasing=True)
        caustics, lights = self.caustics()
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--solo", "key")
        self.assertEqual(self.out()[0].attrs["lineOrder"][1], b"\1")
        self.assert_exact(self.result(), values.astype("f8") + lights["caustics_key"])


class Factors(Case):
    def add(self, *words, dtype="<f4", **options):
        path, values = self.beauty(dtype=dtype)
        caustics, lights = self.caustics(**options)
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), *words)
        return self.result(), values.astype("f8"), {k: v.astype("f8") for k, v in lights.items()}

    def test_sum(self):
        for dtype in ("<f4", "<f2"):
            for interleave in (False, True):
                got, b, l = self.add(dtype=dtype, interleave=interleave)
                self.assertEqual(got.dtype, np.dtype(dtype))
                self.assert_exact(got, b + l["caustics_key"] + l["caustics_rim"])

    def test_gain_ev_tint_multiply(self):
        got, b, l = self.add("--gain", "key=1.7", "--ev", "caustics_key=-1.5", "--tint=key=1,.5,.25", "--gain", "rim=-2")
        factor = 1.7 * 2 ** -1.5 * np.array([1, .5, .25])
        self.assert_exact(got, b + factor * l["caustics_key"] - 2 * l["caustics_rim"])

    def test_mute_and_solo(self):
        lights = {n: self.pixels() for n in ("caustics_a", "caustics_a_ind", "caustics_b", "caustics_b_ind", "caustics_c",
                                            "caustics_c_err", "caustics_c_E", "caustics_c_S")}
        cases = [([], "a a_ind b b_ind c"), (["--mute", "a"], "b b_ind c"), (["--solo", "a"], "a a_ind"),
                 (["--solo", "a", "--solo", "c"], "a a_ind c"), (["--solo", "a", "--solo", "b", "--mute", "a"], "b b_ind"),
                 (["--gain", "a_ind=0"], "a b b_ind c"), (["--mute", "caustics_b_ind"], "a a_ind b c")]
        for words, heard in cases:
            got, b, l = self.add(*words, lights=lights)
            self.assert_exact(got, b + sum(l["caustics_" + n] for n in heard.split()))

    def test_metadata_rules_over_names(self):
        lights = {"caustics_Key_001": self.pixels(), "caustics_not": self.pixels(), "odd": self.pixels()}
        entries = [{"layer": "caustics_Key_001", "light": "Key.001", "kind": "radiance"},
                   {"layer": "odd", "light": "a=b", "kind": "indirect"}]
        attrs = {"caustics/layers": exrlib.string(json.dumps(entries))}
        got, b, l = self.add("--gain", "Key.001=3", "--ev", "a=b=1", lights=lights, attrs=attrs)
        self.assert_exact(got, b + 3 * l["caustics_Key_001"] + 2 * l["odd"])

    def test_recipe(self):
        recipe = {"caustics_recipe": 1, "lights": {"key": {"gain": 2, "ev": 1, "tint": [1, .5, 0]},
                                                   "caustics_rim": {"mute": True}}}
        write_text(self.path("r.json"), json.dumps(recipe))
        got, b, l = self.add("--recipe", self.path("r.json"))
        self.assert_exact(got, b + 4 * np.array([1, .5, 0]) * l["caustics_key"])
        got, b, l = self.add("--recipe", self.path("r.json"), "--ev", "key=0")
        self.assert_exact(got, b + 2 * np.array([1, .5, 0]) * l["caustics_key"])

    def test_record_is_a_recipe(self):
        first, b, _ = self.add("--gain", "key=2", "--ev", "rim=-3", "--tint", "rim=1,2,3")
        record = json.loads(self.out()[0].attrs["caustics/merge"][1])
        write_text(self.path("r.json"), json.dumps(record["recipe"]))
        self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("out.exr"), "--recipe",
                       self.path("r.json"))
        self.assertTrue(np.array_equal(first, self.result()))

    def test_repairs_and_clamps_are_counted(self):
        light = self.pixels()
        light[0, 0] = [np.nan, 1, np.inf]
        light[1, 1] = [7e4, -7e4, 0]
        got, b, _ = self.add(dtype="<f2", lights={"caustics_key": light})
        self.assertEqual(int_attr(self.out()[0], "caustics/repaired_nan"), 2)
        self.assertEqual(int_attr(self.out()[0], "caustics/clamped"), 2)
        self.assertEqual(list(got[0, 0][[0, 2]]), list(b[0, 0][[0, 2]]))
        self.assertEqual(list(got[1, 1][:2]), [65504, -65504])
        self.assertTrue(np.all(np.isfinite(got)))

    def test_albedo(self):
        albedo, path = self.pixels().astype("<f2"), self.path("beauty.exr")
        base = self.pixels()
        exrlib.write(path, [(None, {**rgb("VL.Combined", base), **rgb("VL.DiffCol", albedo, "<f2")}, REC709)])
        names = ("caustics_k", "caustics_k_ind", "caustics_k_E", "caustics_k_S")
        caustics, l = self.caustics({n: self.pixels() for n in names})
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--albedo", "DiffCol", "--gain", "k=2")
        wanted = albedo.astype("f8") * l["caustics_k_E"] / np.pi + l["caustics_k_S"] + l["caustics_k_ind"]
        self.assert_exact(self.result(prefix="VL.Combined"), base.astype("f8") + 2 * wanted)
        caustics, _ = self.caustics()
        self.refused("add", path, caustics, "-o", self.path("none.exr"), "--albedo", "DiffCol",
                     says=["caustics_key_E", "--layers radiance,irradiance"])


class Windows(Case):
    def test_caustics_are_placed_by_coordinate(self):
        path, values = self.beauty(window=(5, 7, 34, 26), display=(0, 0, 49, 39))
        light = self.pixels(12, 50)
        caustics, _ = self.caustics({"caustics_key": light}, window=(-3, 10, 46, 21), display=(0, 0, 49, 39))
        done = self.run_merge("add", path, caustics, "-o", self.path("out.exr"))
        self.assertIn("dropped", done.stderr)
        wanted = values.astype("f8")
        wanted[3:15] += light[:, 8:38]
        self.assert_exact(self.result(), wanted)
        self.assertEqual(self.out()[0].window, (5, 7, 34, 26))

    def test_offset_of_a_cropped_beauty(self):
        path, values = self.beauty(height=10, width=8)
        light = self.pixels()
        caustics, _ = self.caustics({"caustics_key": light})
        self.refused("add", path, caustics, "-o", self.path("none.exr"), says=["8 x 10", "30 x 20", "--offset"])
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--offset", "4,6")
        self.assert_exact(self.result(), values.astype("f8") + light[6:16, 4:12])
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--offset", "-2,15")
        wanted = values.astype("f8")
        wanted[:5, 2:] += light[15:, :6]
        self.assert_exact(self.result(), wanted)

    def test_refusals(self):
        path, _ = self.beauty(window=(0, 0, 29, 19), display=(0, 0, 99, 99))
        caustics, _ = self.caustics(window=(40, 40, 69, 59), display=(0, 0, 99, 99))
        self.refused("add", path, caustics, "-o", self.path("none.exr"), says=["do not overlap", "(0,0)-(29,19)", "(40,40)-(69,59)"])
        path, _ = self.beauty(aspect=2.0)
        caustics, _ = self.caustics()
        self.refused("add", path, caustics, "-o", self.path("none.exr"), says=["aspect", "2 in", "1 in"])


class Refusals(Case):
    def test_sentences(self):
        path, _ = self.beauty()
        caustics, _ = self.caustics()
        out = ["-o", self.path("none.exr")]
        self.refused("add", path, caustics, *out, "--gain", "kez=2", says=["\"kez\"", "did you mean \"key\""])
        self.refused("add", path, caustics, *out, "--pass", "Combined", says="R,G,B")
        self.refused("add", path, path, *out, says="no light layers")
        self.refused("add", path, self.path("missing.exr"), *out, says=["missing.exr", "No such file"])
        self.refused("add", path, caustics, "-o", path, says="is the input")
        os.symlink(path, self.path("link.exr"))
        os.link(caustics, self.path("hard.exr"))
        self.refused("add", path, caustics, "-o", self.path("link.exr"), says="is the input")
        self.refused("add", path, caustics, "-o", self.path("hard.exr"), says="is the input")
        self.refused("add", path, caustics, "-o", "/dev/null", says="name a file", expect=4)
        for bad in ("key=nan", "key=inf", "key=1x", "key=", "key"):
            self.refused("add", path, caustics, *out, "--gain", bad, says="--gain", expect=2)
        self.refused("add", path, caustics, *out, "--ev", "key=5000", says="factor", expect=2)
        self.refused("add", path, caustics, *out, "--tint", "key=1,2", says="R,G,B", expect=2)
        self.refused("add", path, caustics, *out, "--offset", "1", says="X,Y", expect=2)
        self.refused("add", path, caustics, *out, "--compression", "lzw", says="zip", expect=2)
        for bad in ("0", "2.5", "x", "9999"):
            self.refused("add", path, caustics, *out, "--threads", bad, says="1 to 1024", expect=2)
        for bad in ("5", "-1G", "2Q", "G"):
            self.refused("add", path, caustics, *out, f"--memory={bad}", says="500M", expect=2)
        self.refused("add", path, caustics, *out, "--saturation", "key=-1", says="0 to 100", expect=2)
        self.refused("add", path, caustics, *out, "--gian", "key=1", says="--gain", expect=2)
        self.refused("add", path, caustics, "-o", "-", says="./-", expect=2)
        self.refused("add", path, "-", *out, says="./-", expect=2)
        self.refused("add", path, *out, says="two files", expect=2)
        self.refused("ad", path, says="did you mean add", expect=2)

    def test_incomplete(self):
        path, _ = self.beauty()
        caustics, _ = self.caustics(attrs={"caustics/complete": exrlib.integer(0)})
        self.refused("add", path, caustics, "-o", self.path("none.exr"), says="--allow-incomplete")
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--allow-incomplete")
        self.assertEqual(int_attr(self.out()[0], "caustics/complete"), 0)

    def test_ambiguous_pass(self):
        values = self.pixels()
        exrlib.write(self.path("two.exr"), [(None, {**rgb("A.Combined", values), **rgb("B.Combined", values)}, REC709)])
        caustics, _ = self.caustics()
        self.refused("add", self.path("two.exr"), caustics, "-o", self.path("none.exr"), says=["A.Combined, B.Combined", "--pass"])
        self.run_merge("add", self.path("two.exr"), caustics, "-o", self.path("out.exr"), "--pass", "B.Combined")

    def test_bad_recipes(self):
        path, _ = self.beauty()
        caustics, _ = self.caustics()
        bad = {'{"caustics_recipe": 1, "lights": {"kee": {}}}': "did you mean \"key\"",
               '{"caustics_recipe": 1, "lights": {"key": {"gian": 2}}}': "unknown key \"gian\"",
               '{"caustics_recipe": 1, "light": {}}': "unknown key \"light\"", '{"lights": {}}': "caustics_recipe",
               '{"caustics_recipe": 2}': "caustics_recipe", '{"caustics_recipe": 1, "lights": {"key": {"gain": "2"}}}': "number",
               '{"caustics_recipe": 1, "lights": {"key": {"tint": [1, 2]}}}': "three numbers", '{"caustics_recipe": 1,': "line 1",
               '{"caustics_recipe": 1, "lights": {"key": {"gain": 1e999}}}': "line 1",
               '{"caustics_recipe": 1} }': "line 1", '{"caustics_recipe": 1, "lights": {"key": {}, "key": {}}}': "duplicate"}
        for text, says in bad.items():
            write_text(self.path("r.json"), text)
            self.refused("add", path, caustics, "-o", self.path("none.exr"), "--recipe", self.path("r.json"), says=["r.json", says])

    def test_bad_layer_lists(self):
        path, _ = self.beauty()
        for text, says in {"[": "JSON", '[{"layer": "caustics_x", "light": "x", "kind": "radiance"}]': "caustics_x.R",
                           '[{"layer": "caustics_key", "light": "x", "kind": "sunshine"}]': "sunshine"}.items():
            caustics, _ = self.caustics(attrs={"caustics/layers": exrlib.string(text)})
            self.refused("add", path, caustics, "-o", self.path("none.exr"), says=["caustics.exr", says])


class Frames(Case):
    def test_frames(self):
        for n in (1, 3, 5):
            self.beauty(f"b.{n:04d}.exr")
            write_caustics(self.path(f"c.{n:04d}.exr"), {"caustics_key": self.pixels()})
        names = [self.path("b.####.exr"), self.path("c.%04d.exr"), "-o", self.path("o.##.exr")]
        self.run_merge("add", *names, "--frames", "1-5x2")
        self.assertEqual(sorted(f for f in os.listdir(self.folder) if f[0] == "o"), ["o.01.exr", "o.03.exr", "o.05.exr"])
        os.remove(self.path("c.0003.exr"))
        os.remove(self.path("o.05.exr"))
        done = subprocess.run([MERGE, "add", *names, "--frames", "1-5x2"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("frame 3", done.stderr)
        self.assertTrue(os.path.exists(self.path("o.05.exr")))
        self.refused("add", *names, "--frames", "5-1", says="range", expect=2)
        self.refused("add", self.path("b.0001.exr"), *names[1:], "--frames", "1-2", says="####", expect=2)


class Reports(Case):
    def test_help_fits_a_screen(self):
        text = self.run_merge("--help").stdout.splitlines()
        self.assertLessEqual(len(text), 40)
        self.assertTrue(text[0].startswith("caustic-merge add "))
        self.assertIn("caustic-merge ", self.run_merge("--version").stdout)

    def test_list(self):
        caustics, _ = self.caustics(attrs={"caustics/complete": exrlib.integer(1)})
        text = self.run_merge("list", caustics).stdout
        for word in ("light key: radiance, layer caustics_key", "lin_rec709_scene", "caustics/complete: 1", "30 x 20"):
            self.assertIn(word, text)

    def test_check(self):
        caustics, lights = self.caustics()
        self.run_merge("check", caustics)
        lights["caustics_key"][3, 4, 1] = np.nan
        broken, _ = self.caustics(lights)
        self.assertIn("caustics_key.G has 1 ", self.run_merge("check", broken, expect=1).stdout)
        good = {"caustics_key": self.pixels()}
        exrlib.write(self.path("sum.exr"), [("rgb", rgb("", good["caustics_key"] * np.float32(1.001)), REC709),
                                            ("caustics_key", rgb("caustics_key", good["caustics_key"]), {})])
        self.assertIn("not the sum", self.run_merge("check", self.path("sum.exr"), expect=1).stdout)
        os.truncate(caustics, os.path.getsize(caustics) * 2 // 3)
        self.run_merge("check", caustics, expect=1)


if __name__ == "__main__":
    unittest.main()
