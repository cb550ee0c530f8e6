# SPDX-License-Identifier: Apache-2.0
"""list, check, diff, shards, previews and contact sheets."""
import json
import os
import shutil
import struct
import subprocess
import unittest

from support import DATA, MERGE, REC709, Case, int_attr, np, read_bytes, read_png, rgb, write_caustics, write_text
import exrlib

RENDERED = {"caustics/scene_hash": exrlib.string("00ff"), "caustics/version": exrlib.string("0.1.0"),
            "caustics/plan": exrlib.string('{"pairs": []}')}


class List(Case):
    def test_json(self):
        lights = {n: self.pixels() for n in ("caustics_key", "caustics_key_ind", "caustics_key_err")}
        caustics, _ = self.caustics(lights, attrs={**RENDERED, "caustics/complete": exrlib.integer(1),
                                                   "caustics/error": exrlib.string('{"key": {"direct": 0.01}}')})
        found = json.loads(self.run_merge("list", "--json", caustics).stdout)
        self.assertEqual([p["name"] for p in found["parts"]], ["rgb", *lights])
        self.assertEqual(found["parts"][1]["channels"][0], {"name": "caustics_key.B", "type": "float"})
        self.assertEqual(found["parts"][0]["data_window"], [0, 0, 29, 19])
        self.assertEqual(found["lights"], [{"name": "key", "layers": {"radiance": "caustics_key", "indirect": "caustics_key_ind"},
                                            "error": {"direct": .01}}])
        self.assertEqual(found["colour"], {"space": "lin_rec709_scene", "source": "colorInteropID"})
        self.assertEqual((found["plan"], found["complete"], found["scene_hash"]), ({"pairs": []}, 1, "00ff"))
        text = self.run_merge("list", caustics).stdout
        for word in ("caustics/plan", "caustics/error", "light key: indirect"):
            self.assertIn(word, text)
        self.assertTrue(json.loads(self.run_merge("list", "--json", os.path.join(DATA, "d_off_ml_groups_crypto_half.exr")).stdout))


class Check(Case):
    def faults(self, says, **options):
        caustics, _ = self.caustics(**options)
        done = self.run_merge("check", caustics, expect=1)
        self.assertIn(says, done.stdout)

    def test_what_is_wrong(self):
        self.caustics()
        self.run_merge("check", self.path("caustics.exr"))
        self.faults("said twice", attrs={"chromaticities": ("chromaticities", struct.pack("<8f", .713, .293, .165, .83, .128, .044, .32168, .33767))})
        self.faults("stopped", attrs={"caustics/complete": exrlib.integer(0)})
        bad = self.pixels()
        bad[3, 4, 1] = np.nan
        self.faults("caustics_key.G has 1 value", lights={"caustics_key": bad})

    def test_every_part_is_read(self):
        """A file cut off anywhere, or with one byte of a chunk gone, is found."""
        self.caustics()
        data = read_bytes(self.path("caustics.exr"))
        for share in (.3, .6, .9, .999):
            with open(self.path("cut.exr"), "wb") as file:
                file.write(data[:int(len(data) * share)])
            self.run_merge("check", self.path("cut.exr"), expect=1)

    def test_wrong_sum_in_one_pixel(self):
        for interleave in (False, True):
            lights = {"caustics_a": self.pixels(), "caustics_b": self.pixels()}
            write_caustics(self.path("c.exr"), lights, interleave=interleave)
            parts = exrlib.read(self.path("c.exr"))
            parts[0].channels["G"][17, 5] *= 1.001
            exrlib.write(self.path("c.exr"), [(p.attrs.get("name", (0, b"x"))[1].decode() if len(parts) > 1 else None, p.channels, p.extra) for p in parts])
            done = self.run_merge("check", self.path("c.exr"), expect=1)
            self.assertIn("in 1 of 1800 values", done.stdout)

    def test_other_windows(self):
        parts = [("rgb", rgb("", self.pixels()), REC709), ("caustics_a", rgb("caustics_a", self.pixels()), {})]
        exrlib.write(self.path("c.exr"), parts)
        data = read_bytes(self.path("c.exr"))
        at = data.rindex(b"dataWindow\0box2i\0") + len(b"dataWindow\0box2i\0") + 4
        with open(self.path("c.exr"), "wb") as file:
            file.write(data[:at] + struct.pack("<4i", 0, 0, 29, 18) + data[at + 16:])
        self.assertIn("another data window", self.run_merge("check", self.path("c.exr"), expect=1).stdout)


class Diff(Case):
    def test_same_and_not(self):
        path, values = self.beauty()
        shutil.copy(path, self.path("b.exr"))
        self.assertIn("no difference", self.run_merge("diff", path, self.path("b.exr")).stdout)
        values[4, 7, 2] += .5
        exrlib.write(self.path("b.exr"), [(None, {**rgb("", values), "A": values[:, :, 0]}, {**REC709, "more": exrlib.integer(1)})])
        said = self.run_merge("diff", path, self.path("b.exr"), expect=1).stdout
        for word in ("channel B: 1 of 600 samples differ, by at most 0.5", "at (7,4)", "channel A is in", "attribute more is in"):
            self.assertIn(word, said)
        self.assertNotIn("channel R", said)

    def test_one_part_or_many(self):
        planes = {**rgb("VL.Combined", self.pixels()), **rgb("VL.Diff", self.pixels())}
        exrlib.write(self.path("a.exr"), [(None, planes, REC709)])
        exrlib.write(self.path("b.exr"), [("x", {k: v for k, v in planes.items() if "Combined" in k}, REC709),
                                          ("y", {k: v for k, v in planes.items() if "Diff" in k}, {})])
        said = self.run_merge("diff", self.path("a.exr"), self.path("b.exr"), expect=1).stdout
        self.assertIn("1 parts against 2", said)
        self.assertNotIn("channel", said)
        self.refused("diff", self.path("a.exr"), says="two files", expect=2)


class Shards(Case):
    def shard(self, name, seed, photons, lights, attrs=None, **options):
        more = {"caustics/seed": exrlib.string(str(seed)), "caustics/photons": exrlib.string(str(photons)),
                "caustics/complete": exrlib.integer(1), "caustics/error": exrlib.string('{"key": {"direct": 0.1}}')}
        write_caustics(self.path(name), lights, attrs={**RENDERED, **more, **(attrs or {})}, **options)
        return self.path(name)

    def make(self, **options):
        self.light = [{n: self.pixels() for n in ("caustics_key", "caustics_key_ind", "caustics_key_err")} for _ in range(3)]
        return [self.shard(f"s{i}.exr", i + 1, p, self.light[i], **options) for i, p in enumerate((1000, 3000, 4000))]

    def test_weighted_by_photons(self):
        weights = np.array([1, 3, 4]) / 8
        for interleave in (False, True):
            files = self.make(interleave=interleave)
            for threads in (1, 3):
                self.run_merge("shards", *files, "-o", self.path("out.exr"), "--threads", threads)
                parts = self.out()
                channels = {k: v for p in parts for k, v in p.channels.items()}
                for name in self.light[0]:
                    stack = np.array([w * l[name].astype("f8") for w, l in zip(weights, self.light)])
                    wanted = np.sqrt((stack ** 2).sum(0)) if name.endswith("err") else stack.sum(0)
                    self.assert_exact(np.stack([channels[f"{name}.{c}"] for c in "RGB"], 2), wanted)
                attrs = {k: v[1] for k, v in parts[0].attrs.items()}
                self.assertEqual((attrs["caustics/photons"], attrs["caustics/seed"]), (b"8000", b"1,2,3"))
                error = json.loads(attrs["caustics/error"])["key"]["direct"]
                self.assertAlmostEqual(error, .1 * float(np.sqrt((weights ** 2).sum())), 12)
                self.run_merge("check", self.path("out.exr"))

    def test_refusals(self):
        a, b, _ = self.make()
        out = ["-o", self.path("none.exr")]
        same = self.shard("same.exr", 1, 500, self.light[0])
        self.refused("shards", a, b, same, *out, says=["same photons", "seed 1", "s0.exr", "same.exr"])
        for attrs, says in [({"caustics/scene_hash": exrlib.string("0bad")}, ["caustics/scene_hash", "00ff", "0bad"]),
                            ({"caustics/plan": exrlib.string("{}")}, "caustics/plan differs"),
                            ({"caustics/version": exrlib.string("9")}, "caustics/version"),
                            ({"colorInteropID": exrlib.string("lin_ap1_scene")}, "colorInteropID"),
                            ({"caustics/photons": exrlib.string("many")}, "photons"),
                            ({"caustics/complete": exrlib.integer(0)}, "--allow-incomplete")]:
            other = self.shard("other.exr", 9, 500, self.light[1], attrs=attrs)
            self.refused("shards", a, other, *out, says=says)
        self.run_merge("shards", a, other, "-o", self.path("out.exr"), "--allow-incomplete")
        self.assertEqual(int_attr(self.out()[0], "caustics/complete"), 0)
        small = self.shard("small.exr", 9, 500, {n: self.pixels(5, 6) for n in self.light[0]})
        self.refused("shards", a, small, *out, says="resolution")
        fewer = self.shard("fewer.exr", 9, 500, {"caustics_key": self.pixels()})
        self.refused("shards", a, fewer, *out, says="layers")
        self.refused("shards", a, *out, says="two files", expect=2)
        self.refused("shards", a, b, "-o", b, says="is the input")
        first, second = (self.shard(f"n{i}.exr", 1, 500, self.light[i], attrs={"caustics/shard": exrlib.string(f"{i + 1}/2")}) for i in (0, 1))
        self.run_merge("shards", first, second, "-o", self.path("out.exr"))


class Previews(Case):
    def test_exposure_and_jpeg(self):
        flat = np.full((20, 30, 3), .18, "<f4")
        exrlib.write(self.path("flat.exr"), [(None, rgb("", flat), REC709)])
        for stops in (0, 1, -2):
            self.run_merge("preview", self.path("flat.exr"), "-o", self.path("p.png"), "--exposure", stops)
            v = .18 * 2. ** stops
            wanted = round(255 * (1.055 * v ** (1 / 2.4) - .055))
            self.assertTrue(np.all(np.abs(read_png(self.path("p.png")) - wanted) <= 1))
        self.run_merge("preview", self.path("flat.exr"), "-o", self.path("p.jpg"))
        data = read_bytes(self.path("p.jpg"))
        self.assertEqual((data[:3], data[-2:]), (b"\xff\xd8\xff", b"\xff\xd9"))
        self.refused("preview", self.path("flat.exr"), "-o", self.path("none.tif"), says=[".png", ".jpg"], expect=2)
        self.refused("preview", self.path("flat.exr"), "-o", self.path("none.png"), "--look", "Punchy", says="no look")

    def test_look(self):
        write_text(self.path("c.ocio"), """ocio_profile_version: 2
roles: {scene_linear: lin, default: lin}
displays:
  sRGB: [!<View> {name: Raw, colorspace: lin}]
colorspaces:
  - !<ColorSpace> {name: lin, aliases: [lin_rec709_scene], isdata: false}
looks:
  - !<Look> {name: Half, process_space: lin, transform: !<MatrixTransform> {matrix: [.5, 0, 0, 0, 0, .5, 0, 0, 0, 0, .5, 0, 0, 0, 0, 1]}}
""")
        flat = np.full((4, 4, 3), .8, "<f4")
        exrlib.write(self.path("flat.exr"), [(None, rgb("", flat), REC709)])
        for words, wanted in (([], 204), (["--look", "Half"], 102)):
            self.run_merge("preview", self.path("flat.exr"), "-o", self.path("p.png"), "--ocio", self.path("c.ocio"), "--beauty-space", "lin", *words)
            self.assertTrue(np.all(np.abs(read_png(self.path("p.png")) - wanted) <= 1), read_png(self.path("p.png"))[0, 0])

    def test_contact_sheet(self):
        path, _ = self.beauty(height=90, width=120)
        levels = {"caustics_key": .1, "caustics_rim": .3}
        caustics, _ = self.caustics({n: np.full((90, 120, 3), v, "<f4") for n, v in levels.items()})
        exrlib.write(path, [(None, rgb("", np.full((90, 120, 3), .2, "<f4")), REC709)])
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--contact-sheet", self.path("sheet.png"),
                       "--preview", self.path("p.jpg"), "--view", "Raw", "--gain", "rim=.5")
        sheet = read_png(self.path("sheet.png"))
        bar, border = 22, 4
        self.assertEqual(sheet.shape, (2 * (90 + bar + border) + border, 3 * (120 + border) + border, 3))
        for cell, value in enumerate((.2, .1, .15, .25, .45)):  # before, key, rim, sum, after
            x, y = border + cell % 3 * (120 + border), border + cell // 3 * (90 + bar + border)
            picture, label = sheet[y:y + 90, x:x + 120], sheet[y + 90:y + 90 + bar, x:x + 120]
            self.assertTrue(np.all(np.abs(picture - 255 * value) <= 1), (cell, picture[0, 0]))
            self.assertGreater((label > 200).sum(), 100, "its name")
        self.refused("add", path, caustics, "-o", self.path("none.exr"), "--contact-sheet", self.path("none.gif"), says=".png", expect=2)

    def test_large_picture_in_a_small_cell(self):
        path, values = self.beauty(height=700, width=1000)
        caustics, _ = self.caustics({"caustics_key": np.zeros((700, 1000, 3), "<f4")})
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--contact-sheet", self.path("sheet.png"), "--view", "Raw")
        first = read_png(self.path("sheet.png"))[4:237, 4:337]
        wanted = values[:699, :999].reshape(233, 3, 333, 3, 3).mean((1, 3)) * 255
        self.assertLess(np.abs(first - wanted).max(), 1.01)

    @unittest.skipUnless(shutil.which("blender"), "no Blender here")
    def test_blenders_configuration(self):
        path, _ = self.beauty()
        done = subprocess.run([MERGE, "preview", path, "-o", self.path("p.png"), "--ocio", "blender", "--beauty-space", "Linear",
                               "--view", "Filmic", "--look", "High Contrast"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()
