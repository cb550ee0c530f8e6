# SPDX-License-Identifier: Apache-2.0
"""The pictures of speed.py, and the names of the beauty's channels on standard output. In a program of its own: the peak
memory of a child counts from its parent's.

usage: speed_files.py BEAUTY.exr CAUSTICS.exr WIDTH HEIGHT PASSES LIGHTS"""
import pathlib
import sys

import numpy as np
import OpenImageIO as oiio

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests" / "composite"))
import exrlib  # noqa: E402

PASSES = ["Combined", "DiffDir", "DiffInd", "DiffCol", "GlossDir", "GlossInd", "GlossCol", "TransDir", "TransInd", "Emit", "Env", "Shadow"]


def beauty(path, width, height, passes, noise):
    """Half, ZIP, one part, as Blender 4 writes it: smooth shading with the noise of a render."""
    random = np.random.default_rng(1)
    y, x = np.mgrid[0:height, 0:width].astype("f4")
    names, planes = [], []
    for k, name in enumerate([f"{p}.{c}" for p in passes for c in "RGB"] + ["Combined.A", "AO.R", "AO.G", "AO.B"]):
        smooth = .5 + .4 * np.sin(x / (200 + 17 * k)) * np.cos(y / (150 + 11 * k))
        planes.append((smooth * (1 + noise * random.standard_normal((height, width), "f4"))).astype("f2"))
        names.append("ViewLayer." + name)
    spec = oiio.ImageSpec(width, height, len(names), oiio.HALF)
    spec.channelnames = names
    spec.attribute("compression", "zip")
    spec.attribute("colorInteropID", "lin_rec709_scene")
    out = oiio.ImageOutput.create(str(path))
    out.open(str(path), spec)
    out.write_image(np.stack(planes, 2))
    out.close()
    return names


def caustics(path, width, height, lights):
    """Float, ZIP, a part per light: bright webs on black, as lights through glass and water leave them."""
    random = np.random.default_rng(2)
    y, x = np.mgrid[0:height, 0:width].astype("f4")
    layers = {}
    for i, name in enumerate(lights):
        web = np.maximum(0, np.sin(x / (300 + 40 * i) + i) * np.cos(y / (250 + 30 * i))) ** 2
        layers[f"caustics_{name}"] = np.stack([web * (1 + .05 * random.standard_normal((height, width), "f4")) for _ in "RGB"], 2)
    parts = [("rgb", {c: sum(layers.values())[:, :, i] for i, c in enumerate("RGB")}, {"colorInteropID": exrlib.string("lin_rec709_scene")})]
    parts += [(n, {f"{n}.{c}": v[:, :, i] for i, c in enumerate("RGB")}, {}) for n, v in layers.items()]
    exrlib.write(str(path), parts)


def main():
    size, passes, lights = [int(v) for v in sys.argv[3:5]], int(sys.argv[5]), int(sys.argv[6])
    beauty(sys.argv[1], *size, PASSES[:passes], .02)
    caustics(sys.argv[2], *size, ["key", "rim", "fill", "sun"][:lights])
    print("\n".join(oiio.ImageInput.open(sys.argv[1]).spec().channelnames))


if __name__ == "__main__":
    main()
