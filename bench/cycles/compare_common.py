# SPDX-License-Identifier: Apache-2.0
"""What the comparisons with Cycles share: running caustic-render, reading EXR, block statistics, tables, pictures.

Needs numpy and OpenImageIO for Python (Debian: python3-numpy python3-openimageio)."""
import json
import math
import os
import subprocess
import sys
import tempfile

try:
    import numpy as np
    import OpenImageIO as oiio
except ImportError:
    print("not run: this Python has no numpy or OpenImageIO")
    sys.exit(77)

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("CAUSTIC_RENDER", os.path.join(SOURCE, "build", "bin", "caustic-render"))
SCENES = os.path.join(SOURCE, "scenes")
BEAUTIES = os.path.join(SOURCE, "tests", "data", "cycles")
REFERENCES = os.path.join(SOURCE, "bench", "cycles", "reference")
RGB = "RGB"


class Picture:
    """The planes of an EXR file, all parts, by channel name."""

    def __init__(self, path):
        self.planes = {}
        file = oiio.ImageInput.open(path)
        if file is None:
            raise OSError(f"{path}: {oiio.geterror()}")
        part = 0
        while file.seek_subimage(part, 0):
            spec = file.spec()
            pixels = file.read_image(part, 0, 0, spec.nchannels, "float")
            for i, name in enumerate(spec.channelnames):
                self.planes[name] = pixels[:, :, i].astype(np.float64)
            part += 1
        file.close()

    def layer(self, name=""):
        """(height, width, 3); the bare R, G, B without a name."""
        return np.stack([self.planes[f"{name}.{c}" if name else c] for c in RGB], axis=-1)

    def layers(self):
        return sorted(n[:-2] for n in self.planes if n.endswith(".R"))


def scene_file(name):
    """Test scenes lie beside their beauties, the others in scenes/."""
    for folder in (BEAUTIES, SCENES):
        path = os.path.join(folder, name + ".json")
        if os.path.exists(path):
            return path
    return None


def render(scene, size, *options):
    """Runs caustic-render at `size` (height, width). Returns the picture and the report."""
    with tempfile.TemporaryDirectory(prefix="caustics_compare_") as folder:
        out, report = os.path.join(folder, "out.exr"), os.path.join(folder, "report.json")
        command = [PROGRAM, scene, "-o", out, "--report", report, "--quiet", "--resolution", f"{size[1]}x{size[0]}"]
        done = subprocess.run(command + [str(o) for o in options], capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(done.stderr.strip() or f"caustic-render: exit code {done.returncode}")
        with open(report, encoding="utf-8") as file:
            return Picture(out), json.load(file)


def render_off(scene, size, spp, seed=0):
    """What Cycles renders with caustics off, by estimator R. Returns the mean and its standard error per pixel."""
    picture, report = render(scene, size, "--estimator", "R", "--layers", "beauty,error", "--seed", seed,
                             "--photons", spp * size[0] * size[1])
    return picture.layer("beauty"), picture.layer("beauty_err"), report


# ---- statistics ----

def blocks(image, n=8):
    """Means over n x n pixels of (height, width, 3), whole blocks only: the rim is left out."""
    h, w = image.shape[0] // n * n, image.shape[1] // n * n
    return image[:h, :w].reshape(h // n, n, w // n, n, -1).mean((1, 3))


def around(image, reach):
    """Means over the square of 2 reach + 1 pixels around each."""
    padded = np.pad(image, ((reach, reach), (reach, reach), (0, 0)), mode="edge")
    n = 2 * reach + 1
    return np.lib.stride_tricks.sliding_window_view(padded, (n, n), axis=(0, 1)).mean((-1, -2))


def block_error(error, n=8):
    """Standard error of block means from the pixels' own, taken as independent."""
    return np.sqrt(blocks(error * error, n)) / n


def mean_error(error):
    """Standard error of the mean of all values; the three channels of a pixel err together."""
    return math.sqrt((error.mean(-1) ** 2).sum()) / (error.shape[0] * error.shape[1])


def chance_outside(reference, error, relative, k):
    """Share of values that chance alone puts outside  relative * reference + k * error  of two equal pictures."""
    with np.errstate(divide="ignore", invalid="ignore"):
        limit = np.where(error > 0, k + relative * np.abs(reference) / error, np.inf)
    return float(np.mean([math.erfc(x / math.sqrt(2)) for x in np.minimum(limit, 40).ravel()]))


def worst_block(difference, reference, error, relative, floor):
    """The block that leaves  relative * reference  by most of its errors; blocks darker than `floor` are left out.
    Returns (row, column), difference, reference, error, all of the mean of the channels; None without any."""
    d, c, e = (x.mean(-1) for x in (difference, reference, error))
    with np.errstate(divide="ignore", invalid="ignore"):
        z = (np.abs(d) - relative * np.abs(c)) / e
    z[~np.isfinite(z) | (c < floor)] = -np.inf
    if not np.isfinite(z).any():
        return None
    at = np.unravel_index(np.argmax(z), z.shape)
    return (int(at[0]), int(at[1])), float(d[at]), float(c[at]), float(e[at])


# ---- tables and pictures ----

def write_table(path, columns, rows):
    os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        for row in [columns] + rows:
            file.write("\t".join(str(x) for x in row) + "\n")


def markdown(columns, rows):
    lines = [columns, ["---"] * len(columns)] + rows
    return "".join("| " + " | ".join(str(x) for x in row) + " |\n" for row in lines)


def put_into_page(page, name, text):
    """Replaces what stands between <!-- name --> and <!-- end of name --> of a Markdown page."""
    begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    with open(page, encoding="utf-8") as file:
        before, rest = file.read().split(begin)
    with open(page, "w", encoding="utf-8") as file:
        file.write(before + begin + text + rest[rest.index(end):])


def write_png(path, image, exposure=1.0):
    """Linear Rec.709 through the sRGB curve."""
    x = np.clip(np.nan_to_num(image * exposure), 0, 1)
    x = np.where(x <= .0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - .055)
    pixels = np.ascontiguousarray((x * 255 + .5).astype(np.uint8))
    os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    out = oiio.ImageOutput.create(path)
    if not out.open(path, oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 3, oiio.UINT8)):
        raise OSError(out.geterror())
    out.write_image(pixels)
    out.close()


def magnify(image, factor):
    """Every pixel as factor x factor."""
    return np.repeat(np.repeat(image, factor, 0), factor, 1)


def side_by_side(images, gap=4):
    bar = np.ones((images[0].shape[0], gap, 3))
    row = [images[0]]
    for image in images[1:]:
        row += [bar, image]
    return np.concatenate(row, 1)
