# SPDX-License-Identifier: Apache-2.0
"""Peak memory against picture size: still_life, two lights.

usage: memory.py [SCENE]

Bytes per pixel are the slope between two sizes, so the program, its libraries and the scene do not count."""
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("CAUSTIC_RENDER", os.path.join(ROOT, "build", "bin", "caustic-render"))
SIZES = ((480, 270), (1920, 1080))
PHOTONS = 131072
ROWS = (("direct", "radiance"), ("direct", "radiance,error"), ("direct,indirect", "radiance,indirect"),
        ("direct,indirect", "radiance,indirect,error"), ("direct,indirect", "radiance,indirect,irradiance,error"))


def peak(scene, size, effects, layers):
    """Bytes, and CPU seconds, of one render."""
    with tempfile.TemporaryDirectory() as folder:
        child = subprocess.Popen([PROGRAM, scene, "-o", os.path.join(folder, "out.exr"), "--resolution",
                                  f"{size[0]}x{size[1]}", "--effects", effects, "--layers", layers, "--photons",
                                  str(PHOTONS), "--seed", "1", "--quiet"])
        _, status, used = os.wait4(child.pid, 0)
        if status:
            sys.exit(f"caustic-render: exit code {os.waitstatus_to_exitcode(status)}")
        return 1024 * used.ru_maxrss, used.ru_utime


def main():
    scene = os.path.join(ROOT, "scenes", (sys.argv[1:] or ["still_life"])[0] + ".json")
    small, large = ("x".join(map(str, size)) for size in SIZES)
    print(f"| effects | layers | MiB at {small} | MiB at {large} | bytes per pixel | CPU s at {large} |\n"
          "|---|---|---|---|---|---|")
    for effects, layers in ROWS:
        (few, _), (many, seconds) = (peak(scene, size, effects, layers) for size in SIZES)
        slope = (many - few) / (SIZES[1][0] * SIZES[1][1] - SIZES[0][0] * SIZES[0][1])
        print(f"| {effects} | {layers} | {few / 2**20:.0f} | {many / 2**20:.0f} | {slope:.0f} | {seconds:.0f} |", flush=True)


if __name__ == "__main__":
    main()
