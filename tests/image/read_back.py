# SPDX-License-Identifier: Apache-2.0
"""Reads what exr_write() wrote with OpenImageIO and compares every value and the header. Exit 77: no OpenImageIO."""
import subprocess
import sys
import tempfile

try:
    import numpy as np
    import OpenImageIO as oiio
except ImportError:
    print("not run: this Python has no numpy or OpenImageIO")
    sys.exit(77)

WIDTH, HEIGHT = 37, 300
NAMES = ["", "caustics_key", "caustics_key_err"]
LETTERS = ["RGB", "RGB", "Y"]


def expected(layer, channel, crop, half):
    x = np.arange(crop, crop + WIDTH)[None, :]
    y = np.arange(crop, crop + HEIGHT)[:, None]
    v = (layer * 100 + channel + x / 64 + y / 8).astype(np.float32)
    if layer == 1:
        flat = v.reshape(-1)
        for index, new in ((0, 0), (4, 0), (8, 65504 if half else 1e6)):
            if index % 3 == channel:
                flat[index // 3] = new
    return v.astype(np.float16).astype(np.float32) if half else v


def read(path):
    """{channel name: plane}, [spec of each part]"""
    planes, specs = {}, []
    file = oiio.ImageInput.open(path)
    assert file, oiio.geterror()
    while file.seek_subimage(len(specs), 0):
        spec = file.spec()
        specs.append(oiio.ImageSpec(spec))
        data = file.read_image(len(specs) - 1, 0, 0, spec.nchannels, "float")
        for i, name in enumerate(spec.channelnames):
            assert name not in planes, name
            planes[name] = data[:, :, i]
    return planes, specs


def check(path, crop, half, parts):
    planes, specs = read(path)
    assert len(specs) == parts, (path, len(specs))
    wanted = [f"{n}.{c}" if n else c for n, letters in zip(NAMES, LETTERS) for c in letters]
    assert sorted(planes) == sorted(wanted), (path, sorted(planes))
    for layer, (name, letters) in enumerate(zip(NAMES, LETTERS)):
        for i, c in enumerate(letters):
            got = planes[f"{name}.{c}" if name else c]
            want = expected(layer, i, crop, half)
            assert np.array_equal(got, want), (path, name, c, np.argwhere(got != want)[:5])
    if parts > 1:
        assert [s.getattribute("oiio:subimagename") for s in specs] == ["rgb"] + NAMES[1:]
    for s in specs:
        assert (s.x, s.y, s.width, s.height) == (crop, crop, WIDTH, HEIGHT)
        assert (s.full_width, s.full_height) == (WIDTH + 2 * crop, HEIGHT + 2 * crop)
        assert s.getattribute("PixelAspectRatio") == 1.5
        assert s.getattribute("compression") == "zip"
    head = specs[0]
    for name, value in {"caustics/layers": "[]", "caustics/complete": 1, "caustics/error": 0.25,
                        "caustics/repaired_nan": 2, "caustics/clamped": 1 if half else 0,
                        "colorInteropID": "lin_rec709_scene"}.items():
        assert head.getattribute(name) == value, (path, name, head.getattribute(name))


with tempfile.TemporaryDirectory() as folder:
    subprocess.run([sys.argv[1], folder], check=True)
    check(folder + "/float.exr", 0, False, 3)
    check(folder + "/half.exr", 0, True, 3)
    check(folder + "/interleaved.exr", 0, False, 1)
    check(folder + "/cropped.exr", 5, False, 3)
    for name in ("float", "interleaved", "cropped"):
        subprocess.run(["exrheader", f"{folder}/{name}.exr"], check=True, stdout=subprocess.DEVNULL)
print("4 files read back, every value equal")
