# SPDX-License-Identifier: Apache-2.0
"""Small pictures of every kind as a corpus for fuzz.sh, each four times: the last byte says what is done with it.

usage: fuzz_seeds.py FOLDER"""
import itertools
import os
import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests" / "composite"))
import exrlib  # noqa: E402

folder = pathlib.Path(sys.argv[1])
(folder / "corpus").mkdir(parents=True, exist_ok=True)
random = np.random.default_rng(1)


def rgb(prefix, dtype="<f4", size=(9, 12)):
    return {f"{prefix}{c}": random.random(size).astype(dtype) for c in "RGB"}


def seed(name, path):
    data = path.read_bytes()
    for mode in (0, 1, 6, 7):
        (folder / "corpus" / f"{name}_{mode}").write_bytes(data + bytes([mode]))


lights = [("rgb", rgb(""), {"colorInteropID": exrlib.string("lin_rec709_scene")}), ("caustics_a", rgb("caustics_a."), {}),
          ("caustics_a_ind", rgb("caustics_a_ind.", "<f2"), {})]
made = folder / "made.exr"
for codec, decreasing in itertools.product((0, 2, 3), (False, True)):
    beauty = {**rgb("VL.Combined."), **rgb("VL.DiffCol.", "<f2"), "id": np.arange(108, dtype="<u4").reshape(9, 12)}
    exrlib.write(made, [(None, beauty, {"BlenderMultiChannel": exrlib.string("x")})], compression=codec, decreasing=decreasing)
    seed(f"single_{codec}_{decreasing}", made)
    exrlib.write(made, lights, compression=codec, decreasing=decreasing)
    seed(f"lights_{codec}_{decreasing}", made)
exrlib.write(made, [(None, {**rgb("", "<f2"), "A": random.random((9, 12)).astype("<f2")}, {})], window=(-3, 2, 8, 10), display=(0, 0, 19, 19))
seed("windows", made)
views = [(f"VL.Combined-{v}", rgb("VL.Combined."), {"view": exrlib.string(v)}) for v in ("left", "right")]
exrlib.write(made, views)
seed("views", made)
names = b"".join(len(v).to_bytes(4, "little") + v for v in (b"left", b"right"))
exrlib.write(made, [(None, {**rgb(""), **rgb("right."), **rgb("VL.Combined.left.", "<f2")}, {"multiView": ("stringvector", names)})])
seed("several_views", made)
plain = folder / "plain.exr"
exrlib.write(plain, [(None, rgb("", "<f2", (40, 40)), {})], compression=0)
for codec in ("rle", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"):
    subprocess.run(["oiiotool", plain, "--compression", codec, "-o", made], check=True)
    seed(codec, made)
    subprocess.run(["oiiotool", plain, "--tile", "16", "16", "--compression", codec, "-o", made], check=True)
    seed("tiled_" + codec, made)
subprocess.run(["maketx", plain, "--format", "openexr", "--tile", "16", "16", "-o", made], check=True, stdout=subprocess.DEVNULL)
seed("mip", made)
exrlib.write(folder / "beauty.exr", [(None, rgb("", "<f2"), {})])
exrlib.write(folder / "caustics.exr", lights)
for path in (made, plain):
    os.remove(path)
