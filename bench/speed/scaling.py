# SPDX-License-Identifier: Apache-2.0
"""How cost grows with threads, with a caster's triangles, with lights and with photons: scene a_ball.

usage: scaling.py [threads] [triangles] [lights] [photons]

Whole process, 160x90; CPU and wall seconds and peak memory. Only threads are about wall seconds: the machine has to be idle."""
import copy
import json
import math
import os
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("CAUSTIC_RENDER", os.path.join(ROOT, "build", "bin", "caustic-render"))
PHOTONS = 400000


def measure(folder, scene, photons=PHOTONS, threads=1, *words):
    """CPU seconds, wall seconds, MiB."""
    path = os.path.join(folder, "scene.json")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)
    start = time.monotonic()
    child = subprocess.Popen([PROGRAM, path, "-o", os.path.join(folder, "out.exr"), "--resolution", "160x90", "--photons", str(photons),
                              "--threads", str(threads), "--quiet", *words], stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    if status:
        sys.exit(f"caustic-render: exit code {os.waitstatus_to_exitcode(status)}")
    return used.ru_utime + used.ru_stime, time.monotonic() - start, used.ru_maxrss / 1024


def row(*cells):
    print("| " + " | ".join(c if isinstance(c, str) else f"{c:.2f}" if c < 10 else f"{c:.0f}" for c in cells) + " |", flush=True)


def head(*cells):
    print("\n| " + " | ".join(cells) + " |\n|" + "---|" * len(cells))


def threads(folder, base):
    head("estimator", "threads", "CPU s", "wall s", "times one thread")
    for estimator in ("W", "P"):
        one = 0.0
        for n in (1, 2):
            cpu, wall, _ = min((measure(folder, base, 4 * PHOTONS, n, "--estimator", estimator) for _ in range(3)), key=lambda m: m[1])
            one = one or wall
            row(estimator, str(n), cpu, wall, one / wall)


def triangles(folder, base):
    head("triangles", "CPU s", "MiB", "bytes per triangle")
    before = None
    for wanted in (1e4, 1e5, 1e6, 1e7):
        scene = copy.deepcopy(base)
        segments = 2 * round(math.sqrt(wanted / 2))
        scene["objects"][1]["shape"]["segments"] = segments
        count = segments * (segments - 2)
        cpu, _, memory = measure(folder, scene)
        row(f"{count:.2g}", cpu, memory, (memory - before[1]) * 2**20 / (count - before[0]) if before else "-")
        before = (count, memory)


def lights(folder, base):
    head("lights", "CPU s", "CPU s per light", "MiB")
    for n in (1, 4, 16, 64):
        scene = copy.deepcopy(base)
        scene["lights"] = []
        for i in range(n):
            angle = 2 * math.pi * i / n
            scene["lights"].append({**base["lights"][0], "name": f"Sun{i}",
                                    "look": {"from": [0.5 * math.cos(angle), 0.5 * math.sin(angle), 0.866], "to": [0, 0, 0]}})
        cpu, _, memory = measure(folder, scene, PHOTONS // 4)
        row(str(n), cpu, cpu / n, memory)


def photons(folder, base):
    head("photons", "estimator", "CPU s", "MiB")
    for estimator in ("W", "P"):
        for n in (10**5, 10**6, 10**7):
            cpu, _, memory = measure(folder, base, n, 1, "--estimator", estimator)
            row(f"{n:.0e}", estimator, cpu, memory)


def main():
    parts = {f.__name__: f for f in (threads, triangles, lights, photons)}
    with open(os.path.join(ROOT, "scenes", "a_ball.json"), encoding="utf-8") as file:
        base = json.load(file)
    with tempfile.TemporaryDirectory() as folder:
        for name in sys.argv[1:] or parts:
            parts[name](folder, base)


if __name__ == "__main__":
    main()
