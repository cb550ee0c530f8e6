# SPDX-License-Identifier: Apache-2.0
"""Random cases of caustic-merge add against numpy: every pixel within the contract's precision, everything else bit for bit.

usage: random_cases.py [--count N] [--seed S]   (CAUSTIC_MERGE names the program)"""
import argparse
import os
import struct
import subprocess
import sys
import tempfile

from support import MERGE, matrix, np, rgb, write_caustics
import exrlib

try:
    import OpenImageIO as oiio
except ImportError:
    oiio = None

IDS = {"lin_rec709_scene": "rec709", "lin_ap1_scene": "ap1", "lin_ap0_scene": "ap0", "lin_p3d65_scene": "p3",
       "lin_rec2020_scene": "rec2020"}
XY = {"ap1": (.713, .293, .165, .83, .128, .044, .32168, .33767), "rec709": (.64, .33, .3, .6, .15, .06, .3127, .329),
      "p3": (.68, .32, .265, .69, .15, .06, .3127, .329), "rec2020": (.708, .292, .17, .797, .131, .046, .3127, .329)}
OURS = {"caustics/repaired_nan", "caustics/clamped", "caustics/merge"}
COLOUR = {"colorInteropID", "chromaticities", "acesImageContainerFlag"}
KINDS = ["rgb", "rgba", "multilayer", "multipart", "tiled", "codec"]


class Case:
    def __init__(self, seed, folder):
        self.random, self.folder = np.random.default_rng(seed), folder
        r = self.random
        self.kind = str(r.choice(KINDS if oiio else KINDS[:4]))
        self.height, self.width = int(r.integers(3, 70)), int(r.integers(3, 60))
        self.dtype = str(r.choice(["<f2", "<f4"]))
        self.space = str(r.choice(list(IDS)))
        self.light_space = "lin_rec709_scene" if r.random() < .6 else str(r.choice(list(IDS)))
        self.words, self.decode_only = [], False

    def path(self, name):
        return os.path.join(self.folder, name)

    def pixels(self, dtype, odd=True):
        p = (self.random.random((self.height, self.width, 3)) ** 4 * self.random.choice([1e-3, 1, 300])).astype(dtype)
        if odd and self.random.random() < .3:  # NaN, -0, infinity pass through
            p[self.random.integers(self.height), self.random.integers(self.width)] = [np.nan, -0., np.inf]
        return p

    def windows(self):
        """The beauty's data window, the display window, the caustics' data window."""
        r, w, h = self.random, self.width, self.height
        x, y = (int(v) for v in r.integers(-9, 9, 2)) if r.random() < .5 else (0, 0)
        self.window = (x, y, x + w - 1, y + h - 1)
        self.display = self.window if r.random() < .5 else (0, 0, w + 7, h + 5)
        a, b, c, d = (int(v) for v in r.integers(-6, 7, 4)) if r.random() < .6 else (0, 0, 0, 0)
        x0, y0 = x + a, y + b
        self.light_window = (x0, y0, max(x0, x + w - 1 + c), max(y0, y + h - 1 + d))
        if self.light_window[2] < x or x0 > x + w - 1 or self.light_window[3] < y or y0 > y + h - 1:
            self.light_window = self.window

    def tags(self):
        how = self.random.choice(["id", "chromaticities", "flag", "said"])
        name = IDS[self.space]
        if how == "chromaticities" and name in XY:
            return {"chromaticities": ("chromaticities", struct.pack("<8f", *XY[name]))}
        if how == "flag" and name == "ap0":
            return {"acesImageContainerFlag": exrlib.integer(1)}
        if how == "said":
            self.words += ["--beauty-space", self.space]
            return {}
        return {"colorInteropID": exrlib.string(self.space.upper() if self.random.random() < .2 else self.space)}

    def parts(self, attrs):
        r, prefix = self.random, ""
        attrs = {**attrs, "note": exrlib.string("keep me"), "frame": exrlib.integer(7), "odd": ("strange", bytes(range(9)))}
        if self.kind in ("rgb", "tiled"):
            return [(None, rgb("", self.pixels(self.dtype), self.dtype), attrs)], ""
        if self.kind == "rgba":
            return [(None, {**rgb("", self.pixels(self.dtype), self.dtype), "A": self.pixels("<f2")[:, :, 0]}, attrs)], ""
        prefix = "ViewLayer.Combined"
        colour = {**rgb(prefix, self.pixels(self.dtype, self.kind != "codec"), self.dtype)}
        extra = {**rgb("ViewLayer.DiffDir", self.pixels(self.dtype, self.kind != "codec"), self.dtype),
                 "ViewLayer.Combined.A": self.pixels(self.dtype, False)[:, :, 0]}
        if self.kind == "codec":
            return [(None, {**colour, **extra}, attrs)], prefix
        ids = r.integers(0, 2**32, (self.height, self.width), dtype="u4")
        crypto = {f"ViewLayer.CryptoObject00.{c}": (ids ^ i).view("<f4") for i, c in enumerate("rgba")}
        depth = {"ViewLayer.Depth.Z": self.pixels("<f4")[:, :, 0], "ViewLayer.IndexOB.X": ids}
        if self.kind == "multilayer":
            return [(None, {**colour, **extra, **crypto, **depth}, attrs)], prefix
        alpha = {"ViewLayer.Combined.A": extra.pop("ViewLayer.Combined.A")}
        order = [("ViewLayer.Combined", {**colour, **alpha}), ("ViewLayer.DiffDir", extra), ("crypto", crypto), ("depth", depth)]
        if r.random() < .5:
            order = [order[i] for i in r.permutation(4)]
        return [(n, p, attrs if i == 0 else {"layer": exrlib.integer(i)}) for i, (n, p) in enumerate(order)], prefix

    def write_beauty(self):
        parts, prefix = self.parts(self.tags())
        options = dict(window=self.window, display=self.display, compression=int(self.random.choice([0, 2, 3])))
        if self.kind not in ("tiled", "codec"):
            options["decreasing"] = bool(self.random.random() < .2)
        exrlib.write(self.path("beauty.exr"), parts, **options)
        if self.kind in ("tiled", "codec"):
            if self.kind == "tiled":
                words = ["--tile", str(self.random.choice([16, 32])), str(self.random.choice([16, 32, 64]))]
                words += ["--compression", str(self.random.choice(["none", "zip", "rle", "piz"]))]
            else:
                words = ["--compression", str(self.random.choice(["rle", "piz", "pxr24", "b44", "dwaa", "dwab"]))]
            if self.kind == "codec" and self.random.random() < .3:
                self.words += ["--compression", str(self.random.choice(["none", "zips", "piz", "rle"]))]
            subprocess.run(["oiiotool", self.path("beauty.exr"), *words, "-o", self.path("b2.exr")], check=True,
                           stdout=subprocess.DEVNULL)
            os.replace(self.path("b2.exr"), self.path("beauty.exr"))
            self.decode_only = True
        return prefix

    def write_lights(self):
        r = self.random
        self.lights, (x0, y0, x1, y1) = {}, self.light_window
        own = self.height, self.width
        self.height, self.width = y1 - y0 + 1, x1 - x0 + 1
        dtype = str(r.choice(["<f2", "<f4"]))
        for name in ["key", "rim", "Sun 2", "fill"][:int(r.integers(1, 5))]:
            base = "caustics_" + name.replace(" ", "_")
            self.lights[base] = self.pixels(dtype)
            if r.random() < .4:
                self.lights[base + "_ind"] = self.pixels(dtype, False)
        self.height, self.width = own
        write_caustics(self.path("caustics.exr"), {k: v.astype("<f4") for k, v in self.lights.items()},
                       attrs={"colorInteropID": exrlib.string(self.light_space)}, interleave=bool(r.random() < .3),
                       window=self.light_window, display=self.display, compression=int(r.choice([0, 2, 3])))

    def settings(self):
        """Words for the program, and the factor of every layer (None: not heard)."""
        r, factors = self.random, {}
        lights = [n for n in self.lights if not n.endswith("_ind")]
        muted = {n for n in lights if r.random() < .15}
        solo = {n for n in lights if r.random() < .12}
        for n in lights:
            gain, ev, tint = 1., 0., np.ones(3)
            short = n.removeprefix("caustics_")
            if r.random() < .5:
                gain = round(float(r.choice([0, -1, .3, 2.5])), 3)
                self.words += ["--gain", f"{short}={gain}"]
            if r.random() < .4:
                ev = round(float(r.uniform(-4, 4)), 2)
                self.words += ["--ev", f"{n}={ev}"]
            if r.random() < .4:
                tint = np.round(r.uniform(0, 2, 3), 3)
                self.words += ["--tint", f"{short}={','.join(map(str, tint))}"]
            self.words += ["--mute", short] if n in muted else []
            self.words += ["--solo", short] if n in solo else []
            heard = n not in muted and (not solo or n in solo)
            for layer in (n, n + "_ind"):
                factors[layer] = gain * 2.**ev * tint if heard else None
        return factors

    def added(self, factors):
        """What is added to every pixel of the beauty's window, in double."""
        total = np.zeros((self.height, self.width, 3))
        m = matrix(IDS[self.light_space], IDS[self.space])
        (bx, by, bx1, by1), (x0, y0, x1, y1) = self.window, self.light_window
        ax, ay, cx, cy = max(bx, x0), max(by, y0), min(bx1, x1), min(by1, y1)
        nan = 0
        for name, light in self.lights.items():
            if factors[name] is None or not np.any(factors[name]):
                continue
            part = light[ay - y0:cy - y0 + 1, ax - x0:cx - x0 + 1].astype("f8")
            bad = ~np.isfinite(part)
            nan += int(bad.sum())
            part = np.where(bad, 0, part)
            converted = part if self.space == self.light_space else part @ m.T
            total[ay - by:cy - by + 1, ax - bx:cx - bx + 1] += converted * factors[name]
        return total, nan

    def read(self, name):
        """[(attributes, channels)] of all parts; with other codecs than ours the pixels by OpenImageIO."""
        if not self.decode_only:
            return [(p.attrs, p.channels) for p in exrlib.read(self.path(name))]
        with open(self.path(name), "rb") as file:
            headers = exrlib.read_headers(file.read())[0]
        file, out = oiio.ImageInput.open(self.path(name)), []
        for i, part in enumerate(headers):
            file.seek_subimage(i, 0)
            spec = file.spec()
            out.append((part.attrs, {n: file.read_image(i, 0, k, k + 1, str(spec.channelformat(k)))[:, :, 0]
                                     for k, n in enumerate(spec.channelnames)}))
        return out

    def compare(self, prefix, factors):
        before, after = self.read("beauty.exr"), self.read("out.exr")
        assert len(before) == len(after), "number of parts"
        added, nan = self.added(factors)
        target = {f"{prefix}.{c}" if prefix else c: i for i, c in enumerate("RGB")}
        clamped = 0
        for (old_attrs, old), (new_attrs, new) in zip(before, after):
            assert list(old) == list(new), "channels"
            for name, plane in old.items():
                assert plane.dtype == new[name].dtype, f"type of {name}"
                if name in target:
                    clamped += self.compare_plane(name, plane, new[name], added[:, :, target[name]])
                else:
                    assert np.array_equal(exrlib.bits(plane), exrlib.bits(new[name])), f"{name} changed"
            for name, value in old_attrs.items():
                free = OURS | COLOUR | ({"compression", "chunkCount"} if self.decode_only else set())
                assert name in free or new_attrs.get(name) == value, f"attribute {name}"
        first = after[0][0]
        assert struct.unpack("<i", first["caustics/repaired_nan"][1])[0] == nan, "count of NaN"
        assert struct.unpack("<i", first["caustics/clamped"][1])[0] == clamped, "count of clamped values"

    def compare_plane(self, name, old, new, added):
        old8 = old.astype("f8")
        exact = old8 + added
        largest = 65504. if old.dtype.itemsize == 2 else float(np.finfo("f4").max)
        untouched = (added == 0) | ~np.isfinite(old8)
        same = exrlib.bits(old) == exrlib.bits(new)
        assert np.all(same[untouched]), f"{name}: a sample that nothing was added to changed"
        over = ~untouched & (np.abs(exact) > largest)
        wanted = np.where(over, np.copysign(largest, exact), exact)[~untouched]
        got = new.astype("f8")[~untouched]
        ulp = np.spacing(np.abs(wanted).astype(old.dtype)).astype("f8")
        limit = ulp if self.space == self.light_space else 5e-6 * np.abs(wanted) + 5e-6 * np.abs(old8[~untouched]) + ulp
        error = np.abs(got - wanted)
        assert np.all(error <= limit), f"{name}: off by {float(np.max(error / limit))} of the limit"
        return int(over.sum())

    def run(self):
        self.windows()
        prefix = self.write_beauty()
        self.write_lights()
        factors = self.settings()
        words = [MERGE, "add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("out.exr"), *self.words]
        done = subprocess.run(words, capture_output=True, text=True, env={k: v for k, v in os.environ.items() if k != "OCIO"})
        assert done.returncode == 0, done.stderr
        self.compare(prefix, factors)
        for n in self.lights:  # gain 0 is the identity
            words += ["--gain", f"{n}=0"]
        subprocess.run(words, check=True, capture_output=True)
        for (_, old), (_, new) in zip(self.read("beauty.exr"), self.read("out.exr")):
            for name, plane in old.items():
                assert np.array_equal(exrlib.bits(plane), exrlib.bits(new[name])), f"gain 0 changed {name}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    failed, kinds = 0, {}
    for seed in range(arguments.seed, arguments.seed + arguments.count):
        with tempfile.TemporaryDirectory(prefix="caustics_random_") as folder:
            case = Case(seed, folder)
            kinds[case.kind] = kinds.get(case.kind, 0) + 1
            try:
                case.run()
            except AssertionError as problem:
                failed += 1
                print(f"seed {seed}: {case.kind}, {case.dtype}, {case.space} <- {case.light_space}, {case.words}: {problem}")
    print(f"{arguments.count} cases ({', '.join(f'{v} {k}' for k, v in sorted(kinds.items()))}): {failed} failed")
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
