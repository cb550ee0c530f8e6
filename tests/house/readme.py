# SPDX-License-Identifier: Apache-2.0
"""The lines of README.md's "Use it" do what they say, on the still life with few photons.
usage: readme.py FOLDER_OF_PROGRAMS"""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

from house import ROOT, finish

FEW = ["--photons", "20000", "--quiet"]
programs = pathlib.Path(sys.argv[1]).resolve()
text = (ROOT / "README.md").read_text()
block = re.search(r"## Use it\s+```\n(.*?)```", text, re.S)[1]
commands = [shlex.split(line, comments=True) for line in block.splitlines() if line.strip()]
problems = []

with tempfile.TemporaryDirectory() as folder:
    place = pathlib.Path(folder)
    shutil.copytree(ROOT / "scenes", place, dirs_exist_ok=True)
    (place / "still_life.json").rename(place / "scene.json")
    (place / "beauty" / "still_life.exr").rename(place / "beauty.exr")
    for words in commands:
        few = FEW if words[0] == "caustic-render" else []
        run = subprocess.run(words + few, cwd=place, capture_output=True, text=True,
                             env={**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"})
        if run.returncode:
            problems.append(f"{shlex.join(words)}: exit {run.returncode}: {run.stderr}")
    for name in ("caustics.exr", "out.exr", "out.png"):
        if not (place / name).is_file():
            problems.append(f"there is no {name}")
finish(problems, f"{len(commands)} commands")
