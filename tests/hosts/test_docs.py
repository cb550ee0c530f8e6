# SPDX-License-Identifier: Apache-2.0
"""Every command that docs/compositing.md and docs/hosts.md print does what they say, as it is printed."""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = pathlib.Path(os.environ["CAUSTIC_MERGE"]).parent
FEW = ["--photons", "5000", "--quiet"]


def commands(page):
    """Printed commands without placeholders in capitals; "..." stands for more of the same."""
    lines = []
    for kind, block, span in re.findall(r"^```(\w*)\n(.*?)^```$|`([^`]+)`", (ROOT / "docs" / page).read_text(), re.S | re.M):
        lines += [" ".join(span.split())] if span else [] if kind else block.splitlines()
    found = [line for line in lines if re.match(r"(caustic-(merge|render)|blender) .*\.", line)]
    return [line.replace(" ...", "") for line in found if not re.search(r"(?<![\w/.])[A-Z]{2,}\b", line)]


class Docs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="caustics_docs_", dir="/dev/shm" if os.path.isdir("/dev/shm") else None)
        self.addCleanup(folder.cleanup)
        self.place = pathlib.Path(folder.name)
        shutil.copytree(ROOT / "scenes", self.place / "scenes")
        shutil.copytree(ROOT / "scenes", self.place, dirs_exist_ok=True)
        shutil.copytree(ROOT / "tests" / "data" / "beauty", self.place / "tests" / "data" / "beauty")
        shutil.copy(self.place / "still_life.json", self.place / "scene.json")
        shutil.copy(self.place / "beauty" / "still_life.exr", self.place / "beauty.exr")
        self.run_one("caustic-render scene.json -o caustics.exr")

    def run_one(self, command):
        words = shlex.split(command)
        if words[0] == "caustic-render":
            words += FEW + ([] if "-o" in words else ["-o", "caustics.exr"])
        done = subprocess.run(words, cwd=self.place, capture_output=True, text=True, timeout=120,
                              env={**os.environ, "PATH": f"{PROGRAMS}:{os.environ['PATH']}", "PWD": str(self.place)})  # Blender goes by PWD
        self.assertEqual(done.returncode, 0, f"{command}: {done.stderr} {done.stdout[-2000:]}")
        out = words[words.index("-o") + 1] if "-o" in words else None
        if out and "#" not in out:
            self.assertTrue((self.place / out).is_file(), command)

    def frames(self, count=240):
        """Names for every frame of the two sequences that the pages add; one small picture each."""
        self.run_one("caustic-render scene.json --resolution 32x18 -o small.exr")
        subprocess.run(["oiiotool", "beauty.exr", "--resize", "32x18", "-o", "small_beauty.exr"], cwd=self.place, check=True)
        for i in range(1, count + 1):
            os.link(self.place / "small_beauty.exr", self.place / f"beauty.{i:04d}.exr")
            os.link(self.place / "small.exr", self.place / f"caustics.{i:04d}.exr")

    def test_compositing(self):
        found = commands("compositing.md")
        self.assertGreater(len(found), 5)
        self.frames()
        for seed, name in enumerate("ab"):
            self.run_one(f"caustic-render scene.json --seed {seed} -o {name}.exr")
        wine = [c for c in found if "d_wineglass" in c or "d_off" in c]
        self.assertEqual(len(wine), 2)
        for command in [c for c in found if c not in wine] + sorted(wine, reverse=True):  # its caustics before its picture
            with self.subTest(command):
                self.run_one(command)
        self.assertTrue((self.place / "out.0240.exr").is_file())

    @unittest.skipUnless(shutil.which("blender"), "not run: no Blender")
    def test_hosts(self):
        found = commands("hosts.md")
        self.assertGreater(len(found), 8)
        self.frames()
        save = f"import bpy; bpy.ops.wm.save_as_mainfile(filepath='{self.place}/shot.blend')"
        self.run_one(f'blender -b --factory-startup --python-exit-code 3 --python-expr "{save}"')
        self.run_one("caustic-merge add beauty.####.exr caustics.####.exr -o out.####.exr --frames 1-240")
        for command in found:
            with self.subTest(command):
                if command.startswith("blender "):  # without a window, and saved as the next step says
                    opened, _, beauty = command.partition(" -- ")
                    command = opened.replace("blender ", "blender -b --python-exit-code 3 ") + f' --python-expr "{save}"'
                    command += f" -- {beauty}" if beauty else ""
                self.run_one(command)


if __name__ == "__main__":
    if not shutil.which("oiiotool"):
        print("not run: no oiiotool")
        sys.exit(77)
    unittest.main()
