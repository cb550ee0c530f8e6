# SPDX-License-Identifier: Apache-2.0
"""Files: other codecs and layouts, damaged ones, and an output that is old or new but never half."""
import glob
import os
import random
import resource
import shutil
import signal
import subprocess
import time
import unittest

from support import CORPUS, DATA, MERGE, REC709, Case, np, read_bytes, rgb
import exrlib

try:
    import OpenImageIO as oiio
except ImportError:
    oiio = None
SANITIZED = "CAUSTICS_SANITIZED" in os.environ


def read_any(path):
    """{(part, channel): plane} by OpenImageIO, level 0, in the stored types."""
    file, out, part = oiio.ImageInput.open(path), {}, 0
    assert file, oiio.geterror()
    while file.seek_subimage(part, 0):
        spec = file.spec()
        for i, name in enumerate(spec.channelnames):
            out[part, name] = file.read_image(part, 0, i, i + 1, str(spec.channelformat(i)))
        part += 1
    return out


@unittest.skipUnless(oiio and shutil.which("oiiotool"), "no OpenImageIO and oiiotool to make and read such files")
class Layouts(Case):
    SOURCE = os.path.join(DATA, "d_off_ml_groups_crypto_half.exr")

    def check(self, path, *words, exact=True):
        before = read_any(path)
        light = self.pixels(61, 97)
        caustics, _ = self.caustics({"caustics_key": light})
        done = self.run_merge("add", path, caustics, "-o", self.path("out.exr"), *words)
        after = read_any(self.path("out.exr"))
        self.assertEqual(before.keys(), after.keys())
        for (part, name), plane in before.items():
            if "Combined." in name and name[-1] in "RGB":
                wanted = plane.astype("f8") + light[:, :, "RGB".index(name[-1]), None]
                if exact:
                    self.assertTrue(np.array_equal(after[part, name], wanted.astype(plane.dtype)), name)
                else:
                    self.assertLess(np.abs(after[part, name] - wanted).max(), 1)
            elif exact:
                self.assertTrue(np.array_equal(plane, after[part, name], equal_nan=True), name)
        return done, exrlib.read_headers(read_bytes(self.path("out.exr")))[0]

    def make(self, *words):
        subprocess.run(["oiiotool", self.SOURCE, "--cut", "97x61+120+60", "--origin", "+0+0", "--fullpixels", *words, "-o",
                        self.path("made.exr")], check=True, stdout=subprocess.DEVNULL)
        return self.path("made.exr")

    def test_codecs(self):
        for codec in ("none", "rle", "zips", "zip", "piz"):
            _, parts = self.check(self.make("--compression", codec))
            self.assertEqual(parts[0].attrs["compression"][1][0], ["none", "rle", "zips", "zip", "piz"].index(codec))
        for codec in ("pxr24", "b44", "b44a", "dwaa", "dwab"):
            done, parts = self.check(self.make("--compression", codec))
            self.assertEqual(parts[0].attrs["compression"][1][0], 3, "a lossy beauty is written as zip")
            self.assertIn("written as zip", done.stderr)

    def test_noise_survives_every_codec(self):
        """Chunks that compression cannot make smaller, or only just: an encoder of OpenEXRCore 3.1 damages such."""
        caustics, _ = self.caustics({"caustics_key": self.pixels(70, 90)})
        for random_bits in (2, 6, 9, 12, 16, 20, 24, 31):
            mask = np.uint32((1 << random_bits) - 1 & 0x80ffffff)
            noise = self.random.integers(0, 2**32, (70, 90, 4), dtype="u4") & mask | np.uint32(0x3f000000)
            planes = {**rgb("", noise[:, :, :3].astype("<u4").view("<f4")), "id": noise[:, :, 3].astype("<u4"),
                      "h": (noise[:, :, 0] & 0xbfff).astype("<u2").view("<f2")}
            exrlib.write(self.path("noise.exr"), [(None, planes, REC709)], compression=0)
            for codec in ("none", "rle", "zips", "zip", "piz"):
                self.run_merge("add", self.path("noise.exr"), caustics, "-o", self.path("out.exr"), "--mute", "key",
                               "--compression", codec)
                for (_, name), plane in read_any(self.path("out.exr")).items():
                    self.assertTrue(np.array_equal(plane[:, :, 0], planes[name], equal_nan=True), (codec, random_bits, name))

    def test_compression_overrides(self):
        path = self.make()
        for code, codec in enumerate(["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"]):
            _, parts = self.check(path, "--compression", codec, exact=code < 5)
            self.assertEqual(parts[0].attrs["compression"][1][0], code)

    def test_tiles(self):
        for words in (["--tile", "64", "48"], ["--tile", "7", "100"], ["--tile", "64", "64", "--compression", "dwaa"]):
            _, parts = self.check(self.make(*words))
            self.assertEqual(parts[0].attrs["type"][1], b"tiledimage")

    def test_mip_map(self):
        plain = self.make("--ch", "ViewLayer.Combined.R,ViewLayer.Combined.G,ViewLayer.Combined.B")
        subprocess.run(["maketx", plain, "--format", "openexr", "-o", self.path("mip.exr"), "--nomipmap"], check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["maketx", plain, "--format", "openexr", "-o", self.path("mip.exr")], check=True, stdout=subprocess.DEVNULL)
        done, parts = self.check(self.path("mip.exr"), "--beauty-space", "Linear Rec.709")
        self.assertIn("level 0", done.stderr)
        self.assertEqual(parts[0].attrs["tiles"][1][8], 0)


    def test_deep(self):
        spec = oiio.ImageSpec(30, 20, 5, oiio.FLOAT)
        spec.channelnames, spec.deep = ("R", "G", "B", "A", "Z"), True
        data = oiio.DeepData()
        data.init(600, 5, [oiio.TypeFloat] * 5, list(spec.channelnames))
        for pixel in range(600):
            data.set_samples(pixel, 1)
        file = oiio.ImageOutput.create(self.path("deep.exr"))
        self.assertTrue(file.open(self.path("deep.exr"), spec) and file.write_deep_image(data))
        file.close()
        caustics, _ = self.caustics()
        for words in (["add", self.path("deep.exr"), caustics, "-o", self.path("none.exr")], ["check", self.path("deep.exr")]):
            self.refused(*words, says=["deep.exr", "part 0 is deep", "flatten"])
        self.assertIn("deep", self.run_merge("list", self.path("deep.exr")).stdout)


class Damaged(Case):
    LIMIT_SECONDS, LIMIT_BYTES = (30, None) if SANITIZED else (2, 512 << 20)

    def limited(self, *words):
        def limit():
            if self.LIMIT_BYTES:
                resource.setrlimit(resource.RLIMIT_AS, (self.LIMIT_BYTES, self.LIMIT_BYTES))
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([MERGE, *words], capture_output=True, text=True, errors="replace", preexec_fn=limit, timeout=60)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)  # not the clock: the machine may be busy
        self.assertLess(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, self.LIMIT_SECONDS, words)
        self.assertIn(done.returncode, (0, 1), (words, done.stderr))
        self.assertNotIn("Sanitizer", done.stderr, words)
        self.assertNotIn("runtime error", done.stderr, words)
        return done

    @unittest.skipUnless(os.path.isdir(CORPUS), f"not run: no folder of damaged files at {CORPUS}")
    def test_corpus(self):
        files = sorted(f for f in glob.glob(os.path.join(CORPUS, "*", "*")) if os.path.isfile(f))
        self.assertGreater(len(files), 50)
        caustics, _ = self.caustics({"caustics_key": self.pixels(300, 400)})
        beauty, _ = self.beauty(height=300, width=400)
        for path in files:
            done = self.limited("check", path)
            if done.returncode:
                self.assertIn(os.path.basename(path), done.stderr)
            self.limited("add", path, caustics, "-o", self.path("out.exr"), "--beauty-space", "ACEScg", "--offset", "0,0")
            self.limited("add", beauty, path, "-o", self.path("out.exr"), "--caustics-space", "ACEScg", "--offset", "0,0")

    def test_found_by_fuzzing(self):
        files = sorted(glob.glob(os.path.join(os.path.dirname(DATA), "damaged", "*.exr")))
        self.assertTrue(files)
        caustics, _ = self.caustics()
        for path in files:
            self.assertEqual(self.limited("check", path).returncode, 1)
            self.limited("add", path, caustics, "-o", self.path("out.exr"), "--beauty-space", "ACEScg", "--offset", "0,0")
            self.limited("list", path)
            self.limited("add", path, caustics, "-o", self.path("out.exr"), "--beauty-space", "ACEScg", "--offset", "0,0", "--keep-layers")

    def test_claims_beyond_the_file(self):
        """Headers alone, with sizes that no file of that length can hold."""
        planes = rgb("", self.pixels(4, 4))
        for window in [(0, 0, 65535, 65535), (0, 0, 10**8, 1), (-2**31, 0, 2**31 - 1, 3), (5, 5, 4, 4), (2**30, 0, 2**30 + 9, 3)]:
            exrlib.write(self.path("claims.exr"), [(None, planes, REC709)], window=window)
            self.assertEqual(self.limited("check", self.path("claims.exr")).returncode, 1)

    def test_random_damage(self):
        chance, names = random.Random(5), ["beauty.exr", "caustics.exr"]
        self.beauty()
        self.caustics()
        for name in names:
            whole = read_bytes(self.path(name))
            for _ in range(60):
                data = bytearray(whole)
                for _ in range(chance.choice([1, 2, 8])):
                    data[chance.randrange(4, len(data) if chance.random() < .5 else 900)] = chance.choice([0, 255, 127, chance.randrange(256)])
                if chance.random() < .2:
                    data = data[:chance.randrange(len(data))]
                with open(self.path("bad.exr"), "wb") as file:
                    file.write(data)
                words = [self.path("bad.exr" if n == name else n) for n in names]
                self.limited("add", *words, "-o", self.path("out.exr"))

    def test_odd_things_as_files(self):
        caustics, _ = self.caustics()
        os.mkfifo(self.path("pipe"))
        for odd in ("/dev/zero", "/dev/null", self.folder, self.path("pipe"), __file__):
            done = self.limited("add", odd, caustics, "-o", self.path("out.exr"))
            self.assertEqual(done.returncode, 1)


class Output(Case):
    def big(self):
        """Files that take a moment, and the command that adds them."""
        beauty, _ = self.beauty(height=500, width=600, compression=0)
        caustics, _ = self.caustics({f"caustics_{n}": self.pixels(500, 600) for n in "ab"}, compression=0)
        return [MERGE, "add", beauty, caustics, "-o", self.path("out.exr"), "--quiet", "--compression", "zip"]

    def leftovers(self):
        return [f for f in os.listdir(self.folder) if f.endswith(".tmp")]

    def test_kill_leaves_old_or_new(self):
        words = self.big()
        start = time.monotonic()
        subprocess.run(words, check=True)
        took = time.monotonic() - start
        new = read_bytes(self.path("out.exr"))
        old, chance, seen = b"the old file", random.Random(3), {"old": 0, "new": 0}
        kills = int(os.environ.get("CAUSTICS_KILLS", "20"))
        for k in range(kills):
            with open(self.path("out.exr"), "wb") as file:
                file.write(old)
            process = subprocess.Popen(words)
            time.sleep(took * (k + chance.random()) / kills * 1.1)
            process.kill()
            process.wait()
            now = read_bytes(self.path("out.exr"))
            self.assertIn(now, (old, new))
            seen["old" if now == old else "new"] += 1
            for leftover in self.leftovers():  # a killed program cannot tidy up
                os.remove(self.path(leftover))
        self.assertGreater(seen["old"], kills // 4, "the kills came too late to mean anything")

    def test_interrupt(self):
        words = self.big()
        for number in (signal.SIGINT, signal.SIGTERM):
            with open(self.path("out.exr"), "wb") as file:
                file.write(b"old")
            process = subprocess.Popen(words, stderr=subprocess.PIPE, text=True)
            while not self.leftovers() and process.poll() is None:
                time.sleep(.001)
            process.send_signal(number)
            start = time.monotonic()
            _, text = process.communicate()
            self.assertLess(time.monotonic() - start, 10 if SANITIZED else 1.5)  # .5 on an idle machine
            self.assertEqual((process.returncode, read_bytes(self.path("out.exr"))), (3, b"old"), text)
            self.assertEqual(self.leftovers(), [])

    def test_check_can_be_interrupted(self):
        self.big()
        many = [self.path("caustics.exr")] * 100
        process = subprocess.Popen([MERGE, "check", *many], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        time.sleep(.2)
        process.send_signal(signal.SIGINT)
        process.communicate()
        self.assertEqual(process.returncode, 3)

    def test_symlink_is_replaced(self):
        path, _ = self.beauty()
        caustics, _ = self.caustics()
        with open(self.path("target"), "wb") as file:
            file.write(b"precious")
        os.symlink(self.path("target"), self.path("out.exr"))
        self.run_merge("add", path, caustics, "-o", self.path("out.exr"))
        self.assertFalse(os.path.islink(self.path("out.exr")))
        self.assertEqual(read_bytes(self.path("target")), b"precious")

    def test_cannot_write(self):
        path, _ = self.beauty()
        caustics, _ = self.caustics()
        self.refused("add", path, caustics, "-o", self.path("no/such/folder.exr"), says="cannot write", expect=4)
        self.refused("add", path, caustics, "-o", self.folder, says="folder", expect=4)
        os.mkdir(self.path("closed"), 0o555)
        os.chmod(self.folder, 0o755)
        words = [MERGE, "add", path, caustics, "-o", self.path("closed/out.exr")]
        drop = (lambda: os.setuid(65534)) if os.geteuid() == 0 else None  # nothing is closed to root
        try:
            done = subprocess.run(words, capture_output=True, text=True, preexec_fn=drop)
        except PermissionError:
            self.skipTest("the program lies where only root may start it")
        self.assertEqual((done.returncode, os.listdir(self.path("closed"))), (4, []), done.stderr)
        self.assertIn("cannot write", done.stderr)

    def test_disk_full(self):
        """A limit on the size of files stands for the full disk: write() fails in the middle."""
        words = self.big()
        for extra in ([], ["--compression", "dwaa"], ["--compression", "none"]):
            with open(self.path("out.exr"), "wb") as file:
                file.write(b"old")
            done = subprocess.run(words + extra, capture_output=True, text=True,
                                  preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (300000, 300000)))
            self.assertEqual(done.returncode, 4, done.stderr)
            self.assertIn("cannot write", done.stderr)
            self.assertEqual((read_bytes(self.path("out.exr")), self.leftovers()), (b"old", []))

    def test_same_bytes_twice(self):
        path, _ = self.beauty()
        caustics, _ = self.caustics()
        self.run_merge("add", path, caustics, "-o", self.path("a.exr"))
        self.run_merge("add", path, caustics, "-o", self.path("b.exr"))
        self.assertEqual(read_bytes(self.path("a.exr")), read_bytes(self.path("b.exr")))


if __name__ == "__main__":
    unittest.main()
