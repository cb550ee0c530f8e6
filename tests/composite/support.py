# SPDX-License-Identifier: Apache-2.0
"""What the tests of caustic-merge share: running it, making caustics, reading PNGs, exact colour matrices."""
import os
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

try:
    import numpy as np
except ImportError:
    print("not run: this Python has no numpy")
    sys.exit(77)

import exrlib

MERGE = os.environ["CAUSTIC_MERGE"]
SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
DATA = os.path.join(SOURCE, "tests", "data", "beauty")
SHARED = os.path.join(os.path.dirname(SOURCE), "shared")
SAMPLES = os.environ.get("CAUSTICS_SAMPLES", os.path.join(SHARED, "cycles", "samples"))
CORPUS = os.environ.get("CAUSTICS_EXR_CORPUS", os.path.join(SHARED, "exr-corpus"))
REC709 = {"colorInteropID": exrlib.string("lin_rec709_scene")}
BRADFORD = np.array([[.8951, .2664, -.1614], [-.7502, 1.7135, .0367], [.0389, -.0685, 1.0296]])
D65, ACES_WHITE = (.3127, .3290), (.32168, .33767)
PRIMARIES = {"rec709": ((.64, .33), (.3, .6), (.15, .06), D65),
             "ap1": ((.713, .293), (.165, .83), (.128, .044), ACES_WHITE),
             "ap0": ((.7347, .2653), (0, 1), (.0001, -.077), ACES_WHITE),
             "p3": ((.68, .32), (.265, .69), (.15, .06), D65),
             "rec2020": ((.708, .292), (.17, .797), (.131, .046), D65)}


def _xyz(x, y):
    return np.array([x / y, 1, (1 - x - y) / y])


def _to_xyz(name):
    *rgb, white = PRIMARIES[name]
    m = np.array([_xyz(*p) for p in rgb]).T
    return m * np.linalg.solve(m, _xyz(*white)), _xyz(*white)


def matrix(source, target):
    """RGB to RGB by the primaries, Bradford adaptation."""
    a, white_a = _to_xyz(source)
    b, white_b = _to_xyz(target)
    adapt = np.linalg.inv(BRADFORD) @ np.diag((BRADFORD @ white_b) / (BRADFORD @ white_a)) @ BRADFORD
    return np.linalg.inv(b) @ adapt @ a


def rgb(prefix, pixels, dtype="<f4"):
    """Channels from an array of shape (height, width, 3)."""
    return {f"{prefix}.{c}" if prefix else c: pixels[:, :, i].astype(dtype) for i, c in enumerate("RGB")}


def write_caustics(path, lights, attrs=None, interleave=False, **options):
    """lights: {layer: (height, width, 3) array}. Part 0 is their sum, as the renderer writes it."""
    total = sum(np.nan_to_num(v, nan=0, posinf=0, neginf=0) for k, v in lights.items() if not k.endswith(("_err", "_E")))
    parts = [("rgb", rgb("", total), {**REC709, **(attrs or {})})]
    parts += [(name, rgb(name, v), {}) for name, v in lights.items()]
    if interleave:
        parts = [(None, {k: v for _, c, _ in parts for k, v in c.items()}, parts[0][2])]
    exrlib.write(path, parts, **options)


def read_bytes(path):
    with open(path, "rb") as file:
        return file.read()


def write_text(path, text):
    with open(path, "w") as file:
        file.write(text)


def read_png(path):
    data = read_bytes(path)
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colour = struct.unpack_from(">IIBB", body)
            assert (depth, colour) == (8, 2), "8-bit RGB"
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 3 * width).astype(int)
    out = np.zeros((height, 3 * width), int)
    for y in range(height):
        kind, row = raw[y, 0], raw[y, 1:]
        up = out[y - 1] if y else np.zeros(3 * width, int)
        for x in range(3 * width):
            left = out[y, x - 3] if x >= 3 else 0
            corner = up[x - 3] if x >= 3 else 0
            paeth = min((left, up[x], corner), key=lambda v: (abs(left + up[x] - corner - v)))
            out[y, x] = (row[x] + (0, left, up[x], (left + up[x]) // 2, paeth)[kind]) % 256
    return out.reshape(height, width, 3)


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="caustics_merge_")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.random = np.random.default_rng(7)

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_merge(self, *words, expect=0, env=None):
        clean = {k: v for k, v in os.environ.items() if k != "OCIO"}
        done = subprocess.run([MERGE, *map(str, words)], capture_output=True, text=True, errors="replace",
                              env={**clean, **(env or {})}, timeout=60)
        self.assertEqual(done.returncode, expect, f"{words}: {done.stderr}")
        if done.returncode:
            lines = [w for w in done.stderr.splitlines() if not w.startswith("caustic-merge: note:")]
            self.assertEqual(len(lines), 1, f"one sentence: {done.stderr}")
        return done

    def refused(self, *words, says, expect=1):
        """Fails with the sentence, and writes nothing."""
        before = set(os.listdir(self.folder))
        done = self.run_merge(*words, expect=expect)
        for part in [says] if isinstance(says, str) else says:
            self.assertIn(part, done.stderr)
        self.assertEqual(before, set(os.listdir(self.folder)))
        return done

    def pixels(self, height=20, width=30):
        return self.random.random((height, width, 3)).astype("<f4")

    def beauty(self, name="beauty.exr", dtype="<f4", height=20, width=30, attrs=REC709, **options):
        """A plain R,G,B file and its pixels."""
        values = self.pixels(height, width).astype(dtype)
        exrlib.write(self.path(name), [(None, rgb("", values, dtype), dict(attrs))], **options)
        return self.path(name), values

    def caustics(self, lights=None, name="caustics.exr", **options):
        lights = lights or {"caustics_key": self.pixels(), "caustics_rim": self.pixels()}
        write_caustics(self.path(name), lights, **options)
        return self.path(name), lights

    def out(self, name="out.exr"):
        return exrlib.read(self.path(name))

    def result(self, name="out.exr", prefix=""):
        channels = self.out(name)[0].channels
        return np.stack([channels[f"{prefix}.{c}" if prefix else c] for c in "RGB"], axis=2)

    def assert_exact(self, got, wanted):
        """`wanted` in double: within one unit in the last place of the stored type."""
        stored = wanted.astype(got.dtype)
        self.assertTrue(np.all(np.abs(got.astype("f8") - wanted) <= np.abs(np.spacing(stored)).astype("f8")))


def int_attr(part, name):
    kind, data = part.attrs[name]
    assert kind == "int"
    return struct.unpack("<i", data)[0]
