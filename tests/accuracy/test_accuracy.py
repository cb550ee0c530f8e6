# SPDX-License-Identifier: Apache-2.0
"""caustic-accuracy on a glass ball and on a small rough mirror: columns, errors that fall, references that are wrong.
Environment: CAUSTIC_ACCURACY, CAUSTIC_RENDER."""
import csv
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

ACCURACY, RENDER = os.environ["CAUSTIC_ACCURACY"], os.environ["CAUSTIC_RENDER"]
SCENES = os.path.join(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))), "scenes")
BALL = os.path.join(SCENES, "a_ball.json")
RING = os.path.join(SCENES, "b_ring.json")
SMALL = ["--resolution", "48x27", "--effects", "direct", "--quiet"]
COLUMNS = ["estimator", "budget", "photons", "rel_mse", "trimmed_rel_mse", "nrmse", "stated_error", "energy", "cpu_s", "before_s",
           "wall_s", "peak_mib"]


def run(*arguments, **more):
    return subprocess.run([ACCURACY, *arguments], capture_output=True, text=True, timeout=300, check=False, **more)


def rows_of(folder):
    with open(os.path.join(folder, "accuracy.csv"), encoding="utf-8") as file:
        reader = csv.DictReader(file)
        return reader.fieldnames, list(reader)


class Accuracy(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory(prefix="caustics_accuracy_")
        self.addCleanup(holder.cleanup)
        self.folder = holder.name
        self.reference = os.path.join(self.folder, "reference.exr")
        self.out = os.path.join(self.folder, "out")

    def make_reference(self, scene=BALL, *more):
        subprocess.run([RENDER, scene, "-o", self.reference, "--resolution", "48x27", "--effects", "direct", "--photons", "100000",
                        "--seed", "77", "--threads", "1", "--quiet", *more], check=True)

    def refused(self, code, says, *arguments):
        p = run(*arguments)
        self.assertEqual(p.returncode, code, p.stderr)
        self.assertEqual(len(p.stderr.strip().splitlines()), 1, p.stderr)
        self.assertIn(says, p.stderr)
        return p

    def test_ladder(self):
        """Everything is written; P's error falls along the ladder, and W's is below P's."""
        p = run(BALL, *SMALL, "--ladder", "3000,20000,100000", "--reference-photons", "300000",
                "--estimators", "W,P", "-o", self.out)
        self.assertEqual(p.returncode, 0, p.stderr)
        names, rows = rows_of(self.out)
        self.assertEqual(names, COLUMNS)
        self.assertEqual([r["estimator"] for r in rows], ["W"] * 3 + ["P"] * 3)
        self.assertEqual([int(r["budget"]) for r in rows], [3000, 20000, 100000] * 2)
        self.assertTrue(all(float(r["cpu_s"]) > 0 and float(r["peak_mib"]) > 1 for r in rows), rows)
        photons = [float(r["rel_mse"]) for r in rows if r["estimator"] == "P"]
        self.assertGreater(photons[0], 2 * photons[1])
        self.assertGreater(photons[1], 1.3 * photons[2])
        w, photons = ([float(r["nrmse"]) for r in rows if r["estimator"] == e] for e in "WP")
        self.assertGreater(photons[2], 1.5 * w[2])
        self.assertLess(w[2], 0.012)
        for r in rows[1:]:
            self.assertAlmostEqual(float(r["energy"]), 1, delta=0.05)
        self.assertEqual(len(re.findall(r"^\| [WP] \| .*%", p.stdout, re.M)), 6, p.stdout)
        for effect in ("direct", "direct and indirect", "as the plan decides"):
            self.assertRegex(p.stdout, rf"(?m)^\| {effect} \| \d")
        self.check_page(bool(shutil.which("gnuplot")))

    def check_page(self, plotted):
        files = set(os.listdir(self.out))
        self.assertTrue({"index.html", "accuracy.gp", "reference.png", "equal_time_P.png"} <= files, files)
        self.assertEqual({"error.svg", "stated.svg"} <= files, plotted)
        with open(os.path.join(self.out, "index.html"), encoding="utf-8") as file:
            for name in re.findall(r'src="([^"]+)"', file.read()):
                self.assertGreater(os.path.getsize(os.path.join(self.out, name)), 100, name)

    def test_without_gnuplot(self):
        """One sentence says so; the rest is written."""
        p = run(RING, *SMALL, "--ladder", "2000", "--estimators", "P", "-o", self.out, env={**os.environ, "PATH": "/nonexistent"})
        self.assertEqual(p.returncode, 0, p.stderr)
        self.assertIn("gnuplot-nox", p.stderr)
        self.check_page(False)

    def test_given_reference(self):
        self.make_reference()
        ladder = ["--ladder", "2000,10000", "--estimators", "W,P", *SMALL]
        self.assertEqual(run(BALL, *ladder, "--reference", self.reference).returncode, 0)
        self.refused(1, "48 x 27", BALL, *ladder, "--reference", self.reference, "--resolution", "64x36")
        with open(self.reference, "rb") as file:
            whole = file.read()
        with open(self.reference, "wb") as file:
            file.write(whole[:len(whole) // 2])
        self.refused(1, "damaged", BALL, *ladder, "--reference", self.reference)
        with open(self.reference, "wb") as file:
            file.write(b"no picture")
        self.refused(1, "no whole EXR", BALL, *ladder, "--reference", self.reference)

    def test_reference_of_something_else(self):
        """A whole file with a light a tenth stronger, or with a ball moved: the estimators contradict it."""
        with open(BALL, encoding="utf-8") as file:
            scene = json.load(file)
        for change in ("strength", "place"):
            changed = json.loads(json.dumps(scene))
            if change == "strength":
                changed["lights"][0]["strength"] = 1.1 * changed["lights"][0].get("strength", 1)
            else:
                ball = next(o for o in changed["objects"] if o.get("name") == "Ball")
                ball["position"] = [c + 0.1 for c in ball.get("position", [0, 0, 0])[:2]] + ball.get("position", [0, 0, 0])[2:]
            path = os.path.join(self.folder, "changed.json")
            with open(path, "w", encoding="utf-8") as file:
                json.dump(changed, file)
            self.make_reference(path)
            with self.subTest(change=change):
                self.refused(1, "another scene or is damaged", BALL, *SMALL, "--ladder", "5000,20000", "--estimators", "W,P",
                             "--reference", self.reference)

    def test_usage(self):
        for arguments, says in [
            ([], "no scene"), ([BALL, BALL], "one scene"), ([BALL, "--ladder", "5,4"], "--ladder"), ([BALL, "--ladder", ""], "--ladder"),
            ([BALL, "--ladder", "1,2,x"], "--ladder"), ([BALL, "--estimators", "W,W"], "--estimators"),
            ([BALL, "--estimators", "Q"], "--estimators"), ([BALL, "--resolution", "48"], "--resolution"),
            ([BALL, "--effects", "indirect"], "--effects"), ([BALL, "--threads", "0"], "--threads"), ([BALL, "-o", "-"], "-o"),
            ([BALL, "--lader", "3"], "--ladder"), ([BALL, "--reference", "x", "--reference-photons", "9"], "exclude"),
            ([BALL, "--cycles", "x", "--effects", "direct"], "Cycles"),
        ]:
            with self.subTest(arguments=arguments):
                self.refused(2, says, *arguments)
        self.refused(1, "nosuch.json", os.path.join(self.folder, "nosuch.json"))
        self.refused(4, "cannot write", BALL, "-o", os.path.join(self.folder, "no", "folder"))

    def test_cancelled(self):
        """What was measured is written; the render that runs is ended too."""
        p = subprocess.Popen([ACCURACY, BALL, *SMALL[:4], "--ladder", "1000,1000000000", "--estimators", "P", "--reference-photons", "1000",
                              "-o", self.out], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for line in p.stderr:
            if line.startswith("P, 1000000000"):
                break
        time.sleep(0.3)
        p.send_signal(signal.SIGTERM)
        p.communicate(timeout=60)
        self.assertEqual(p.returncode, 3)
        self.assertEqual([r["budget"] for r in rows_of(self.out)[1]], ["1000"])


if __name__ == "__main__":
    unittest.main()
