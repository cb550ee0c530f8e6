# SPDX-License-Identifier: Apache-2.0
"""Shots that the tests of both hosts share: files, the words of `add`, and the picture that `add` makes."""
import json
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "composite"))
import exrlib  # noqa: E402
import support  # noqa: E402
from support import np, rgb  # noqa: E402

LAYERS = ("caustics_key", "caustics_key_ind", "caustics_rim", "caustics_rim_ind")
ACES = {"colorInteropID": exrlib.string("lin_ap1_scene")}
# name: (what the beauty is, words of add)
SHOTS = {
    "plain": ("plain", ["--ev", "key=1.25", "--gain", "rim=0.7", "--tint", "key=1,0.8,0.25"]),
    "multilayer": ("multilayer", ["--ev", "rim=-2", "--tint", "rim=0.2,0.4,3"]),
    "mute": ("plain", ["--mute", "key", "--gain", "rim=2"]),
    "solo": ("plain", ["--solo", "rim", "--ev", "key=1"]),
    "indirect": ("plain", ["--ev", "key=1", "--gain", "key_ind=0.25", "--tint", "key_ind=1,0.5,0.5", "--mute", "rim_ind"]),
    "indirect_solo": ("plain", ["--solo", "key_ind", "--ev", "key=-1"]),
    "negative": ("plain", ["--gain", "key=-0.5", "--tint", "rim=0,2,0"]),
    "negative_tint": ("plain", ["--tint", "rim=-1,2,0"]),
    "aces": ("aces", ["--ev", "key=0.5", "--tint", "rim=1,0.5,0.2"]),
    "tint_space": ("aces", ["--tint", "key=1,0.3,0.2", "--tint-space", "Linear Rec.709"]),
    "temperature": ("plain", ["--temperature", "key=3200", "--ev", "key=1", "--temperature", "rim_ind=9000"]),
    "saturation": ("plain", ["--saturation", "key=0.25", "--tint", "key=1,0.5,2", "--saturation", "key_ind=3"]),
    "saturation_aces": ("aces", ["--saturation", "rim=1.5", "--temperature", "rim=4000", "--tint-space", "ACEScg"]),
    "saturation_space": ("aces", ["--saturation", "rim=0.5", "--tint", "key=1,0.5,2", "--tint-space", "Linear Rec.709"]),
    "albedo": ("albedo", ["--albedo", "DiffCol", "--ev", "key=1", "--tint", "rim=1,2,3"]),
}


class Shot(support.Case):
    """Makes the files of a shot in self.folder."""

    def make_beauty(self, kind, name="beauty.exr"):
        values = self.pixels()
        if kind in ("plain", "aces"):
            exrlib.write(self.path(name), [(None, rgb("", values), dict(ACES if kind == "aces" else support.REC709))])
            return ""
        alpha = {"ViewLayer.Combined.A": self.random.random(values.shape[:2]).astype("<f4")}
        channels = {**rgb("ViewLayer.Combined", values), **alpha, **rgb("ViewLayer.DiffCol", self.pixels())}
        exrlib.write(self.path(name), [(None, channels, dict(support.REC709))])
        return "ViewLayer.Combined"

    def make_caustics(self, kind, name="caustics.exr"):
        extra = [b + s for b in ("caustics_key", "caustics_rim") for s in ("_E", "_S")] if kind == "albedo" else []
        entries = [{"layer": n, "light": n.split("_")[1], "kind": self.kind(n)} for n in [*LAYERS, *extra]]
        attrs = {"caustics/layers": exrlib.string(json.dumps(entries))}
        support.write_caustics(self.path(name), {n: self.pixels() for n in [*LAYERS, *extra]}, attrs=attrs)

    @staticmethod
    def kind(layer):
        ends = {"_ind": "indirect", "_E": "irradiance", "_S": "seen"}
        return next((v for k, v in ends.items() if layer.endswith(k)), "radiance")

    def shot(self, name):
        """Runs add; the layer that it changed, and what it made of it."""
        kind, options = SHOTS[name]
        layer = self.make_beauty(kind)
        self.make_caustics(kind)
        self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("out.exr"), *options)
        return layer, self.result(prefix=layer)

    def assert_close(self, got, wanted, tolerance=2e-6):
        """Within a few roundings of float, of the largest value that is summed."""
        worst = float(np.max(np.abs(got.astype("f8") - wanted)))
        self.assertLessEqual(worst, tolerance * max(1.0, float(np.max(np.abs(wanted)))), "the pictures differ")
