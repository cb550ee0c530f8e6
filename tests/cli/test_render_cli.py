#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The command line of caustic-render: exit codes, one-sentence errors, what a cancelled render leaves behind.

usage: test_render_cli.py CAUSTIC_RENDER SCENES_FOLDER"""
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM, SCENES = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
BALL = os.path.join(SCENES, "a_ball.json")


def run(*arguments, timeout=120):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=timeout)


def attribute(path, name):
    """An int attribute of the first part, read from the header's bytes."""
    data = open(path, "rb").read(65536)
    at = data.index(name.encode() + b"\0int\0") + len(name) + 5 + 4
    return int.from_bytes(data[at:at + 4], "little", signed=True)


class Cli(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix="caustics_cli_")
        self.out = os.path.join(self.folder.name, "out.exr")

    def tearDown(self):
        self.folder.cleanup()

    def refused(self, code, *arguments, says=""):
        p = run(*arguments)
        self.assertEqual(p.returncode, code, p.stderr)
        self.assertEqual(len(p.stderr.strip().splitlines()), 1, p.stderr)
        self.assertIn(says, p.stderr)
        self.assertEqual(os.listdir(self.folder.name), [])

    def test_usage(self):
        for arguments, says in [
            ([], "no scene"), ([BALL], "-o"), ([BALL, "-o", "-"], "-o"), ([BALL, BALL, "-o", self.out], "one scene"),
            ([BALL, "-o", self.out, "--photons", "many"], "--photons"), ([BALL, "-o", self.out, "--photons", "-1"], "--photons"),
            ([BALL, "-o", self.out, "--error", "nan"], "--error"), ([BALL, "-o", self.out, "--time", "0"], "--time"),
            ([BALL, "-o", self.out, "--resolution", "480"], "--resolution"), ([BALL, "-o", self.out, "--foton", "3"], "--photons"),
            ([BALL, "-o", self.out, "--layers", "radience"], "radiance"), ([BALL, "-o", self.out, "--type", "int"], "--type"),
            ([BALL, "-o", self.out, "--memory", "3"], "--memory"), ([BALL, "-o", self.out, "--region", "1,2,3"], "--region"),
        ]:
            with self.subTest(arguments=arguments):
                self.refused(2, *arguments, says=says)

    def test_not_yet(self):
        for option in (["--estimator", "D"],):
            with self.subTest(option=option):
                self.refused(1, BALL, "-o", self.out, *option, says="not yet supported")

    def test_bad_input(self):
        self.refused(1, os.path.join(SCENES, "nothing.json"), "-o", self.out, says="nothing.json")
        self.refused(1, BALL, "-o", self.out, "--region", "0,0,9999,10", says="region")

    def test_unwritable(self):
        self.refused(4, BALL, "-o", "/nowhere/out.exr", says="/nowhere/out.exr")
        self.refused(1, BALL, "-o", self.folder.name, says="folder")

    def test_help_fits_a_screen(self):
        lines = run("--help").stdout.splitlines()
        self.assertLessEqual(len(lines), 40)
        self.assertTrue(any("caustic-render still_life.json" in line for line in lines[:4]))

    def test_black_scenes_are_valid(self):
        base = json.load(open(BALL))
        for drop in ("lights", "objects"):
            scene = dict(base, **{drop: []})
            path = os.path.join(self.folder.name, "black.json")
            json.dump(scene, open(path, "w"))
            p = run(path, "-o", self.out, "--photons", "1000", "--resolution", "32x18")
            self.assertEqual(p.returncode, 0, p.stderr)
            self.assertIn("black", p.stderr)
            self.assertEqual(attribute(self.out, "caustics/complete"), 1)

    def test_few_photons(self):
        for photons in ("1", "2", "3"):
            self.assertEqual(run(BALL, "-o", self.out, "--photons", photons, "--resolution", "32x18").returncode, 0)

    def test_cancel(self):
        for sign in (signal.SIGINT, signal.SIGTERM):
            with open(self.out, "wb") as old:
                old.write(b"old")
            p = subprocess.Popen([PROGRAM, BALL, "-o", self.out, "--time", "600"], stderr=subprocess.PIPE, text=True)
            time.sleep(3)
            p.send_signal(sign)
            self.assertEqual(p.wait(60), 3)
            p.stderr.close()
            self.assertEqual(open(self.out, "rb").read(), b"old")
            left = self.out.replace(".exr", ".incomplete.exr")
            self.assertEqual(attribute(left, "caustics/complete"), 0)
            self.assertEqual(sorted(os.listdir(self.folder.name)), ["out.exr", "out.incomplete.exr"])
            os.remove(left)

    def test_limits(self):
        report = os.path.join(self.folder.name, "r.json")
        p = run(BALL, "-o", self.out, "--error", "0.9", "--resolution", "64x36", "--report", report)
        self.assertEqual(p.returncode, 0, p.stderr)
        self.assertLessEqual(json.load(open(report))["error"], 0.9)

    def test_little_is_not_paid_for_with_more(self):
        """A few per cent of error are met by passes of few photons; larger ones follow where they do not."""
        report, out = os.path.join(self.folder.name, "r.json"), {}
        for scene, error, most in (("b_ring", 0.2, 70000), ("a_ball", 0.03, 70000), ("c_water", 0.05, 500000)):
            for threads in ("1", "2"):
                p = run(os.path.join(SCENES, scene + ".json"), "-o", self.out, "--error", str(error), "--effects", "direct",
                        "--resolution", "96x54", "--threads", threads, "--report", report)
                self.assertEqual(p.returncode, 0, p.stderr)
                figures = json.load(open(report))
                self.assertLessEqual(figures["error"], error)
                self.assertLessEqual(figures["photons_per_light"], most)
                out[threads] = open(self.out, "rb").read()
            self.assertEqual(out["1"], out["2"])  # whatever the time

    def test_first_of_two_limits(self):
        """Photons are a limit beside the error, which few meet first; the bytes do not depend on the threads."""
        report, what = os.path.join(self.folder.name, "r.json"), [BALL, "-o", self.out, "--effects", "direct", "--resolution", "64x36"]
        for photons, error, met in ((100000, 0.0001, False), (4000000, 0.1, True)):
            out = []
            for threads in ("1", "2"):
                p = run(*what, "--photons", str(photons), "--error", str(error), "--threads", threads, "--report", report)
                self.assertEqual(p.returncode, 0, p.stderr)
                out.append(open(self.out, "rb").read())
            figures = json.load(open(report))
            self.assertEqual(figures["error"] <= error, met)
            self.assertLessEqual(figures["photons_per_light"], photons)
            self.assertEqual(figures["photons_per_light"] < photons / 10, met)
            self.assertEqual(out[0], out[1])

    def test_no_limit(self):
        """A picture ends where it shows no error."""
        report = os.path.join(self.folder.name, "r.json")
        p = run(BALL, "-o", self.out, "--effects", "direct", "--resolution", "64x36", "--report", report)
        self.assertEqual(p.returncode, 0, p.stderr)
        figures = json.load(open(report))
        self.assertLessEqual(figures["error"], 0.02)
        self.assertLess(figures["photons_per_light"], 1000000)

    def test_time(self):
        """Where there is little, passes are small."""
        report = os.path.join(self.folder.name, "r.json")
        p = run(BALL, "-o", self.out, "--time", "2", "--resolution", "160x90", "--report", report)
        self.assertEqual(p.returncode, 0, p.stderr)
        figures = json.load(open(report))
        self.assertLess(figures["photons_per_light"] / max(figures["passes"], 1), 65536)

    def test_progress(self):
        p = run(BALL, "-o", self.out, "--photons", "20000", "--resolution", "64x36", "--progress", "--quiet")
        self.assertEqual(p.returncode, 0, p.stderr)
        lines = [json.loads(line) for line in p.stderr.splitlines()]  # nothing else beside --quiet
        self.assertEqual(lines[-1]["stage"], "done")
        self.assertGreaterEqual(lines[-1]["photons_per_light"], 20000)
        self.assertEqual({len(line) for line in lines}, {5})


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
