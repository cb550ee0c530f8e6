# SPDX-License-Identifier: Apache-2.0
"""caustic-merge add with what hosts and users get wrong: contradicting tags, odd parts, outputs that cannot be."""
import json
import os
import shutil
import struct
import subprocess
import unittest

from support import Case, REC709, matrix, np, read_bytes, rgb, write_text
import exrlib

XY = {"rec709": (.64, .33, .3, .6, .15, .06, .3127, .329), "ap1": (.713, .293, .165, .83, .128, .044, .32168, .33767)}


def chromaticities(space):
    return {"chromaticities": ("chromaticities", struct.pack("<8f", *XY[space]))}


def interop(name):
    return {"colorInteropID": exrlib.string(name)}


def tags(part):
    return {k: v[1].decode("latin-1") if v[0] == "string" else v[0] for k, v in part.attrs.items()
            if k.lower() in ("colorinteropid", "chromaticities", "acesimagecontainerflag")}


class Tags(Case):
    def shot(self, depth, combined, colour):
        parts = [("VL.Depth", {"VL.Depth.Z": self.pixels()[:, :, 0]}, depth),
                 ("VL.Combined", rgb("VL.Combined", self.pixels()), combined),
                 ("VL.DiffCol", rgb("VL.DiffCol", self.pixels()), colour)]
        exrlib.write(self.path("beauty.exr"), parts)
        return self.path("beauty.exr"), self.caustics()[0]

    def test_all_parts_have_the_same_chromaticities(self):
        """OpenEXR refuses a file whose parts differ in them."""
        shot = self.shot(chromaticities("rec709"), chromaticities("rec709"), chromaticities("rec709"))
        for words, left in ((["--beauty-space", "ACEScg"], 0), (["--beauty-space", "Linear Rec.709"], 3), (["--keep-layers"], 5)):
            self.run_merge("add", *shot, "-o", self.path("out.exr"), *words)
            self.assertEqual(sum("chromaticities" in p.attrs for p in self.out()), left)
            subprocess.run(["exrstdattr", self.path("out.exr"), "-string", "read", "it", self.path("by_openexr.exr")], check=True)

    def test_each_part_has_its_own_tag(self):
        shot = self.shot(interop("data"), interop("lin_ap1_scene"), interop("lin_ap1_scene"))
        self.run_merge("add", *shot, "-o", self.path("out.exr"))
        self.assertEqual([tags(p)["colorInteropID"] for p in self.out()], ["data", "lin_ap1_scene", "lin_ap1_scene"])
        self.run_merge("add", *shot, "-o", self.path("out.exr"), "--beauty-space", "lin_rec709_scene")
        self.assertEqual([tags(p)["colorInteropID"] for p in self.out()], ["data", "lin_rec709_scene", "lin_rec709_scene"])
        for command in (["list"], ["list", "--json"]):
            self.assertIn("lin_ap1_scene", self.run_merge(*command, shot[0]).stdout)
        self.assertIn("no fault", self.run_merge("check", shot[0]).stdout)

    def test_a_part_of_data_says_nothing_of_the_others(self):
        shot = self.shot(interop("data"), {}, {})
        self.refused("add", *shot, "-o", self.path("out.exr"), says="does not say in which colour space")
        self.run_merge("add", *shot, "-o", self.path("out.exr"), "--beauty-space", "ACEScg")
        self.assertEqual([tags(p) for p in self.out()], [interop_of("data"), interop_of("lin_ap1_scene"), {}])
        shot = self.shot({**interop("data"), "BlenderMultiChannel": exrlib.string("x")}, {}, {})
        self.assertIn("written by Blender", self.run_merge("add", *shot, "-o", self.path("out.exr")).stderr)

    def test_unknown_is_replaced(self):
        shot = self.shot({}, interop("unknown"), {})
        self.run_merge("add", *shot, "-o", self.path("out.exr"), "--beauty-space", "ACEScg")
        self.assertEqual([v for p in self.out() for v in tags(p).values()], ["lin_ap1_scene"])

    def test_caustics_say_it_where_the_light_is(self):
        beauty, _ = self.beauty()
        light = self.pixels()
        for first in ({}, interop("data")):
            exrlib.write(self.path("c.exr"), [("rgb", rgb("", light), first), ("caustics_key", rgb("caustics_key", light), REC709)])
            self.run_merge("add", beauty, self.path("c.exr"), "-o", self.path("out.exr"))

    def test_contradiction_is_told(self):
        caustics, _ = self.caustics()
        beauty, _ = self.beauty(attrs={**REC709, **chromaticities("ap1")})
        done = self.run_merge("add", beauty, caustics, "-o", self.path("out.exr"))
        for part in ("twice", "lin_rec709_scene by colorInteropID", "lin_ap1_scene by chromaticities", "--beauty-space"):
            self.assertIn(part, done.stderr)
        self.run_merge("add", beauty, caustics, "-o", self.path("out.exr"), "--beauty-space", "ACEScg")
        self.assertEqual(tags(self.out()[0]), {"chromaticities": "chromaticities", "colorInteropID": "lin_ap1_scene"})
        beauty, _ = self.beauty(attrs={**interop("lin_ap1_scene"), **chromaticities("ap1")})
        self.assertNotIn("twice", self.run_merge("add", beauty, caustics, "-o", self.path("out.exr")).stderr)

    def test_options_are_quoted_as_options(self):
        caustics, _ = self.caustics()
        beauty, _ = self.beauty()
        for space, says in (("sRGB Texture", "not scene-linear"), ("Raw", "data"), ("sRGB", "display-referred")):
            done = self.refused("add", beauty, caustics, "-o", self.path("out.exr"), "--beauty-space", space, says=says)
            self.assertIn(f'--beauty-space: the space "{space}"', done.stderr)


def interop_of(name):
    return {"colorInteropID": name}


class Blenders(Case):
    """Blender 3's configuration calls linear Rec.709 "Linear" and has no interchange names."""

    @unittest.skipUnless(shutil.which("blender"), "not run: no Blender")
    def test_spaces_are_found_by_their_matrices(self):
        caustics, lights = self.caustics({"caustics_key": self.pixels()})
        for tag, space in (("lin_rec709_scene", "rec709"), ("lin_ap1_scene", "ap1")):
            beauty, before = self.beauty(attrs=interop(tag))
            self.run_merge("add", beauty, caustics, "-o", self.path("out.exr"), "--ocio", "blender")
            wanted = before + lights["caustics_key"].astype("f8") @ matrix("rec709", space).T
            self.assertLess(np.max(np.abs(self.result() - wanted)), 1e-6 if space == "rec709" else 3e-3)  # found within 1e-3 of each term
        beauty, _ = self.beauty(attrs={})
        for space in ("Linear", "Linear Rec.709", "lin_rec709_scene"):
            self.run_merge("add", beauty, caustics, "-o", self.path("out.exr"), "--ocio", "blender", "--beauty-space", space)
            self.assertEqual(tags(self.out()[0]), interop_of("lin_rec709_scene"))
        self.refused("add", beauty, caustics, "-o", self.path("out.exr"), "--ocio", "blender", "--beauty-space", "lin_p3d65_scene",
                     says="no colour space")
        for host in ("nuke", "blender"):
            self.run_merge(host, caustics, "-o", self.path("script"), "--ocio", "blender", "--tint-space", "Linear ACEScg", "--ev", "key=1")


class Outputs(Case):
    def test_side_outputs_are_tried_first(self):
        beauty, _ = self.beauty()
        caustics, _ = self.caustics()
        for option, name in (("--preview", "no/p.png"), ("--contact-sheet", "no/s.jpg"), ("--write-recipe", "no/r.json")):
            self.refused("add", beauty, caustics, "-o", self.path("out.exr"), option, self.path(name), says="cannot write", expect=4)

    def test_what_cannot_be_written_to(self):
        beauty, _ = self.beauty()
        caustics, _ = self.caustics()
        os.mkfifo(self.path("pipe"))
        for output in (self.folder, "/dev/full", self.path("pipe")):
            self.refused("add", beauty, caustics, "-o", output, says="cannot write", expect=4)

    def test_recipe_of_a_sequence_without_its_first_frame(self):
        for frame in (2, 3):
            self.beauty(name=f"b.{frame}.exr")
            self.caustics(name=f"c.{frame}.exr")
        words = ["add", self.path("b.#.exr"), self.path("c.#.exr"), "-o", self.path("o.#.exr"), "--frames", "1-3", "--ev", "key=2"]
        done = subprocess.run([os.environ["CAUSTIC_MERGE"], *words, "--write-recipe", self.path("r.json"), "--quiet"], capture_output=True)
        self.assertEqual(done.returncode, 1)
        with open(self.path("r.json")) as file:
            self.assertEqual(json.load(file)["lights"]["caustics_key"]["ev"], 2)
        subprocess.run([os.environ["CAUSTIC_MERGE"], *words, "--write-recipe", self.path("each.#.json"), "--quiet"], capture_output=True)
        self.assertEqual(sorted(f for f in os.listdir(self.folder) if f.startswith("each")), ["each.2.json", "each.3.json"])


    def test_a_factor_too_large_is_the_fault_of_who_gave_it(self):
        beauty, _ = self.beauty()
        caustics, _ = self.caustics()
        write_text(self.path("r.json"), json.dumps({"caustics_recipe": 1, "lights": {"key": {"ev": 3000}}}))
        self.refused("add", beauty, caustics, "-o", self.path("out.exr"), "--recipe", self.path("r.json"), says="factor", expect=1)
        self.refused("add", beauty, caustics, "-o", self.path("out.exr"), "--ev", "key=3000", says="factor", expect=2)


class Parts(Case):
    def test_bare_channels_are_told_apart_by_their_parts(self):
        """As Houdini writes: every part has R, G and B."""
        exrlib.write(self.path("beauty.exr"), [("C", rgb("", self.pixels()), REC709), ("N", rgb("", self.pixels()), {})])
        caustics, _ = self.caustics()
        self.refused("add", self.path("beauty.exr"), caustics, "-o", self.path("out.exr"), says="C, N")
        self.run_merge("add", self.path("beauty.exr"), caustics, "-o", self.path("out.exr"), "--pass", "C")
        done = self.run_merge("diff", self.path("beauty.exr"), self.path("out.exr"), expect=1)
        self.assertEqual(done.stdout.count("channel "), 3, done.stdout)

    def test_plain_channels_beside_a_combined_pass(self):
        plain, combined = self.pixels(), self.pixels()
        exrlib.write(self.path("beauty.exr"), [(None, {**rgb("", plain), **rgb("VL.Combined", combined)}, REC709)])
        caustics, lights = self.caustics()
        total = sum(v.astype("f8") for v in lights.values())
        for words, kept, changed in ((["--pass", "R,G,B"], "VL.Combined", ""), ([], "", "VL.Combined")):
            self.run_merge("add", self.path("beauty.exr"), caustics, "-o", self.path("out.exr"), *words)
            before = {"": plain, "VL.Combined": combined}
            self.assertTrue(np.array_equal(self.result(prefix=kept), before[kept]))
            self.assert_exact(self.result(prefix=changed), before[changed] + total)
            self.run_merge("nuke", self.path("out.exr"), "-o", self.path("shot.nk"))

    def test_every_light_may_have_its_own_window(self):
        """A cropped beauty may miss one light and meet another."""
        beauty, before = self.beauty(window=(20, 0, 29, 19), display=(0, 0, 29, 19), width=10)
        far, near = self.pixels(20, 5), self.pixels(20, 8)
        light = {"caustics_a": (far, 0), "caustics_b": (near, 22)}
        files = []
        for name, (pixels, x) in light.items():
            exrlib.write(self.path(name), [(name, rgb(name, pixels), REC709), (name + "x", rgb("x", pixels), {})],
                         window=(x, 0, x + pixels.shape[1] - 1, 19), display=(0, 0, 29, 19))
            files.append(self.path(name))
        words = [w for f in files for w in (f + ":0",)]
        subprocess.run(["exrmultipart", "-combine", "-i", *words, "-o", self.path("c.exr")], check=True, stdout=subprocess.DEVNULL)
        self.run_merge("add", beauty, self.path("c.exr"), "-o", self.path("out.exr"))
        wanted = before.astype("f8")
        wanted[:, 2:] += near
        self.assert_exact(self.result(), wanted)

    def test_layers_that_a_host_has_renamed(self):
        beauty, before = self.beauty()
        a, b = self.pixels(), self.pixels()
        exrlib.write(self.path("c.exr"), [(None, {**rgb("A.caustics_key", a), **rgb("B.caustics_key", b)}, REC709)])
        self.refused("add", beauty, self.path("c.exr"), "-o", self.path("out.exr"), "--gain", "key=2",
                     says=["A.caustics_key", "B.caustics_key"])
        self.run_merge("add", beauty, self.path("c.exr"), "-o", self.path("out.exr"), "--gain", "B.caustics_key=2")
        self.assert_exact(self.result(), before.astype("f8") + a + 2. * b)
        exrlib.write(self.path("c.exr"), [(None, {**rgb("A.caustics_key", a), **rgb("A.caustics_key_ind", b)}, REC709)])
        self.run_merge("add", beauty, self.path("c.exr"), "-o", self.path("out.exr"), "--gain", "A.caustics_key_ind=0", "--ev", "key=1")
        self.assert_exact(self.result(), before + 2. * a)

    def test_layer_list_of_another_type(self):
        beauty, _ = self.beauty()
        caustics, _ = self.caustics(attrs={"caustics/layers": exrlib.integer(4)})
        self.refused("add", beauty, caustics, "-o", self.path("out.exr"), says=["caustics/layers", "int"])

    def test_damage_is_said_to_be_damage(self):
        beauty, _ = self.beauty()
        caustics, _ = self.caustics()
        data = read_bytes(beauty)
        with open(beauty, "wb") as file:
            file.write(data[:len(data) // 2])
        self.refused("add", beauty, caustics, "-o", self.path("out.exr"), says=[beauty, "damaged, cut off"])
        write_text(beauty, "not a picture at all")
        self.refused("add", beauty, caustics, "-o", self.path("out.exr"), says=[beauty, "no EXR"])


if __name__ == "__main__":
    unittest.main()
