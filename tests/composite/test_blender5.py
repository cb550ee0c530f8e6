# SPDX-License-Identifier: Apache-2.0
"""Beauties that Blender 5 wrote (tests/data/beauty/blender5.py): one part per pass, each with its own colour tag."""
import json
import os
import re
import struct
import unittest

from support import Case, DATA, np, read_bytes, read_png, rgb, write_caustics, REC709
import exrlib

LAYERS = {"caustics_Key_001": ("Key.001", "radiance"), "caustics_Key_001_ind": ("Key.001", "indirect"),
          "caustics_rim_light": ("rim light", "radiance"), "caustics_n2nd": ("2nd", "radiance")}
GROUPS = {"Key_001": ["caustics_Key_001", "caustics_Key_001_ind"], "rim light": ["caustics_rim_light"], "2nd": ["caustics_n2nd"]}


def sample(name):
    return os.path.join(DATA, f"blender5_{name}.exr")


def by_part(path):
    """{part name: part}; of a file with one part {"": part}"""
    return {p.attrs["name"][1].decode() if "name" in p.attrs else "": p for p in exrlib.read(path)}


class Blender5(Case):
    def lights(self, width, height):
        lights = {n: self.pixels(height, width) for n in LAYERS}
        lists = [{"layer": n, "light": light, "kind": kind} for n, (light, kind) in LAYERS.items()]
        write_caustics(self.path("caustics.exr"), lights, attrs={"caustics/layers": exrlib.string(json.dumps(lists))})
        return self.path("caustics.exr"), lights

    def add(self, name, size, *words, **options):
        caustics, lights = self.lights(*size)
        self.run_merge("add", sample(name), caustics, "-o", self.path("out.exr"), *words, **options)
        return lights

    def changed(self, name, expected):
        """expected: {(part, layer): what was added}; all else must be as it was, bit for bit, attributes too."""
        old, new = by_part(sample(name)), by_part(self.path("out.exr"))
        self.assertEqual(list(old), list(new))
        for part in old:
            for channel, plane in old[part].channels.items():
                layer, _, letter = channel.rpartition(".")
                added = expected.get((part, layer)) if letter in "RGB" else None
                if added is None:
                    self.assertTrue(np.array_equal(exrlib.bits(plane), exrlib.bits(new[part].channels[channel])), channel)
                else:
                    self.assert_exact(new[part].channels[channel], plane.astype("f8") + added[:, :, "RGB".index(letter)])
            for attr, value in old[part].attrs.items():
                self.assertEqual(new[part].attrs[attr], value, (part, attr))

    def test_add(self):
        lights = self.add("half", (48, 27))
        self.changed("half", {("ViewLayer.Combined", "ViewLayer.Combined"): sum(v.astype("f8") for v in lights.values())})

    def test_identity(self):
        for name, size, words in (("half", (48, 27), []), ("crop", (64, 36), ["--offset", "16,4"]),
                                  ("layers_float", (32, 18), ["--pass", "ViewLayer.Combined"]),
                                  ("stereo", (32, 18), ["--pass", "Combined.left"]),
                                  ("interleaved", (32, 18), ["--pass", "Combined.left"])):
            self.add(name, size, "--all-to", "gain=0", *words)
            self.changed(name, {})

    def test_loss_is_not_repeated(self):
        lights = self.add("dwaa", (48, 27))
        done = self.run_merge("diff", sample("dwaa"), self.path("out.exr"), expect=1)
        self.assertEqual(set(re.findall(r"channel (\S+):", done.stdout)), {f"ViewLayer.Combined.{c}" for c in "RGB"})
        done = self.run_merge("add", sample("dwaa"), self.path("caustics.exr"), "-o", self.path("o2.exr"))
        self.assertEqual(done.stderr.count("with loss"), 1, done.stderr)
        self.assertEqual(len(lights), 4)

    def test_into_groups(self):
        for name, size, view in (("half", (48, 27), ""), ("stereo", (32, 18), "left"), ("stereo", (32, 18), "right"),
                                 ("interleaved", (32, 18), "right")):
            one, end, dot = name == "interleaved", f"-{view}" if view else "", f".{view}" if view else ""
            words = ["--pass", f"Combined{dot}"] if view else []
            lights = self.add(name, size, "--into-groups", *words)
            expected = {"ViewLayer.Combined": sum(v.astype("f8") for v in lights.values())}
            for group, layers in GROUPS.items():
                expected[f"ViewLayer.Combined_{group}"] = sum(lights[n].astype("f8") for n in layers)
            self.changed(name, {("" if one else k + end, k + dot if one else k): v for k, v in expected.items()})

    def test_into_diffuse(self):
        lights = self.add("half", (48, 27), "--into-diffuse")
        old, new = by_part(sample("half")), by_part(self.path("out.exr"))
        total = sum(v.astype("f8") for v in lights.values())
        for i, c in enumerate("RGB"):
            colour = old["ViewLayer.Diffuse Color"].channels[f"ViewLayer.Diffuse Color.{c}"].astype("f8")
            before = old["ViewLayer.Diffuse Direct"].channels[f"ViewLayer.Diffuse Direct.{c}"]
            wanted = before.astype("f8") + np.divide(total[:, :, i], colour, out=np.zeros_like(colour), where=colour > 0)
            self.assert_exact(new["ViewLayer.Diffuse Direct"].channels[f"ViewLayer.Diffuse Direct.{c}"],
                              np.minimum(wanted, 65504))

    def test_holdout(self):
        lights = self.add("half", (48, 27), "--holdout-name", "glass.ball")
        old, new = by_part(sample("half")), by_part(self.path("out.exr"))
        identity = struct.unpack("<f", struct.pack("<I", 0x3240e324))[0]  # of the file's own manifest
        covered = np.zeros((27, 48))
        for rank in range(3):
            part = old[f"ViewLayer.CryptoObject{rank:02d}"].channels
            for a, b in ("rg", "ba"):
                ids, coverage = (part[f"ViewLayer.CryptoObject{rank:02d}.{c}"] for c in (a, b))
                covered += np.where(ids == np.float32(identity), coverage.astype("f8"), 0)
        self.assertGreater(np.count_nonzero(covered), 20)
        left = 1 - np.clip(covered, 0, 1)
        total = sum(v.astype("f8") for v in lights.values())
        for i, c in enumerate("RGB"):
            name = f"ViewLayer.Combined.{c}"
            self.assert_exact(new["ViewLayer.Combined"].channels[name],
                              old["ViewLayer.Combined"].channels[name].astype("f8") + total[:, :, i] * left)

    def test_list_check_preview(self):
        for name in ("half", "dwaa", "crop", "layers_float", "stereo", "interleaved"):
            self.assertIn("no fault found", self.run_merge("check", sample(name)).stdout)
            told = json.loads(self.run_merge("list", "--json", sample(name)).stdout)
            self.assertEqual(told["colour"]["space"], "lin_rec709_scene", name)
        told = json.loads(self.run_merge("list", "--json", sample("half")).stdout)
        self.assertEqual(len(told["parts"]), 11)
        self.add("half", (48, 27), "--preview", self.path("p.png"), "--contact-sheet", self.path("s.png"), "--keep-layers")
        self.assertEqual(read_png(self.path("p.png")).shape, (27, 48, 3))
        self.assertTrue(read_bytes(self.path("s.png")))
        self.assertIn("3 lights", self.run_merge("check", self.path("out.exr")).stdout)

    def test_views_are_told_apart(self):
        caustics, _ = self.lights(32, 18)
        for name in ("stereo", "interleaved"):
            self.refused("add", sample(name), caustics, "-o", self.path("out.exr"),
                         says=["ViewLayer.Combined.left, ViewLayer.Combined.right", "--pass"])
        self.refused("add", sample("layers_float"), caustics, "-o", self.path("out.exr"),
                     says="ViewLayer.Combined, Second layer.Combined")
        total = sum(v.astype("f8") for v in self.add("stereo", (32, 18), "--pass", "ViewLayer.Combined-right").values())
        self.changed("stereo", {("ViewLayer.Combined-right", "ViewLayer.Combined"): total})
        done = self.run_merge("diff", sample("stereo"), self.path("out.exr"), expect=1)
        self.assertEqual(done.stdout.count("channel "), 3, done.stdout)
        self.refused("nuke", self.path("out.exr"), says='view "right"')

    def test_several_views_in_plain_parts(self):
        both = {v: self.pixels() for v in ("left", "right")}
        exrlib.write(self.path("beauty.exr"), [(f"rgba.{v}", rgb("", p), {**REC709, "view": exrlib.string(v)}) for v, p in both.items()])
        caustics, lights = self.caustics()
        self.refused("add", self.path("beauty.exr"), caustics, "-o", self.path("out.exr"), says="rgba.left, rgba.right")
        self.run_merge("add", self.path("beauty.exr"), caustics, "-o", self.path("out.exr"), "--pass", "rgba.right")
        new = by_part(self.path("out.exr"))
        self.assertTrue(np.array_equal(new["rgba.left"].channels["R"], both["left"][:, :, 0]))
        self.assertFalse(np.array_equal(new["rgba.right"].channels["R"], both["right"][:, :, 0]))

    def test_crop(self):
        caustics, lights = self.lights(64, 36)
        self.refused("add", sample("crop"), caustics, "-o", self.path("out.exr"), says=["32 x 25", "64 x 36", "--offset"])
        self.add("crop", (64, 36), "--offset", "16,4")
        lights = {n: v for n, v in zip(LAYERS, [exrlib.read(self.path("caustics.exr"))[i + 1] for i in range(4)])}
        total = sum(np.stack([p.channels[f"{n}.{c}"] for c in "RGB"], axis=2).astype("f8") for n, p in lights.items())
        self.changed("crop", {("ViewLayer.Combined", "ViewLayer.Combined"): total[4:29, 16:48]})


if __name__ == "__main__":
    unittest.main()
