# SPDX-License-Identifier: Apache-2.0
"""The Blender script, run in Blender itself ($BLENDER, else the one in the path): its composite is our picture, and
the sliders of a saved file come back as a recipe."""
import json
import os
import shutil
import subprocess
import sys
import unittest

import shots
from shots import SHOTS, exrlib, np, rgb, support

BLENDER = shutil.which(os.environ.get("BLENDER", "blender"))
HERE = os.path.dirname(os.path.abspath(__file__))


class Blender(shots.Shot):
    def build(self, *words, script="shot.py", expect=0, **job):
        """Runs the script and in_blender.py; what Blender said of it, and the rendered picture."""
        if job.get("out", True):
            job["out"] = self.path("blender.exr")
        environment = {**os.environ, "HOME": self.folder, "BLENDER_USER_CONFIG": self.folder, "CAUSTICS_JOB": json.dumps(job)}
        done = subprocess.run([BLENDER, "-b", "--factory-startup", "--python-exit-code", "3", "--python", self.path(script),
                               "--python", os.path.join(HERE, "in_blender.py"), *(["--", *words] if words else [])],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment, check=False)
        self.assertEqual(done.returncode, expect, done.stdout)
        if expect:
            return done.stdout, None
        built = json.loads(next(line[6:] for line in done.stdout.splitlines() if line.startswith("BUILT ")))
        return built, self.result("blender.exr") if job["out"] else None

    def script(self, file="out.exr", *words):
        self.run_merge("blender", self.path(file), "-o", self.path("shot.py"), *words)

    def test_equals_add(self):
        worst = 0
        for name in sorted(set(SHOTS) - {"negative_tint"}):
            with self.subTest(name):
                layer, wanted = self.shot(name)
                self.script()
                built, got = self.build()
                self.assertEqual(built["size"], [30, 20])
                self.assert_close(got, wanted, 4e-6)
                worst = max(worst, float(np.max(np.abs(got - wanted))))
                if layer:
                    alpha = self.out()[0].channels[layer + ".A"]
                    self.assertTrue(np.array_equal(self.out("blender.exr")[0].channels["A"], alpha))
        print(f"Blender {built['version']}: largest difference {worst:.2g}", file=sys.stderr)

    def test_beauty_after_the_dashes(self):
        """A caustics file takes the beauty from the command line."""
        for kind in ("plain", "multilayer"):
            with self.subTest(kind):
                layer = self.make_beauty(kind)
                self.make_caustics(kind)
                self.script("caustics.exr", "--ev", "key=1")
                self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("out.exr"), "--ev", "key=1")
                self.assert_close(self.build(self.path("beauty.exr"))[1], self.result(prefix=layer), 4e-6)

    def test_render_layers(self):
        """Without a beauty it is added to the scene's own render, which is grey here."""
        self.make_caustics("plain")
        self.script("caustics.exr")
        _, got = self.build(resolution=[30, 20])
        lights = [support.np.stack([p.channels[f"{p_name}.{c}"] for c in "RGB"], 2)
                  for p in self.out("caustics.exr") for p_name in [next(iter(p.channels)).rpartition(".")[0]] if p_name]
        added = sum(v.astype(float) for v in lights)
        world = got.astype(float) - added
        self.assertLess(float(world.max() - world.min()), 1e-5, "the rest is the even background")
        self.assertGreater(float(world.mean()), 0.01)

    def test_sliders_and_back(self):
        """Moved sliders are the same as options, running the script again changes nothing, a saved file gives a recipe."""
        self.shot("plain")
        self.script()
        sliders = {"key EV": -0.75, "rim gain": 0.3, "rim tint": [0.5, 1, 0.125, 1], "key mute": 0, "rim solo": 0}
        built, got = self.build(sliders=sliders, blend=self.path("shot.blend"), again=self.path("shot.py"))
        self.assertEqual(len(built["groups"]), 1)
        options = [*SHOTS["plain"][1], "--ev", "key=-0.75", "--gain", "rim=0.3", "--tint", "rim=0.5,1,0.125"]
        self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("flags.exr"), *options)
        self.assert_close(got, self.result("flags.exr"), 4e-6)
        self.run_merge("recipe", "--from-blender", self.path("shot.blend"), "-o", self.path("recipe.json"), env={"BLENDER": BLENDER})
        self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("new.exr"), "--recipe", self.path("recipe.json"))
        self.assertTrue(np.array_equal(self.result("new.exr"), self.result("flags.exr")))
        self.build(sliders={"key mute": 1, "rim solo": 1}, blend=self.path("shot.blend"), out=None)
        lights = json.loads(self.run_merge("recipe", "--from-blender", self.path("shot.blend"), env={"BLENDER": BLENDER}).stdout)["lights"]
        self.assertEqual([lights["key"]["mute"], lights["rim"]["mute"], lights["key"]["solo"], lights["rim"]["solo"]],
                         [True, False, False, True])

    def test_sequence(self):
        for frame in (3, 4):
            self.make_beauty("plain", f"b.{frame:04d}.exr")
            self.make_caustics("plain", f"c{frame:02d}.exr")
        self.run_merge("add", self.path("b.####.exr"), self.path("c%02d.exr"), "-o", self.path("out.####.exr"), "--frames",
                       "3-4", "--ev", "key=1", "--quiet")
        self.script("out.####.exr", "--frames", "3-4")
        for frame in (3, 4):
            self.assert_close(self.build(frame=frame)[1], self.result(f"out.{frame:04d}.exr"), 4e-6)

    def test_refusals(self):
        self.make_beauty("plain")
        support.write_caustics(self.path("caustics.exr"), {"caustics_key": self.pixels(8, 9)}, window=(2, 3, 10, 10), display=(0, 0, 29, 19))
        self.refused("blender", self.path("caustics.exr"), says="by their middles")
        support.write_text(self.path("x.blend"), "BLENDER-v304 and nothing else")
        self.refused("recipe", "--from-blender", self.path("x.blend"), says="x.blend")
        done = self.run_merge("recipe", "--from-blender", self.path("x.blend"), expect=1, env={"BLENDER": "/nowhere/blender"})
        self.assertIn("environment variable BLENDER", done.stderr)
        self.shot("negative_tint")
        self.refused("blender", self.path("out.exr"), says="no colour of Blender is negative")
        self.shot("plain")
        self.script()
        os.remove(self.path("caustics.exr"))
        said, _ = self.build(expect=3)
        self.assertIn("caustics.exr", said)


if __name__ == "__main__":
    if not BLENDER:
        print("not run: no blender in the path; Debian's package is called blender")
        sys.exit(77)
    unittest.main()
