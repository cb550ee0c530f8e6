# SPDX-License-Identifier: Apache-2.0
"""Whole runs of the add-on in Blender: picture, caustics, sum."""
import os
import sys
import types

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import Case, built, caustics, layers, np, run  # noqa: E402

import blender_scenes  # noqa: E402

from caustics.job import sentence  # noqa: E402

FILES = {"a": "a_ball", "b": "b_ring", "c": "c_water", "d": "d_wineglass"}


def state(scene):
    """Settings that a run may touch."""
    r, c = scene.render, scene.cycles
    im = r.image_settings
    return [c.caustics_reflective, c.caustics_refractive, r.engine, r.use_sequencer, r.use_compositing, im.file_format, im.color_mode,
            im.color_depth, im.exr_codec, [(v.name, v.use, v.use_pass_diffuse_color) for v in scene.view_layers],
            [(t.name, len(t.node_tree.links)) for t in bpy.data.materials if t.node_tree], scene.frame_current]


class Words(Case):
    def test_progress_in_words(self):
        """No count of photons before there is one, and never "0.0 million"."""
        def words(stage, photons, error=None, left=None):
            return sentence({"stage": stage, "photons_per_light": photons, "error": error, "remaining_s": left})
        self.assertEqual(words("probing", 0), "Looking for caustics")
        self.assertEqual(words("rendering", 0), "Tracing")
        self.assertEqual(words("rendering", 16384, 0.5), "16 thousand photons per light, error 50.0 %")
        self.assertEqual(words("rendering", 2.5e6, 0.021, 12.4), "2.5 million photons per light, error 2.1 %, 12 s left")


class Runs(Case):
    def check(self, scene, cropped=False, albedo=False):
        """The sum is picture + layers; the exported scene gives the same layers; all settings are back."""
        before = state(scene)
        job = self.generate(keep_beauty=True)
        self.assertEqual(state(scene), before)
        mine, total = layers(job.caustics), layers(job.result)
        beauty = layers(job.beauty)["ViewLayer.Combined"]
        light = [n for n in mine if n.startswith("caustics_") and not n.endswith(("_E", "_S"))]
        self.assertTrue(light)
        self.assertGreater(sum(mine[n].mean() for n in light), 0)
        if not albedo:
            added = sum(mine[n] for n in light)
            if cropped:
                x0, y0, x1, y1 = job.extract.region
                self.assertEqual(beauty.shape[:2], (y1 - y0, x1 - x0))
                added = added[y0:y1, x0:x1]
            np.testing.assert_allclose(total["ViewLayer.Combined"], beauty + added, rtol=2e-6, atol=1e-6)
        made = self.export()
        words = ["--photons", "20000", "--threads", "2"] + (["--layers", "radiance,irradiance"] if albedo else [])
        if job.extract.region:
            words += ["--region", ",".join(map(str, job.extract.region))]
        direct = self.render_export(made, *words)
        self.assertEqual(set(direct), set(mine))
        for name in mine:
            np.testing.assert_allclose(direct[name], mine[name], rtol=0, atol=1e-5)
        self.assertEqual(self.scratch(), [])
        return job, mine


def of_file(name):
    def test(self):
        self.new()
        options = types.SimpleNamespace(groups=False)
        scene, doc = blender_scenes.build(os.path.join(os.path.dirname(blender_scenes.__file__), FILES[name] + ".json"), options)
        caustics.unregister()
        caustics.register()
        render = types.SimpleNamespace(spp=1, seed=0, mode="on", res="96x54", threads=2, half=False, multilayer=False)
        blender_scenes.settings(scene, doc, render)
        self.check(scene)
    return test


def of_built(name):
    def test(self):
        scene = self.new()
        built.SCENES[name](scene)
        job, mine = self.check(scene, cropped=name == "border_crop", albedo=name.startswith("textured"))
        if name == "two_groups":
            self.assertEqual({n for n in mine if n.startswith("caustics_") and not n.endswith("_ind")}, {"caustics_warm", "caustics_cold"})
        if name.startswith("textured"):
            self.assertTrue(any("Diffuse Color pass" in line for line in job.notes), job.notes)
            beauty, total = layers(job.beauty), layers(job.result)
            layer = "ViewLayer." + ("DiffCol" if "ViewLayer.DiffCol" in beauty else "Diffuse Color")
            ind = sum(v for k, v in mine.items() if k.endswith("_ind")) if any(k.endswith("_ind") for k in mine) else 0
            want = beauty["ViewLayer.Combined"] + beauty[layer] * mine["caustics_Key_E"] / np.pi + mine["caustics_Key_S"] + ind
            np.testing.assert_allclose(total["ViewLayer.Combined"], want, rtol=1e-5, atol=1e-5)
            if name == "textured_seen":  # what is behind glass and in mirrors has no Diffuse Color
                added = total["ViewLayer.Combined"] - beauty["ViewLayer.Combined"]
                for what, mask in built.halves(beauty[layer]).items():
                    self.assertGreater(mask.sum(), 100, what)
                    self.assertGreater(added[mask].mean(), 0.2 * added[~mask].mean(), what)
    return test


for n in FILES:
    setattr(Runs, "test_file_" + n, of_file(n))
for n in built.SCENES:
    setattr(Runs, "test_" + n, of_built(n))


if __name__ == "__main__":
    import __main__
    run(__main__)
