# SPDX-License-Identifier: Apache-2.0
"""Colour spaces: conversion against matrices from the primaries, tags, refusals, previews."""
import os
import struct
import unittest

from support import Case, matrix, np, read_png, rgb, write_text
import exrlib

IDS = {"lin_rec709_scene": "rec709", "lin_ap1_scene": "ap1", "lin_ap0_scene": "ap0", "lin_p3d65_scene": "p3",
       "lin_rec2020_scene": "rec2020"}
XY = {"ap1": (.713, .293, .165, .83, .128, .044, .32168, .33767), "rec709": (.64, .33, .3, .6, .15, .06, .3127, .329)}


def tag(text, name="colorInteropID"):
    return {name: exrlib.string(text)}


def chromaticities(values):
    return {"chromaticities": ("chromaticities", struct.pack("<8f", *values))}


class Conversion(Case):
    def assert_converted(self, got, wanted):
        """5e-6 relative, and the rounding of the stored type."""
        error = np.abs(got.astype("f8") - wanted)
        limit = 5e-6 * np.abs(wanted) + np.spacing(np.abs(wanted).astype(got.dtype)).astype("f8")
        self.assertTrue(np.all(error <= limit), float(np.max(error / limit)))

    def test_every_pair_of_spaces(self):
        for beauty_id, b in IDS.items():
            for caustics_id, c in IDS.items():
                path, values = self.beauty(attrs=tag(beauty_id))
                caustics, l = self.caustics({"caustics_key": self.pixels()}, attrs=tag(caustics_id))
                self.run_merge("add", path, caustics, "-o", self.path("out.exr"))
                self.assert_converted(self.result(), values.astype("f8") + l["caustics_key"].astype("f8") @ matrix(c, b).T)

    def test_half_beauty_in_acescg(self):
        path, values = self.beauty(attrs=tag("LIN_AP1_scene", "ColorInteropId"), dtype="<f2")
        caustics, l = self.caustics({"caustics_key": self.pixels()})
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"))
        self.assert_converted(self.result(), values.astype("f8") + l["caustics_key"].astype("f8") @ matrix("rec709", "ap1").T)

    def test_tint_space(self):
        tint = np.array([2, .5, .25])
        path, values = self.beauty(attrs=tag("lin_ap1_scene"))
        caustics, l = self.caustics({"caustics_key": self.pixels()})
        words = ["add", path, caustics, "-o", self.path("out.exr"), "--tint", "key=2,.5,.25"]
        light = l["caustics_key"].astype("f8")
        self.run_merge(*words)
        self.assert_converted(self.result(), values.astype("f8") + tint * (light @ matrix("rec709", "ap1").T))
        self.run_merge(*words, "--tint-space", "Linear Rec.709")
        self.assert_converted(self.result(), values.astype("f8") + (tint * light) @ matrix("rec709", "ap1").T)

    def test_order_of_belief(self):
        light = {"caustics_key": self.pixels()}
        caustics, _ = self.caustics(light)
        flag = {"acesImageContainerFlag": exrlib.integer(1)}
        cases = [({**flag, **tag("lin_ap1_scene")}, [], "ap0"), ({**tag("lin_ap1_scene"), **chromaticities(XY["rec709"])}, [], "ap1"),
                 (chromaticities([v + .0009 for v in XY["ap1"]]), [], "ap1"), ({**tag("unknown"), **chromaticities(XY["ap1"])}, [], "ap1"),
                 ({"cycles.ViewLayer.samples": exrlib.string("8")}, [], "rec709"), (tag("lin_rec709_scene"), ["--beauty-space", "acescg"], "ap1"),
                 ({"BlenderMultiChannel": exrlib.string("Blender")}, ["--beauty-space", "ACES2065-1"], "ap0")]
        for attrs, words, space in cases:
            path, values = self.beauty(attrs=attrs)
            done = self.run_merge("add", path, caustics, "-o", self.path("out.exr"), *words)
            self.assert_converted(self.result(), values.astype("f8") + light["caustics_key"].astype("f8") @ matrix("rec709", space).T)
            self.assertEqual("written by Blender" in done.stderr, attrs.keys() == {"cycles.ViewLayer.samples"})

    def out_tag(self):
        return self.out()[0].attrs.get("colorInteropID", (None, b""))[1].decode()

    def test_output_tag_is_never_stale(self):
        caustics, _ = self.caustics()
        cases = [({"cycles.x": exrlib.string("")}, [], "lin_rec709_scene", False), (chromaticities(XY["ap1"]), [], "lin_ap1_scene", True),
                 ({**tag("lin_rec709_scene"), **chromaticities(XY["rec709"])}, ["--beauty-space", "ACEScg"], "lin_ap1_scene", False),
                 ({**tag("unknown"), **chromaticities(XY["rec709"])}, [], "lin_rec709_scene", True)]
        for attrs, words, wanted, keeps in cases:
            path, _ = self.beauty(attrs=attrs)
            self.run_merge("add", path, caustics, "-o", self.path("out.exr"), *words)
            self.assertEqual(self.out_tag(), wanted)
            self.assertEqual("chromaticities" in self.out()[0].attrs, keeps)

    def test_refusals(self):
        caustics, _ = self.caustics()
        cases = [({}, [], "--beauty-space"), (tag("srgb_rec709_display"), [], ["display-referred", "before the view"]),
                 (tag("srgb_rec709_scene"), [], "not scene-linear"), (tag("srgb_p3d65_display"), [], "display-referred"),
                 (tag("data"), [], "data"), (chromaticities([.1] * 8), [], "chromaticities"),
                 ({}, ["--beauty-space", "Rec.1886"], "display-referred"), ({}, ["--beauty-space", "ACEScct"], "not scene-linear"),
                 ({}, ["--beauty-space", "ACEScgg"], "did you mean \"ACEScg\""), (tag("lin_ap1_scenes"), [], "no colour space"),
                 (tag("lin_ap1_scene"), ["--caustics-space", "nowhere"], "no colour space"),
                 (tag("lin_ap1_scene"), ["--ocio", "/nowhere.ocio"], "--ocio builtin")]
        for attrs, words, says in cases:
            path, _ = self.beauty(attrs=attrs)
            self.refused("add", path, caustics, "-o", self.path("none.exr"), *words, says=says)
        untagged, _ = self.caustics(attrs={"colorInteropID": exrlib.string("unknown")}, name="untagged.exr")
        path, _ = self.beauty()
        self.refused("add", path, untagged, "-o", self.path("none.exr"), says=["untagged.exr", "--caustics-space"])

    def test_config_from_the_environment(self):
        path, values = self.beauty()
        caustics, l = self.caustics({"caustics_key": self.pixels()})
        words = ["add", path, caustics, "-o", self.path("out.exr")]
        done = self.run_merge(*words, env={"OCIO": "/nowhere.ocio"}, expect=1)
        self.assertIn("$OCIO", done.stderr)
        self.run_merge(*words, "--ocio", "builtin", env={"OCIO": "/nowhere.ocio"})
        write_text(self.path("my.ocio"), """ocio_profile_version: 1
strictparsing: true
roles: {default: Linear Rec.709, scene_linear: Linear Rec.709}
displays:
  mine:
    - !<View> {name: Plain, colorspace: Linear Rec.709}
colorspaces:
  - !<ColorSpace> {name: Linear Rec.709, isdata: false}
  - !<ColorSpace>
    name: Doubled
    isdata: false
    to_reference: !<MatrixTransform> {matrix: [.5, 0, 0, 0, 0, .5, 0, 0, 0, 0, .5, 0, 0, 0, 0, 1]}
""")
        self.run_merge(*words, "--beauty-space", "Doubled", env={"OCIO": self.path("my.ocio")})
        self.assert_exact(self.result(), values.astype("f8") + 2 * l["caustics_key"].astype("f8"))
        self.assertNotIn("colorInteropID", self.out()[0].attrs)


class Previews(Case):
    def grey(self, value, attrs=None):
        exrlib.write(self.path("grey.exr"), [(None, rgb("", np.full((4, 6, 3), value, "<f4")), attrs or tag("lin_rec709_scene"))])
        return self.path("grey.exr")

    def test_known_values(self):
        # 0.18 is 0.4614 in sRGB; 0.3560 by the ACES SDR view; 0.18^(1/2.4) by Rec.1886
        for view, display, wanted in [("Standard", "sRGB", .461356), ("ACES SDR", "sRGB", .355954), ("Raw", "sRGB", .18),
                                      ("Standard", "Rec.1886", .18 ** (1 / 2.4))]:
            self.run_merge("preview", self.grey(.18), "-o", self.path("p.png"), "--display", display, "--view", view)
            png = read_png(self.path("p.png"))
            self.assertEqual(png.shape, (4, 6, 3))
            self.assertTrue(np.all(np.abs(png - 255 * wanted) <= .51), (view, display, png[0, 0]))
        for value, wanted in [(-1, 0), (np.nan, 0), (np.inf, 255), (100, 255)]:
            self.run_merge("preview", self.grey(value), "-o", self.path("p.png"))
            self.assertTrue(np.all(read_png(self.path("p.png")) == wanted), value)

    def test_the_space_counts(self):
        red = np.zeros((4, 6, 3), "<f4")
        red[..., 0] = .5
        exrlib.write(self.path("red.exr"), [(None, rgb("", red), tag("lin_ap1_scene"))])
        self.run_merge("preview", self.path("red.exr"), "-o", self.path("p.png"))
        linear = np.clip(matrix("ap1", "rec709") @ [.5, 0, 0], 0, 1)
        srgb = np.where(linear < .0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - .055)
        self.assertTrue(np.all(np.abs(read_png(self.path("p.png"))[0, 0] - 255 * srgb) <= .6))

    def test_layers_and_add(self):
        beauty, light = np.full((20, 30, 3), .03, "<f4"), np.full((20, 30, 3), .15, "<f4")
        exrlib.write(self.path("beauty.exr"), [(None, rgb("", beauty), tag("lin_rec709_scene"))])
        caustics, _ = self.caustics({"caustics_key": light})
        self.run_merge("add", self.path("beauty.exr"), caustics, "-o", self.path("out.exr"), "--preview", self.path("p.png"))
        self.assertTrue(np.all(read_png(self.path("p.png")) == round(255 * .461356)))
        for words in ([], ["--layer", "caustics_key"]):
            self.run_merge("preview", caustics, "-o", self.path("c.png"), *words)
            self.assertTrue(np.all(read_png(self.path("c.png")) == round(255 * (1.055 * .15 ** (1 / 2.4) - .055))))

    def test_refusals(self):
        grey = self.grey(.18)
        self.refused("preview", grey, "-o", self.path("p.png"), "--view", "Filmic", says="Standard, ACES SDR, Raw")
        self.refused("preview", grey, "-o", self.path("p.png"), "--display", "P3", says="sRGB, Rec.1886")
        caustics, _ = self.caustics()
        path, _ = self.beauty()
        self.refused("add", path, caustics, "-o", self.path("none.exr"), "--preview", self.path("p.png"), "--view", "Filmic",
                     says="Filmic")
        self.refused("add", path, caustics, "-o", self.path("none.exr"), "--preview", path, says="is the input")


if __name__ == "__main__":
    unittest.main()
