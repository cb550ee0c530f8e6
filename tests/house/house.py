# SPDX-License-Identifier: Apache-2.0
"""What the checks of this folder share: the project's files, and how a check ends."""
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
SKIPPED = 77  # as tests.cmake tells CTest


def tracked(*endings):
    """Files under version control with one of the endings (all without), as paths relative to ROOT."""
    try:
        out = subprocess.run(["git", "-c", "safe.directory=*", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
        names = [pathlib.Path(n) for n in out.stdout.decode().split("\0") if n]
    except (OSError, subprocess.CalledProcessError):  # an archive, or no git
        names = [p.relative_to(ROOT) for p in ROOT.rglob("*") if p.is_file()]
        names = [n for n in names if not re.match(r"build|\.git/|.*__pycache__", str(n))]
    return sorted(n for n in names if (not endings or n.name.endswith(endings)) and (ROOT / n).is_file())


def lines(path):
    return (ROOT / path).read_text(encoding="utf-8").splitlines()


def finish(problems, checked):
    """Prints every problem and ends the check."""
    for problem in problems:
        print(problem)
    print(f"{checked}: {len(problems)} problems")
    sys.exit(1 if problems else 0)


def skip(reason):
    print("skipped:", reason)
    sys.exit(SKIPPED)
