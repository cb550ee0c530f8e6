#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checkpoints, resuming, shards: the bytes are those of one uninterrupted render, or there is an error in one sentence.

usage: test_long_renders.py CAUSTIC_RENDER CAUSTIC_MERGE SCENES_FOLDER"""
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM, MERGE, SCENES = (os.path.abspath(a) for a in sys.argv[1:4])
BALL = os.path.join(SCENES, "a_ball.json")
SMALL = ["--resolution", "64x36", "--quiet"]


def run(*arguments, timeout=300):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=timeout)


def content(path):
    with open(path, "rb") as f:
        return f.read()


class LongRenders(unittest.TestCase):
    def setUp(self):
        self.scenes = tempfile.TemporaryDirectory(prefix="caustics_long_scenes_")
        self.folder = tempfile.TemporaryDirectory(prefix="caustics_long_")
        self.one, self.out, self.state = (os.path.join(self.folder.name, n) for n in ("one.exr", "out.exr", "state"))

        with open(BALL) as f:
            scene = json.load(f)
        scene["lights"].append({"name": "Lamp", "type": "point", "power_w": 200, "radius_m": 0.02,
                                "look": {"from": [-2, -1, 3], "to": [0, 0, 0]}})
        self.two_lights = self.write_scene("two.json", scene)
        scene["camera"]["hfov_deg"] = 41
        self.other = self.write_scene("other.json", scene)

    def write_scene(self, name, scene):
        path = os.path.join(self.scenes.name, name)
        with open(path, "w") as f:
            json.dump(scene, f)
        return path

    def tearDown(self):
        self.folder.cleanup()
        self.scenes.cleanup()

    def good(self, *arguments):
        p = run(*arguments)
        self.assertEqual(p.returncode, 0, p.stderr)
        return p

    def refused(self, code, *arguments, says):
        p = run(*arguments)
        self.assertEqual(p.returncode, code, p.stderr)
        self.assertEqual(len(p.stderr.strip().splitlines()), 1, p.stderr)
        for words in [says] if isinstance(says, str) else says:
            self.assertIn(words, p.stderr)

    def stopped(self, number, seconds, *arguments):
        """Starts, sends the signal, returns the exit code."""
        p = subprocess.Popen([PROGRAM, *arguments], stderr=subprocess.DEVNULL)
        time.sleep(seconds)
        p.send_signal(number)
        return p.wait()

    def states(self, count, *arguments):
        names = [f"{self.state}{i}" for i in range(1, count + 1)]
        for i, name in enumerate(names, 1):
            self.good(*arguments, "--shard", f"{i}/{count}", "--checkpoint", name, "--threads", str([1, 2, 7][i % 3]))
        return names

    def test_shards(self):
        """By photons, wavefronts, both as the plan has it, and the reference; two lamps, all layers."""
        layers = "radiance,indirect,irradiance,error"
        for scene, estimator, photons in [(BALL, "P", "20000"), (BALL, "W", "20000"), (self.two_lights, "auto", "20000"),
                                          (self.two_lights, "R", "30000")]:
            with self.subTest(scene=scene, estimator=estimator):
                what = [scene, *SMALL, "--estimator", estimator, "--photons", photons, "--layers",
                        "radiance,error,beauty" if estimator == "R" else layers]
                self.good(*what, "-o", self.one)
                names = self.states(4, *what)
                random.Random(1).shuffle(names)
                self.good(*what, "-o", self.out, "--join", *names)
                self.assertEqual(content(self.one), content(self.out))

    def test_shard_pictures(self):
        """The pictures of shards say what they are, and the compositor joins them."""
        what = [BALL, *SMALL, "--photons", "40000", "--estimator", "P"]
        names = [os.path.join(self.folder.name, f"{i}.exr") for i in (1, 2)]
        for i, name in enumerate(names, 1):
            self.good(*what, "--shard", f"{i}/2", "-o", name)
            self.assertIn(f"{i}/2".encode(), content(name)[:4096])
        self.assertNotEqual(content(names[0]), content(names[1]))
        self.good(*what, "-o", self.one)
        self.assertNotIn(b"caustics/shard", content(self.one)[:4096])
        p = subprocess.run([MERGE, "shards", *names, "-o", self.out], capture_output=True, text=True, timeout=60)
        self.assertEqual(p.returncode, 0, p.stdout + p.stderr)

    def test_resume_after_kill(self):
        what = [self.two_lights, *SMALL, "--photons", "200000", "--layers", "irradiance,error"]
        self.good(*what, "-o", self.one)
        often = [*what, "-o", self.out, "--checkpoint", self.state, "--checkpoint-every", "0", "--resume"]
        for seconds in (0.2, 0.5, 0.8):
            code = self.stopped(signal.SIGKILL, seconds, *often)
            self.assertIn(code, (0, -signal.SIGKILL))
        self.good(*often, "--threads", "7")
        self.assertEqual(content(self.one), content(self.out))
        at = os.stat(self.out).st_mtime_ns
        self.good(*often)  # once more: nothing is left to render
        self.assertGreater(os.stat(self.out).st_mtime_ns, at)
        self.assertEqual(content(self.one), content(self.out))
        self.assertEqual([n for n in os.listdir(self.folder.name) if n not in ("one.exr", "out.exr", "state")
                          and not n.endswith(".tmp")], [])

    def test_resume_within_a_pass(self):
        """SIGINT stops within a pass: some layers have it already, and must not get it again."""
        for estimator in ("P", "W", "R"):
            with self.subTest(estimator=estimator):
                what = [self.two_lights, *SMALL, "--photons", "100000", "--estimator", estimator]
                self.good(*what, "-o", self.one)
                for seconds in (0.3, 0.4, 0.5, 0.6):
                    code = self.stopped(signal.SIGINT, seconds, *what, "-o", self.out, "--checkpoint", self.state, "--resume")
                    self.assertIn(code, (0, 3, -signal.SIGINT))
                self.good(*what, "-o", self.out, "--checkpoint", self.state, "--resume", "--threads", "1")
                self.assertEqual(content(self.one), content(self.out))
                os.unlink(self.state)

    def test_resume_around_a_trial(self):
        """To a small error a ball's photons are given up for wavefronts, when these have been tried; whatever stops a render there."""
        what = [BALL, "--resolution", "32x18", "--quiet", "--effects", "direct", "--error", "0.008"]
        report = os.path.join(self.folder.name, "report.json")
        self.good(*what, "-o", self.one, "--threads", "1", "--report", report)
        with open(report) as f:
            figures = json.load(f)
        self.assertIn("direct caustics by photons", figures["plan"])
        self.assertEqual(figures["lights"][0]["estimator_direct"], "W")
        self.assertLessEqual(figures["error"], 0.008)
        for seconds in (0.5, 0.4, 0.5):
            code = self.stopped(signal.SIGINT, seconds, *what, "-o", self.out, "--checkpoint", self.state, "--resume")
            self.assertIn(code, (0, 3, -signal.SIGINT))
        self.good(*what, "-o", self.out, "--checkpoint", self.state, "--resume", "--threads", "2")
        self.assertEqual(content(self.one), content(self.out))

    def test_photons_are_shared_out(self):
        """What a ball's light does on its way between walls is little beside its caustic, and has fewer photons in a second round, however often it is stopped."""
        what = [BALL, "--resolution", "48x27", "--quiet", "--effects", "direct,indirect", "--estimator", "P", "--error", "0.012"]
        report = os.path.join(self.folder.name, "report.json")
        self.good(*what, "-o", self.one, "--threads", "1", "--report", report)
        with open(report) as f:
            light = json.load(f)["lights"][0]
        self.assertLess(light["flux_indirect"]["photons"], 0.5 * light["flux_direct"]["photons"])
        for seconds in (0.4, 0.5, 0.6):
            code = self.stopped(signal.SIGINT, seconds, *what, "-o", self.out, "--checkpoint", self.state, "--resume")
            self.assertIn(code, (0, 3, -signal.SIGINT))
        for _ in range(2):  # the second time it is finished, and knows its shares whenever it was stopped
            self.good(*what, "-o", self.out, "--checkpoint", self.state, "--resume", "--threads", "2")
            self.assertEqual(content(self.one), content(self.out))

    def test_finished_by_error(self):
        """A state that met its error leaves nothing to do; a smaller one goes on."""
        what = [BALL, "--resolution", "32x18", "--quiet", "--effects", "direct", "--checkpoint", self.state, "--resume"]
        self.good(*what, "-o", self.one, "--error", "0.05")
        self.good(*what, "-o", self.out, "--error", "0.05")
        self.assertEqual(content(self.one), content(self.out))
        self.good(*what, "-o", self.out, "--error", "0.02", "--photons", "1000000")
        self.assertNotEqual(content(self.one), content(self.out))

    def test_resume_of_a_shard(self):
        what = [self.two_lights, *SMALL, "--photons", "100000", "--estimator", "P"]
        self.good(*what, "-o", self.one)
        names = self.states(2, *what)
        os.unlink(names[1])
        for seconds in (0.3, 0.6):
            self.stopped(signal.SIGTERM, seconds, *what, "--shard", "2/2", "--checkpoint", names[1], "--resume")
        self.good(*what, "--shard", "2/2", "--checkpoint", names[1], "--resume")
        self.good(*what, "-o", self.out, "--join", *names)
        self.assertEqual(content(self.one), content(self.out))

    def test_without_a_state(self):
        p = self.good(BALL, "--resolution", "64x36", "--photons", "9000", "-o", self.out, "--checkpoint", self.state, "--resume")
        self.assertIn("starts anew", p.stderr)
        self.assertTrue(os.path.exists(self.state))

    def test_mismatch(self):
        base = {"--photons": "9000", "--seed": "1", "--resolution": "32x18", "--estimator": "P", "--layers": "radiance",
                "--effects": "direct", "--memory": "1G", "--region": "0,0,32,18"}

        def words(options):
            return ["--quiet", "--checkpoint", self.state, "-o", self.out] + [w for o in options.items() for w in o]

        self.good(BALL, *words(base))
        before = content(self.state)
        for option, value, says in [
                ("--photons", "9001", ["photons", "9000", "9001"]), ("--seed", "2", ["seed", "is 1 there and 2 here"]),
                ("--resolution", "34x20", ["resolution", "32x18", "34x20"]), ("--estimator", "W", ["estimator is P there and W here"]),
                ("--layers", "error", ["layers"]), ("--effects", "indirect", ["indirect effects is off there and on here"]),
                ("--memory", "2G", ["memory"]), ("--region", "0,0,16,16", ["region", "0,0,16,16"])]:
            with self.subTest(option=option):
                self.refused(1, BALL, *words({**base, option: value}), "--resume", says=[self.state, *says])
        self.refused(1, self.other, *words(base), "--resume", says=[self.state, "scene hash"])
        self.refused(1, BALL, *words(base), "--resume", "--physical", says=["physical is 0 there and 1 here"])
        self.refused(1, BALL, *words(base), "--resume", "--shard", "1/2", says=["shard is 0/0 there and 1/2 here"])
        self.assertEqual(content(self.state), before)

    def test_damaged(self):
        what = [BALL, "--resolution", "16x9", "--photons", "9000", "--estimator", "P", "--quiet"]
        resume = [*what, "-o", self.out, "--checkpoint", self.state, "--resume"]
        self.good(*resume)
        whole = content(self.state)
        dice = random.Random(7)
        cases = [whole[:n] for n in (0, 1, 7, 8, 20, 24, 100, len(whole) // 2, len(whole) - 8, len(whole) - 1)]
        cases += [whole + b"x", bytes(len(whole)), b"\xff" * len(whole), whole[:16] + b"\xff" * 8 + whole[24:],
                  whole[:24] + b"%n%s" * 99 + whole[24 + 396:]]
        for _ in range(20):
            at = dice.randrange(len(whole))
            cases.append(whole[:at] + bytes([whole[at] ^ 1 << dice.randrange(8)]) + whole[at + 1:])
        os.unlink(self.out)
        for i, data in enumerate(cases):
            with self.subTest(case=i):
                with open(self.state, "wb") as f:
                    f.write(data)
                self.refused(1, *resume, says=self.state)
                self.assertEqual(content(self.state), data)  # never overwritten in silence
                self.assertFalse(os.path.exists(self.out))
        os.unlink(self.state)
        os.mkdir(self.state)
        self.refused(1, *resume, says=self.state)

    def test_join_refuses(self):
        what = [BALL, "--resolution", "32x18", "--photons", "9000", "--estimator", "P", "--quiet"]
        names = self.states(3, *what)
        join = [*what, "-o", self.out, "--join"]
        self.refused(1, *join, *names[:2], says="shard 3 of 3 is missing")
        self.refused(1, *join, names[0], names[1], names[1], says="shard 2 again")
        self.refused(1, *join, *names[:2], self.state, says=self.state)
        self.good(*what, "--shard", "1/2", "--checkpoint", self.state)
        self.refused(1, *join, names[0], self.state, says="shard 1 of 2, but the others are of 3")
        self.good(*what, "--checkpoint", self.state, "-o", self.out)
        os.unlink(self.out)
        self.refused(1, *join, self.state, says="is not the state of a shard")
        self.refused(1, *what[:-2], "W", "--quiet", "-o", self.out, "--join", *names, says=["estimator", "P", "W"])
        self.assertFalse(os.path.exists(self.out))

    def test_frames(self):
        """Each frame has the bytes it would have alone; broken ones are told, the others are done; --resume skips by content."""
        with open(BALL) as f:
            scene = json.load(f)
        for frame in (1, 3, 5):
            scene["lights"][0]["strength"] = frame
            self.write_scene(f"shot.{frame:04d}.json", scene)
        shot, out = os.path.join(self.scenes.name, "shot.####.json"), os.path.join(self.folder.name, "out.%04d.exr")
        what = ["--photons", "9000", "--estimator", "P", *SMALL]
        self.good(shot, *what, "-o", out, "--frames", "1-5x2", "--report", os.path.join(self.folder.name, "r.####.json"))
        self.assertEqual(sorted(os.listdir(self.folder.name)),
                         [f"out.{i:04d}.exr" for i in (1, 3, 5)] + [f"r.{i:04d}.json" for i in (1, 3, 5)])
        written = {i: content(out % i) for i in (1, 3, 5)}
        self.assertEqual(len(set(written.values())), 3)
        scene["lights"][0]["strength"] = 3
        alone = self.write_scene("alone.json", scene)
        self.good(alone, *what, "-o", out, "--frames", "3", "--threads", "2")
        self.assertEqual(content(out % 3), written[3])
        # Frame 2 is missing, 4 is broken, 1 is done, 3 is of other contents, 5 was stopped.
        with open(os.path.join(self.scenes.name, "shot.0004.json"), "w") as f:
            f.write("{")
        scene["lights"][0]["strength"] = 7
        self.write_scene("shot.0003.json", scene)
        os.unlink(out % 5)
        before = {i: os.stat(out % i).st_mtime_ns for i in (1, 3)}
        p = run(shot, *what, "-o", out, "--frames", "1-5", "--resume")
        self.assertEqual(p.returncode, 1, p.stderr)
        for says in ("frame 2 failed", "frame 4 failed", "shot.0002.json", "shot.0004.json"):
            self.assertIn(says, p.stderr)
        self.assertEqual(os.stat(out % 1).st_mtime_ns, before[1])
        self.assertNotEqual(os.stat(out % 3).st_mtime_ns, before[3])
        self.assertEqual(content(out % 5), written[5])
        self.good(shot, *what, "-o", out, "--frames", "1", "--resume", "--seed", "5")
        self.assertNotEqual(content(out % 1), written[1])
        self.good(BALL, *what, "-o", out, "--frames", "8-9")  # a scene that stands still
        self.assertEqual(content(out % 8), content(out % 9))

    def test_usage(self):
        for arguments, says in [
                (["--resume", "-o", self.out], "--checkpoint"), (["--shard", "0/2", "-o", self.out], "--shard"),
                (["--shard", "3/2", "-o", self.out], "--shard"), (["--shard", "2", "-o", self.out], "--shard"),
                (["--shard", "1/2", "--time", "3", "-o", self.out], "photons alone"), (["-o", self.out, "--join"], "--join"),
                (["--shard", "1/9", "--photons", "9000", "-o", self.out], "8 passes"), (["--checkpoint", self.state], "-o"),
                (["--checkpoint", "-", "-o", self.out], "--checkpoint"), (["--shard", "1/2"], "-o"),
                (["-o", self.out, "--frames", "1-3"], "####"), (["-o", self.out + "####", "--frames", "3-1"], "--frames"),
                (["-o", self.out, "--checkpoint", self.state, "--join", self.state], "--join"),
                (["-o", self.out, "--checkpoint", self.state, "--checkpoint-every", "-1"], "--checkpoint-every")]:
            with self.subTest(arguments=arguments):
                self.refused(2, BALL, "--quiet", *arguments, says=says)
                self.assertEqual(os.listdir(self.folder.name), [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
