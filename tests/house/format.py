# SPDX-License-Identifier: Apache-2.0
"""clang-format has nothing to change. Versions differ in details; the project's is Debian 12's.
usage: format.py [--fix]"""
import re
import subprocess
import sys

from house import ROOT, finish, skip, tracked

VERSION = "14"


def clang_format():
    for name in ("clang-format-" + VERSION, "clang-format"):
        try:
            said = subprocess.run([name, "--version"], capture_output=True, text=True, check=True).stdout
        except OSError:
            continue
        if re.search(rf"version {VERSION}\.", said):
            return name
    skip(f"no clang-format {VERSION}")


tool = clang_format()
files = tracked(".c", ".h", ".cpp")
if "--fix" in sys.argv:
    subprocess.run([tool, "-i", *files], cwd=ROOT, check=True)
run = subprocess.run([tool, "--dry-run", "-Werror", *files], cwd=ROOT, capture_output=True, text=True)
wrong = sorted(set(re.findall(r"^([^:\n]+):\d+:\d+: error", run.stderr, re.M)))
finish([f"{name}: run tests/house/format.py --fix" for name in wrong] if run.returncode else [], f"{len(files)} files")
