# SPDX-License-Identifier: Apache-2.0
"""A render of the direct layers on one thread, with a limit on its CPU time."""
import json
import math
import os
import resource
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "..", "tests", "exact"))
from rig import PROGRAM  # noqa: E402


def render(folder, limit_s, *words):
    """Of scene.json in the folder, which gets run.exr: the report; None when it takes longer than the limit."""
    stem = os.path.join(folder, "run")
    command = [PROGRAM, os.path.join(folder, "scene.json"), "-o", stem + ".exr", "--report", stem + ".json", "--quiet", "--threads", "1",
               "--effects", "direct", "--layers", "radiance", *map(str, words)]
    limit = math.ceil(limit_s)
    done = subprocess.run(command, capture_output=True, text=True, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit)))
    if done.returncode < 0:
        return None
    assert done.returncode == 0, f"{' '.join(command)}: {done.stderr}"
    with open(stem + ".json", encoding="utf-8") as file:
        return json.load(file)
