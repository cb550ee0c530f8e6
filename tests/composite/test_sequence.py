# SPDX-License-Identifier: Apache-2.0
"""Sequences: names, frames side by side, broken frames, reports, resuming."""
import json
import os
import signal
import subprocess
import time
import unittest

from support import MERGE, Case, np, read_bytes, write_text


class Sequence(Case):
    def frames(self, numbers, **options):
        for n in numbers:
            self.beauty(f"b.{n:04d}.exr", **options)
            self.caustics({"caustics_key": self.pixels(options.get("height", 20), options.get("width", 30))}, f"c{n:03d}.exr")
        return [self.path("b.####.exr"), self.path("c%03d.exr"), "-o", self.path("o_##.exr")]

    def report(self):
        with open(self.path("r.json")) as file:
            return json.load(file)

    def results(self):
        return [(f["frame"], f["result"]) for f in self.report()["frames"]]

    def test_one_thread_or_many(self):
        names = self.frames(range(8, 13))
        for threads in (1, 2, 7):
            self.run_merge("add", *names, "--frames", "8-12x2", "--threads", threads, "--ev", "key=1", "--report", self.path("r.json"))
            self.assertEqual(self.results(), [(8, "done"), (10, "done"), (12, "done")])
            outputs = {n: read_bytes(self.path(n)) for n in ("o_08.exr", "o_10.exr", "o_12.exr")}
            self.assertFalse(os.path.exists(self.path("o_09.exr")))
            for n, data in outputs.items():
                frame = n[2:4]
                self.run_merge("add", self.path(f"b.00{frame}.exr"), self.path(f"c0{frame}.exr"), "-o", self.path("one.exr"), "--ev", "key=1")
                one = self.out("one.exr")[0].channels
                self.assertTrue(all(np.array_equal(one[c], self.out(n)[0].channels[c]) for c in one))
            if threads > 1:
                self.assertEqual(outputs, before)
            before = outputs

    def test_little_memory(self):
        names = self.frames(range(1, 4))
        for memory in ("1M", "8G"):
            self.run_merge("add", *names, "--frames", "1-3", "--memory", memory, "--threads", 5)
            data = [read_bytes(self.path(f"o_0{n}.exr")) for n in (1, 2, 3)]
            self.assertEqual(data, before if memory == "8G" else data)
            before = data

    def test_missing_and_broken_frames(self):
        names = self.frames(range(1, 7))
        os.remove(self.path("b.0002.exr"))
        data = read_bytes(self.path("c004.exr"))
        with open(self.path("c004.exr"), "wb") as file:
            file.write(data[:len(data) // 2])
        done = subprocess.run([MERGE, "add", *names, "--frames", "1-6", "--report", self.path("r.json")], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("frame 2 was not done", done.stderr)
        self.assertIn("frame 4 was not done", done.stderr)
        self.assertIn("2 of 6 frames", done.stderr)
        self.assertEqual([r for _, r in self.results()], ["done", "failed", "done", "failed", "done", "done"])
        failed = self.report()["frames"][1]
        self.assertIn("b.0002.exr", failed["error"])
        self.assertEqual((self.report()["done"], self.report()["failed"]), (4, 2))
        self.assertFalse(os.path.exists(self.path("o_04.exr")))
        self.assertEqual([f for f in os.listdir(self.folder) if f.endswith(".tmp")], [])

    def test_resume(self):
        names = self.frames(range(1, 5))
        words = ["add", *names, "--frames", "1-4", "--report", self.path("r.json"), "--resume"]
        self.run_merge(*words)
        self.assertEqual(self.report()["done"], 4)
        times = {n: os.stat(self.path(f"o_0{n}.exr")).st_mtime_ns for n in range(1, 5)}
        os.utime(self.path("b.0001.exr"))  # content counts, not the time
        os.remove(self.path("o_02.exr"))
        self.caustics({"caustics_key": self.pixels()}, "c003.exr")
        with open(self.path("o_04.exr"), "r+b") as file:
            file.truncate(200)
        self.run_merge(*words)
        self.assertEqual([r for _, r in self.results()], ["skipped", "done", "done", "done"])
        self.assertEqual(os.stat(self.path("o_01.exr")).st_mtime_ns, times[1])
        self.run_merge(*words, "--gain", "key=2")
        self.assertEqual([r for _, r in self.results()], ["done"] * 4)
        write_text(self.path("recipe.json"), '{"caustics_recipe": 1, "lights": {"key": {"ev": 1}}}')
        self.run_merge(*words, "--recipe", self.path("recipe.json"))
        self.assertEqual(self.report()["done"], 4)
        self.run_merge(*words, "--recipe", self.path("recipe.json"))
        self.assertEqual(self.report()["skipped"], 4)
        write_text(self.path("recipe.json"), '{"caustics_recipe": 1, "lights": {"key": {"ev": 2}}}')
        self.run_merge(*words, "--recipe", self.path("recipe.json"))
        self.assertEqual(self.report()["done"], 4)

    def test_a_truncated_tail_is_not_finished(self):
        names = self.frames([1])
        words = ["add", *names, "--frames", "1-1", "--report", self.path("r.json"), "--resume"]
        self.run_merge(*words)
        data = read_bytes(self.path("o_01.exr"))
        with open(self.path("o_01.exr"), "r+b") as file:
            file.truncate(len(data) - 10)
        self.run_merge(*words)
        self.assertEqual(self.report()["done"], 1)
        self.assertEqual(read_bytes(self.path("o_01.exr")), data)

    def test_names(self):
        names = self.frames([1])
        self.refused("add", *names, "--frames", "1-2x0", says="range", expect=2)
        self.refused("add", *names, "--frames", "1-1", "--preview", self.path("p.png"), says="####", expect=2)
        self.refused("add", self.path("b.0001.exr"), self.path("c001.exr"), "-o", self.path("x.exr"), "--resume", says="--frames", expect=2)
        self.run_merge("add", *names, "--frames", "1-1", "--preview", self.path("p%04d.png"), "--write-recipe", self.path("w.json"))
        self.assertTrue(os.path.exists(self.path("p0001.png")) and os.path.exists(self.path("w.json")))

    def test_interrupt(self):
        names = self.frames(range(1, 9), height=700, width=700, compression=0)
        process = subprocess.Popen([MERGE, "add", *names, "--frames", "1-8", "--compression", "zip", "--report", self.path("r.json")],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while not any(f.endswith(".tmp") for f in os.listdir(self.folder)) and process.poll() is None:
            time.sleep(.001)
        process.send_signal(signal.SIGINT)
        _, text = process.communicate()
        self.assertEqual(process.returncode, 3, text)
        self.assertEqual([f for f in os.listdir(self.folder) if f.endswith(".tmp")], [])
        self.assertLess(self.report()["done"], 8)


if __name__ == "__main__":
    unittest.main()
