# SPDX-License-Identifier: Apache-2.0
"""Relighting equals rendering again: real layers of a small scene, gained, against a render with the lights changed; shards of
real renders. CAUSTIC_RENDER names the renderer."""
import json
import os
import subprocess
import unittest

from support import SOURCE, Case, np
import exrlib

SCENE = os.path.join(SOURCE, "scenes", "d_wineglass.json")
SIZE = 24, 14


class Rerender(Case):
    def render(self, name, change=None, seed=0, photons=4000, **more):
        with open(SCENE) as file:
            scene = json.load(file)
        for item in scene["objects"]:
            if "file" in item:
                item["file"] = os.path.join(SOURCE, "scenes", item["file"])
        for light in scene["lights"]:
            change and change(light)
        with open(self.path(name + ".json"), "w") as file:
            json.dump(scene, file)
        words = [os.environ["CAUSTIC_RENDER"], self.path(name + ".json"), "-o", self.path(name), "--photons", photons, "--seed", seed,
                 "--estimator", "P", "--effects", "direct", "--resolution", f"{SIZE[0]}x{SIZE[1]}", "--quiet"]
        words += [w for k, v in more.items() for w in (f"--{k}", v)]
        done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.path(name)

    def both(self, change, *words):
        """(the old layers, gained), (new layers as they are)"""
        path, _ = self.beauty(height=SIZE[1], width=SIZE[0])
        self.run_merge("add", path, self.render("old.exr"), "-o", self.path("a.exr"), *words)
        self.run_merge("add", path, self.render("new.exr", change), "-o", self.path("b.exr"))
        return self.result("a.exr"), self.result("b.exr")

    def test_powers_of_two_bit_for_bit(self):
        def change(light):
            light["power_w"] *= {"Key": 4, "Fill": .5}[light["name"]]
        relit, rendered = self.both(change, "--ev", "key=2", "--gain", "fill=.5")
        self.assertTrue(np.array_equal(relit, rendered))
        self.assertGreater(np.ptp(rendered), .01)

    def test_any_factor(self):
        def change(light):
            if light["name"] == "Key":
                light["power_w"] *= 3.7
                light["color"] = [c * t for c, t in zip(light.get("color", [1, 1, 1]), (1, .5, .2))]
        relit, rendered = self.both(change, "--gain", "key=3.7", "--tint", "key=1,.5,.2")
        self.assertLess(np.abs(relit.astype("f8") - rendered).max(), 4e-7 * np.abs(rendered).max())

    def test_another_seed_lies_within_the_stated_error(self):
        a, b = (exrlib.read(self.render(f"{s}.exr", seed=s, photons=40000)) for s in (1, 2))
        for part, other in zip(a[1:], b[1:]):
            x, y = (np.stack([p.channels[n] for n in sorted(p.channels)], 2).astype("f8") for p in (part, other))
            light = next(iter(part.channels)).split("_")[1].split(".")[0]
            stated = json.loads(a[0].attrs["caustics/error"][1])[light]["direct"]
            measured = np.sqrt(((x - y) ** 2).mean() / 2) / np.sqrt((((x + y) / 2) ** 2).mean())
            self.assertLess(measured, 4 * stated)

    def test_shards(self):
        files = [self.render(f"s{i}.exr", seed=i, photons=p, layers="radiance,error") for i, p in enumerate((4000, 8000))]
        self.run_merge("shards", *files, "-o", self.path("joined.exr"))
        self.run_merge("check", self.path("joined.exr"))
        a, b, joined = (exrlib.read(f)[1].channels for f in (*files, self.path("joined.exr")))
        name = next(n for n in a if n.endswith("_key.R"))
        self.assert_exact(joined[name], (a[name].astype("f8") + 2 * b[name].astype("f8")) / 3)
        other = self.render("other.exr", lambda light: light.update(power_w=1), seed=9)
        self.refused("shards", files[0], other, "-o", self.path("none.exr"), says="differs")


if __name__ == "__main__":
    unittest.main()
