# SPDX-License-Identifier: Apache-2.0
"""CPU time and peak memory of one add, beside oiiotool and a bare OpenEXRCore read and write of the same file, in one run;
then a sequence on one core and on two, beside two programs of one core each: what the machine has to give.

usage: speed.py MERGE BARE_CORE FOLDER [--frames N] [--repeat N]"""
import argparse
import os
import pathlib
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent


def make(beauty, caustics, *numbers):
    words = [sys.executable, "-B", HERE / "speed_files.py", beauty, caustics, *numbers]
    return subprocess.run([str(w) for w in words], check=True, stdout=subprocess.PIPE, text=True).stdout.split()


def measure(words):
    """(user + system seconds, peak MB, wall seconds)"""
    start = time.monotonic()
    process = subprocess.Popen([str(w) for w in words], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f"failed: {words}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, time.monotonic() - start


def one_add(merge, bare, folder, repeat):
    width, height = 3840, 2160
    b, c = folder / "beauty.exr", folder / "caustics.exr"
    names = make(b, c, width, height, 12, 4)
    total = {f"ViewLayer.Combined.{k}": k for k in "RGB"}
    spread = ",".join(f"{n}={total.get(n, 0)}" for n in names)
    runs = {
        "caustic-merge, all threads": [merge, "add", b, c, "-o", folder / "out.exr"],
        "caustic-merge, one thread": [merge, "add", b, c, "-o", folder / "out.exr", "--threads", "1"],
        "oiiotool, one add of the sum": ["oiiotool", b, c, "--subimage", "0", "--ch", spread, "--add", "-d", "half", "-o", folder / "o.exr"],
        "bare OpenEXRCore, read + write": [bare, b, folder / "core.exr"],
    }
    print(f"{width} x {height}, {len(names)} half channels, ZIP, {b.stat().st_size >> 20} MB; 4 float lights, {c.stat().st_size >> 20} MB; "
          f"load {os.getloadavg()[0]:.1f}")
    found = {}
    for name, words in runs.items():
        found[name] = min(measure(words) for _ in range(repeat))
        cpu, memory, wall = found[name]
        print(f"  {name:32} {cpu:6.2f} s CPU, {memory:6.0f} MB, {wall:6.2f} s")
    ours, tool, core = (found[n] for n in ("caustic-merge, all threads", "oiiotool, one add of the sum", "bare OpenEXRCore, read + write"))
    sizes = {n: (folder / n).stat().st_size >> 20 for n in ("out.exr", "o.exr", "core.exr")}
    print(f"  written, MB: ours {sizes['out.exr']}, oiiotool {sizes['o.exr']}, bare {sizes['core.exr']}")
    print(f"  to oiiotool: CPU {ours[0] / tool[0]:.2f} (goal 0.60), memory {ours[1] / tool[1]:.2f} (goal 0.25)")
    print(f"  to bare OpenEXRCore: CPU {ours[0] / core[0]:.2f} (goal 1.00)")
    for n in sizes:
        (folder / n).unlink()


def remove(folder, count):
    for i in range(1, count + 1):
        (folder / f"o.{i:04d}.exr").unlink()


def two_programs(words, count):
    """Seconds for the two halves at once, each by a program of its own on a core of its own."""
    start = time.monotonic()
    halves = [f"1-{count // 2}", f"{count // 2 + 1}-{count}"]
    both = [subprocess.Popen(["taskset", "-c", str(core), *map(str, words), "--threads", "1", "--frames", half])
            for core, half in enumerate(halves)]
    if any([p.wait() for p in both]):
        sys.exit(f"failed: {words}")
    return time.monotonic() - start


def sequence(merge, folder, count):
    width, height = 1920, 1080
    make(folder / "b.exr", folder / "c.exr", width, height, 3, 2)
    for i in range(1, count + 1):
        for name in "bc":
            (folder / f"{name}.{i:04d}.exr").unlink(missing_ok=True)
            (folder / f"{name}.{i:04d}.exr").symlink_to(folder / f"{name}.exr")
    words = [merge, "add", folder / "b.####.exr", folder / "c.####.exr", "-o", folder / "o.####.exr", "--quiet"]
    walls = {}
    for cores in (1, 2):
        cpu, memory, walls[cores] = measure(["taskset", "-c", "0" if cores == 1 else "0,1", *words, "--threads", cores,
                                             "--frames", f"1-{count}"])
        print(f"  {count} frames of {width} x {height} on {cores} core{'s' * (cores > 1)}: {walls[cores]:.1f} s, {cpu:.1f} s CPU, "
              f"{memory:.0f} MB; load {os.getloadavg()[0]:.1f}")
        remove(folder, count)
    apart = two_programs(words, count)
    remove(folder, count)
    print(f"  two cores against one: {walls[1] / walls[2]:.2f} times (goal 1.9); two programs, half of the frames each: "
          f"{walls[1] / apart:.2f}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("merge")
    parser.add_argument("bare")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--frames", type=int, default=240)
    parser.add_argument("--repeat", type=int, default=3, help="the least CPU time counts")
    a = parser.parse_args()
    a.folder.mkdir(parents=True, exist_ok=True)
    a.folder = a.folder.resolve()
    one_add(a.merge, a.bare, a.folder, a.repeat)
    if a.frames:
        sequence(a.merge, a.folder, a.frames)


if __name__ == "__main__":
    main()
