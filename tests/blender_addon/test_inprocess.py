# SPDX-License-Identifier: Apache-2.0
"""The renderer loaded into a host (here Python) that exports an Embree and an OpenEXR of its own. Without Blender.

CAUSTICS_BIN: the folder of the programs. CAUSTICS_FOREIGN_HOST, CAUSTICS_FOREIGN_ALLOCATOR: libraries of this folder's C files."""
import os
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
BIN = os.environ["CAUSTICS_BIN"]
SCENE = os.path.join(ROOT, "scenes", "a_ball.json")
HOST, ALLOCATOR = os.environ["CAUSTICS_FOREIGN_HOST"], os.environ["CAUSTICS_FOREIGN_ALLOCATOR"]

# The add-on's modules without its __init__, which wants Blender.
RENDER = """
import ctypes, os, sys, threading, types
package = types.ModuleType("caustics")
package.__path__ = [{addon!r}]
sys.modules["caustics"] = package
from caustics import inprocess, options, programs
from caustics.errors import CausticsError
programs.folder = lambda: {bin!r}
if {foreign!r}:
    ctypes.CDLL({foreign!r}, mode=ctypes.RTLD_GLOBAL)
if {shallow}:
    os.RTLD_DEEPBIND = 0
extract = types.SimpleNamespace(path={scene!r}, region=(0, 0, 64, 36))
made = options.Options("x", photons={photons}, threads=2, seed=3)
try:
    render = inprocess.Render(made, extract, False, {out!r}, {out!r} + ".json")
    if {cancel}:
        while not render.progress().get("photons_per_light"):
            pass
        render.stop()
    render.thread.join()
    render.check()
except CausticsError as error:
    print(error)
    sys.exit(1)
print(render.output(), threading.active_count())
"""


class InProcess(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.out = os.path.join(self.folder, "inside.exr")

    def inside(self, foreign=HOST, shallow=False, preload="", scene=SCENE, photons=20000, cancel=False):
        code = RENDER.format(addon=os.path.join(ROOT, "plugins", "blender", "caustics"), bin=BIN, foreign=foreign, shallow=shallow, scene=scene,
                             out=self.out, photons=photons, cancel=cancel)
        return subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, env={**os.environ, "LD_PRELOAD": preload}, timeout=300)

    def same(self, run):
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)
        path = os.path.join(self.folder, "child.exr")
        subprocess.run([os.path.join(BIN, "caustic-render"), SCENE, "-o", path, "--photons", "20000", "--seed", "3", "--region", "0,0,64,36", "--quiet"], check=True)
        with open(path, "rb") as a, open(self.out, "rb") as b:
            self.assertEqual(a.read(), b.read())

    def test_foreign_host(self):
        """Ours calls its own Embree and OpenEXR, and makes the bytes that the program makes; its thread ends."""
        run = self.inside()
        self.same(run)
        self.assertTrue(run.stdout.startswith("1 light") and run.stdout.endswith(" 1\n"), run.stdout)

    def test_without_deep_binding(self):
        """The host does capture, or the test above would show nothing."""
        run = self.inside(shallow=True)
        self.assertLess(run.returncode, 0)
        self.assertIn("captured rtc", run.stderr)

    def test_own_allocator(self):
        """Deep binding would mix two allocators: without it, and refused where the host captures."""
        self.same(self.inside(foreign="", preload=ALLOCATOR))
        run = self.inside(preload=ALLOCATOR)
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("This Blender has an allocator of its own and captures rtcNewDevice", run.stdout)

    def test_errors(self):
        run = self.inside(scene="/there/is/no.json")
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertIn("no.json", run.stdout)

    def test_cancel(self):
        run = self.inside(photons=10**12, cancel=True)
        self.assertEqual((run.returncode, run.stdout), (1, "The renderer was stopped.\n"), run.stderr)
        self.assertFalse(os.path.exists(self.out))


if __name__ == "__main__":
    unittest.main()
