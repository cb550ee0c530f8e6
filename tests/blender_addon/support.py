# SPDX-License-Identifier: Apache-2.0
"""What the add-on's tests share. They run in Blender: blender -b --factory-startup --python tests/blender_addon/test_X.py

CAUSTICS_BIN: the folder of the programs."""
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

import bpy
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.dont_write_bytecode = True
sys.path[:0] = [os.path.join(ROOT, "plugins", "blender"), os.path.join(ROOT, "tests", "composite"), os.path.join(ROOT, "scenes"), HERE]
BIN = os.environ["CAUSTICS_BIN"]
os.environ["PATH"] = BIN + os.pathsep + os.environ["PATH"]

import built  # noqa: E402
import caustics  # noqa: E402
import exrlib  # noqa: E402

from caustics import programs  # noqa: E402


def layers(path):
    """{name: (h, w, 3)} of every colour layer of a file."""
    made = {}
    for part in exrlib.read(path):
        for name in part.channels:
            if name.endswith("R"):
                made[name[:-1].rstrip(".")] = np.stack([part.channels[name[:-1] + c].astype("f8") for c in "RGB"], -1)
    return made


def read_ply(path):
    """(vertices, normals or None, triangles)."""
    with open(path, "rb") as f:
        head, data = f.read().split(b"end_header\n", 1)
    words = head.decode().split("\n")
    n, m = (int(next(w for w in words if w.startswith("element " + e)).split()[2]) for e in ("vertex", "face"))
    width = sum(w.startswith("property float") for w in words)
    v = np.frombuffer(data, "<f4", n * width).reshape(n, width)
    faces = np.frombuffer(data, np.dtype([("n", "u1"), ("i", "<i4", 3)]), m, n * width * 4)
    assert (faces["n"] == 3).all()
    return v[:, :3], v[:, 3:] if width == 6 else None, faces["i"]


def world_triangles(made):
    """All triangles of an export in world space, (n, 3, 3), in an order that does not depend on that of the file's."""
    found = []
    for obj in made.doc["objects"]:
        v, _, tri = read_ply(os.path.join(made.folder, obj["file"]))
        m = np.array(obj["matrix"])
        found.append((v @ m[:3, :3].T + m[:3, 3])[tri])
    soup = np.round(np.concatenate(found), 4) + 0.0
    soup = soup[np.arange(len(soup))[:, None], np.array([np.lexsort(t.T[::-1]) for t in soup])]  # within a triangle
    flat = soup.reshape(len(soup), 9)
    return flat[np.lexsort(flat.T[::-1])]


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="caustics-test-")
        self.addCleanup(shutil.rmtree, self.folder, True)
        self.assertEqual(self.scratch(), [])

    @staticmethod
    def scratch():
        """Folders of this Blender in shared memory; others may run beside it."""
        return [n for n in os.listdir("/dev/shm") if n.startswith(f"{programs.SCRATCH}{os.getpid()}-")]

    def new(self):
        built.empty()
        if not hasattr(bpy.types.Scene, "caustics"):
            caustics.register()
        return bpy.context.scene

    def path(self, name):
        return os.path.join(self.folder, name)

    def export(self, name="scene", **options):
        return caustics.export(self.path(name), **options)

    def generate(self, name="out", **options):
        return caustics.generate(output=self.path(name), threads=2, **{"photons": 20000, **options})

    def render_export(self, made, *words, out="direct.exr"):
        """caustic-render on an exported file; its layers."""
        path = self.path(out)
        run = subprocess.run([os.path.join(BIN, "caustic-render"), made.path, "-o", path, *words], capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr)
        return layers(path)

    def refused(self, says, call, *args, **options):
        with self.assertRaises(caustics.CausticsError) as caught:
            call(*args, **options)
        text = str(caught.exception)
        self.assertIn(says, text)
        self.assertTrue(text.endswith("."), text)
        self.assertNotIn("\n", text)


def run(*modules):
    """Runs the tests of the module that was started, and ends Blender with the result."""
    words = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    suite = unittest.defaultTestLoader.loadTestsFromNames(words, modules[0]) if words else unittest.defaultTestLoader.loadTestsFromModule(modules[0])
    result = unittest.TextTestRunner(verbosity=2, stream=sys.stdout).run(suite)
    sys.stdout.flush()
    os._exit(0 if result.wasSuccessful() and result.testsRun else 1)


__all__ = ["Case", "built", "caustics", "exrlib", "json", "layers", "np", "run", "struct", "world_triangles"]
