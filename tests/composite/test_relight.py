# SPDX-License-Identifier: Apache-2.0
"""Relighting beyond gain, exposure and tint: temperature, saturation, recipes, further passes, kept layers, holdouts."""
import json
import os
import unittest

from support import DATA, REC709, Case, matrix, np, read_bytes, rgb, write_text
import exrlib

CRYPTO = os.path.join(DATA, "d_off_ml_groups_crypto_half.exr")
LUMINANCE = np.array([.2126, .7152, .0722])


def planck_xy(kelvin):
    """From Planck's law and the CIE 1931 observer in the multi-lobe fit of Wyman et al. 2013."""
    nm = np.arange(360., 831.)

    def lobe(peak, mean, low, high):
        return peak * np.exp(-.5 * ((nm - mean) * np.where(nm < mean, low, high)) ** 2)
    x = lobe(.362, 442.0, .0624, .0374) + lobe(1.056, 599.8, .0264, .0323) + lobe(-.065, 501.1, .0490, .0382)
    y = lobe(.821, 568.8, .0213, .0247) + lobe(.286, 530.9, .0613, .0322)
    z = lobe(1.217, 437.0, .0845, .0278) + lobe(.681, 459.0, .0385, .0725)
    power = nm ** -5. / np.expm1(1.4388e7 / (nm * kelvin))
    xyz = np.array([(power * c).sum() for c in (x, y, z)])
    return xyz / xyz[1]


def temperature(kelvin):
    to_rgb = np.array([[3.2404542, -1.5371385, -.4985314], [-.9692660, 1.8760108, .0415560], [.0556434, -.2040259, 1.0572252]])
    f = (to_rgb @ planck_xy(kelvin)) / (to_rgb @ planck_xy(6500))
    return f / (LUMINANCE @ f)


class Relight(Case):
    def add(self, *words, lights=None, space=None):
        path, values = self.beauty(attrs=space or REC709)
        caustics, l = self.caustics(lights)
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), *words)
        return self.result(), values.astype("f8"), {k: v.astype("f8") for k, v in l.items()}

    def test_temperature(self):
        for kelvin in (2000, 2856, 4500, 9000, 20000):
            got, b, l = self.add("--mute", "rim", "--temperature", f"key={kelvin}")
            factor = ((got - b) / l["caustics_key"]).reshape(-1, 3).mean(0)
            self.assertTrue(np.all(np.abs(factor - temperature(kelvin)) < .02 * factor.max()), (kelvin, factor, temperature(kelvin)))
            self.assertAlmostEqual(float(LUMINANCE @ factor), 1, 5)
        got, b, l = self.add("--temperature", "key=6500", "--mute", "rim")
        self.assert_exact(got, b + l["caustics_key"])
        self.refused("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("none.exr"), "--temperature",
                     "key=900", says=["900", "1667", "25000"], expect=2)

    def test_saturation(self):
        for s in (0, .4, 1.5):
            got, b, l = self.add("--saturation", f"key={s}", "--gain", "key=2", "--mute", "rim")
            grey = (l["caustics_key"] @ LUMINANCE)[:, :, None]
            wanted = b + 2 * (grey + s * (l["caustics_key"] - grey))
            self.assertLess(np.abs(got - wanted).max(), 1e-5)

    def test_saturation_in_another_space(self):
        got, b, l = self.add("--saturation", "key=0", "--mute", "rim", space={"colorInteropID": exrlib.string("lin_ap1_scene")})
        added = got - b
        self.assertLess(np.abs(added - added[:, :, :1]).max(), 1e-5, "grey in the beauty's space")
        y = l["caustics_key"] @ LUMINANCE
        self.assertLess(np.abs(added[:, :, 0] - y).max(), 1e-5, "of the same luminance")
        self.assertTrue(matrix("rec709", "ap1").shape == (3, 3))

    def test_all_to(self):
        got, b, l = self.add("--all-to", "ev=-1", "--all-to", "tint=1,.5,0", "--gain", "rim=3")
        tint = np.array([1, .5, 0])
        self.assert_exact(got, b + tint * (.5 * l["caustics_key"] + 1.5 * l["caustics_rim"]))
        self.refused("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("none.exr"), "--all-to",
                     "hue=1", says="gain, ev, tint", expect=2)

    def test_written_recipe_gives_the_same_picture(self):
        lights = {n: self.pixels() for n in ("caustics_key", "caustics_key_ind", "caustics_rim")}
        words = ["--gain", "key=.3", "--temperature", "key=3000", "--saturation", "rim=.5", "--ev", "key_ind=1.5",
                 "--tint", "rim=1,.2,.7", "--tint-space", "ACEScg"]
        first, _, _ = self.add(*words, "--write-recipe", self.path("r.json"), lights=lights)
        with open(self.path("r.json")) as file:
            recipe = json.load(file)
        self.assertEqual(recipe["tint_space"], "ACEScg")
        self.assertEqual(json.loads(self.out()[0].attrs["caustics/merge"][1])["recipe"], recipe)
        self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("again.exr"), "--recipe",
                       self.path("r.json"))
        self.assertTrue(np.array_equal(first, self.result("again.exr")))
        terms = json.loads(self.out()[0].attrs["caustics/merge"][1])["terms"]
        total = sum(lights[t["layer"]].astype("f8") @ np.array(t["matrix"]).reshape(3, 3).T for t in terms)
        self.assertLess(np.abs(first - (exrlib.read(self.path("beauty.exr"))[0].channels["R"][..., None] * 0 +
                                        np.stack([exrlib.read(self.path("beauty.exr"))[0].channels[c] for c in "RGB"], 2) + total)).max(), 1e-4)

    def test_bad_recipes(self):
        path, _ = self.beauty()
        caustics, _ = self.caustics()
        for recipe, says in [({"caustics_recipe": 2}, "version"), ({"caustics_recipe": 1, "light": {}}, "unknown key"),
                             ({"caustics_recipe": 1, "lights": {"kee": {}}}, "did you mean"),
                             ({"caustics_recipe": 1, "lights": {"key": {"hue": 1}}}, "temperature, saturation"),
                             ({"caustics_recipe": 1, "lights": {"key": {"temperature": 90}}}, "1667"),
                             ({"caustics_recipe": 1, "lights": {"key": {"tint": [1, 2]}}}, "three numbers")]:
            write_text(self.path("bad.json"), json.dumps(recipe))
            self.refused("add", path, caustics, "-o", self.path("none.exr"), "--recipe", self.path("bad.json"), says=says)


class Passes(Case):
    def unchanged(self, before, after, changed):
        for a, b in zip(before, after):
            for name, plane in a.channels.items():
                if name not in changed:
                    self.assertTrue(np.array_equal(exrlib.bits(plane), exrlib.bits(b.channels[name])), name)

    def test_into_groups(self):
        before = exrlib.read(CRYPTO)
        lights = {n: self.pixels(180, 320) for n in ("caustics_key", "caustics_key_ind", "caustics_fill", "caustics_sun")}
        caustics, _ = self.caustics(lights)
        done = self.run_merge("add", CRYPTO, caustics, "-o", self.path("out.exr"), "--into-groups", "--ev", "key=1", "--mute", "fill")
        self.assertIn('"sun" has no pass Combined_sun', done.stderr)
        after = self.out()
        key = 2 * (lights["caustics_key"].astype("f8") + lights["caustics_key_ind"])
        for layer, added in [("Combined", key + lights["caustics_sun"]), ("Combined_key", key), ("Combined_fill", 0 * key)]:
            for i, c in enumerate("RGB"):
                name = f"ViewLayer.{layer}.{c}"
                self.assert_exact(after[0].channels[name], before[0].channels[name].astype("f8") + added[:, :, i])
        self.unchanged(before, after, [f"ViewLayer.{p}.{c}" for p in ("Combined", "Combined_key") for c in "RGB"])
        caustics, _ = self.caustics({"caustics_nobody": self.pixels(180, 320)})
        self.refused("add", CRYPTO, caustics, "-o", self.path("none.exr"), "--into-groups", says="--into-groups")

    def test_into_diffuse(self):
        colour = self.pixels()
        colour[3:6] = 0
        for names, multi in [(("DiffDir", "DiffCol"), False), (("Diffuse Direct", "Diffuse Color"), True)]:
            layers = {"VL.Combined": self.pixels(), f"VL.{names[0]}": self.pixels(), f"VL.{names[1]}": colour}
            parts = [(n, rgb(n, v), REC709 if i == 0 else {}) for i, (n, v) in enumerate(layers.items())]
            if not multi:
                parts = [(None, {k: v for _, c, _ in parts for k, v in c.items()}, REC709)]
            exrlib.write(self.path("beauty.exr"), parts)
            caustics, l = self.caustics()
            self.run_merge("add", self.path("beauty.exr"), caustics, "-o", self.path("out.exr"), "--into-diffuse")
            channels = {k: v for p in self.out() for k, v in p.channels.items()}
            added = l["caustics_key"].astype("f8") + l["caustics_rim"]
            got = np.stack([channels[f"VL.{names[0]}.{c}"] for c in "RGB"], 2).astype("f8")
            wanted = layers[f"VL.{names[0]}"] + np.where(colour > 0, added / np.where(colour > 0, colour.astype("f8"), 1), 0)
            self.assertLess((np.abs(got - wanted) / np.maximum(1, np.abs(wanted))).max(), 1e-6)
        self.refused("add", CRYPTO, caustics, "-o", self.path("none.exr"), "--into-diffuse", "--offset", "0,0", says="DiffCol")


class Kept(Case):
    def test_layers_travel(self):
        lights = {n: self.pixels() for n in ("caustics_key", "caustics_key_ind", "caustics_key_err", "caustics_rim")}
        entries = [{"layer": k, "light": k[9:12], "kind": {"d": "indirect", "r": "error"}.get(k[-1] if k.count("_") > 1 else "", "radiance")}
                   for k in lights]
        attrs = {"caustics/layers": exrlib.string(json.dumps(entries)), "caustics/seed": exrlib.string("7")}
        for interleave in (False, True):
            path, values = self.beauty(dtype="<f2")
            caustics, _ = self.caustics(lights, attrs=attrs, interleave=interleave)
            self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--keep-layers", "--gain", "key=3")
            parts = self.out()
            self.assertEqual(len(parts), 5)
            for name, plane in lights.items():
                part = next(p for p in parts if f"{name}.R" in p.channels)
                for i, c in enumerate("RGB"):
                    self.assertTrue(np.array_equal(part.channels[f"{name}.{c}"], plane[:, :, i]), name)
            self.assertEqual(json.loads(parts[0].attrs["caustics/layers"][1]), entries)
            self.assertEqual(parts[0].attrs["caustics/seed"][1], b"7")
            self.run_merge("check", self.path("out.exr"))
            other, v = self.beauty("other.exr")
            self.run_merge("add", other, self.path("out.exr"), "-o", self.path("again.exr"))
            self.assert_exact(self.result("again.exr"),
                              v.astype("f8") + sum(lights[n].astype("f8") for n in lights if not n.endswith("err")))

    def test_converted_and_moved(self):
        light = self.pixels(20, 30)
        path, _ = self.beauty(height=8, width=9, attrs={"colorInteropID": exrlib.string("lin_ap1_scene")})
        caustics, _ = self.caustics({"caustics_key": light, "caustics_key_err": light})
        done = self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--keep-layers", "--offset", "4,6")
        self.assertIn("caustics_key_err is not kept", done.stderr)
        parts = self.out()
        self.assertEqual(parts[1].window, (-4, -6, 25, 13))
        got = np.stack([parts[1].channels[f"caustics_key.{c}"] for c in "RGB"], 2)
        self.assertLess(np.abs(got - light.astype("f8") @ matrix("rec709", "ap1").T).max(), 1e-6)

    def test_not_twice(self):
        path, _ = self.beauty()
        caustics, _ = self.caustics()
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--keep-layers")
        self.refused("add", self.path("out.exr"), caustics, "-o", self.path("none.exr"), "--keep-layers", says="already")

    def test_decreasing_order(self):
        path, _ = self.beauty(decreasing=True)
        caustics, l = self.caustics()
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--keep-layers")
        self.assertTrue(np.array_equal(self.out()[1].channels["caustics_key.R"], l["caustics_key"][:, :, 0]))


class Holdout(Case):
    def test_mask(self):
        path, b = self.beauty()
        caustics, l = self.caustics({"caustics_key": self.pixels()})
        mask = self.pixels()[:, :, 0]
        mask[0, 0], mask[0, 1], mask[0, 2] = np.nan, 7, -1
        exrlib.write(self.path("mask.exr"), [(None, {"A": mask, "other": 1 - mask}, {})])
        clean = np.clip(np.nan_to_num(mask.astype("f8")), 0, 1)[:, :, None]
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--holdout", self.path("mask.exr"))
        self.assert_exact(self.result(), b.astype("f8") + l["caustics_key"] * (1 - clean))
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"), "--holdout", self.path("mask.exr") + ":other")
        self.refused("add", path, caustics, "-o", self.path("none.exr"), "--holdout", self.path("mask.exr") + ":no", says="no channel no")
        small, _ = self.beauty("small.exr", height=3, width=3)
        self.refused("add", path, caustics, "-o", self.path("none.exr"), "--holdout", small, says=["3 x 3", "30 x 20"])
        self.refused("add", path, caustics, "-o", self.path("mask.exr"), "--holdout", self.path("mask.exr"), says="is the input")

    def test_alpha(self):
        values, alpha = self.pixels(), self.pixels()[:, :, 0]
        exrlib.write(self.path("beauty.exr"), [(None, {**rgb("VL.Combined", values), "VL.Combined.A": alpha}, REC709)])
        caustics, l = self.caustics({"caustics_key": self.pixels()})
        self.run_merge("add", self.path("beauty.exr"), caustics, "-o", self.path("out.exr"), "--holdout-alpha")
        self.assert_exact(self.result(prefix="VL.Combined"), values.astype("f8") + l["caustics_key"] * alpha[:, :, None].astype("f8"))
        path, _ = self.beauty("rgb.exr")
        self.refused("add", path, caustics, "-o", self.path("none.exr"), "--holdout-alpha", says="no channel A")

    def test_cryptomatte(self):
        before = exrlib.read(CRYPTO)[0].channels
        light = np.ones((180, 320, 3), "<f4")
        caustics, _ = self.caustics({"caustics_key": light})
        self.run_merge("add", CRYPTO, caustics, "-o", self.path("out.exr"), "--holdout-name", "WineGlass")
        wanted = np.array([0x820ff476], "u4").view("f4")[0]
        coverage = np.zeros((180, 320))
        for name in (n for n in before if n.startswith("ViewLayer.CryptoObject") and n[-1] in "rb"):
            other = name[:-1] + {"r": "g", "b": "a"}[name[-1]]
            coverage += np.where(before[name] == wanted, before[other], 0)
        self.assertGreater(coverage.max(), .99)
        after = self.out()[0].channels["ViewLayer.Combined.R"]
        exact = before["ViewLayer.Combined.R"].astype("f8") + 1 - np.clip(coverage, 0, 1)
        self.assertTrue(np.all(np.abs(after.astype("f8") - exact) <= np.spacing(exact.astype("f2")).astype("f8")))
        self.refused("add", CRYPTO, caustics, "-o", self.path("none.exr"), "--holdout-name", "WineGlas", says='did you mean "WineGlass"')
        path, _ = self.beauty(height=180, width=320)
        self.refused("add", path, caustics, "-o", self.path("none.exr"), "--holdout-name", "WineGlass", says="Cryptomatte")

    def test_name_without_manifest(self):
        """MurmurHash3 of the name: 6a2fb16e is what Blender's manifest says of "Floor"."""
        text = read_bytes(CRYPTO).replace(b"/manifest\0", b"/manifes_\0")
        with open(self.path("bare.exr"), "wb") as file:
            file.write(text)
        caustics, _ = self.caustics({"caustics_key": np.ones((180, 320, 3), "<f4")})
        for name, source in (("a.exr", CRYPTO), ("b.exr", self.path("bare.exr"))):
            self.run_merge("add", source, caustics, "-o", self.path(name), "--holdout-name", "Floor")
        a, b = (exrlib.read(self.path(n))[0].channels["ViewLayer.Combined.R"] for n in ("a.exr", "b.exr"))
        self.assertTrue(np.array_equal(a, b))


if __name__ == "__main__":
    unittest.main()
