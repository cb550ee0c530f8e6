# SPDX-License-Identifier: Apache-2.0
"""Every header compiles alone: the public ones as strict C99 and C++17, the others as C17.
usage: headers.py CC CXX COMPILE_COMMANDS.json"""
import json
import shlex
import subprocess
import sys

from house import ROOT, finish, tracked

cc, cxx, commands = sys.argv[1:4]
WARN = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror", "-fsyntax-only"]
problems = []


def library_flags():
    """Include folders of the libraries that the build found."""
    flags = set()
    for entry in json.load(open(commands)):
        words = shlex.split(entry["command"])
        flags.update(w for w in words if w.startswith(("-I/usr", "-DCAUSTICS_EMBREE")))
        flags.update("-isystem" + words[i + 1] for i, w in enumerate(words[:-1]) if w == "-isystem")
    return sorted(flags)


def compile_alone(header, compiler, flags):
    run = subprocess.run([*compiler, *WARN, *flags, "-"], input=f'#include "{header}"\nint caustics_not_empty;\n',
                         text=True, capture_output=True, cwd=ROOT)
    if run.returncode:
        problems.append(f"{header} as {' '.join(compiler)}:\n{run.stderr}")


found = library_flags()
headers = tracked(".h")
for header in headers:
    if header.parts[0] == "include":
        name = header.relative_to("include")
        compile_alone(name, [cc, "-xc", "-std=c99", "-pedantic"], ["-Iinclude"])
        compile_alone(name, [cxx, "-xc++", "-std=c++17", "-pedantic"], ["-Iinclude"])
    elif header.parts[0] != "tests":
        compile_alone(header, [cc, "-xc", "-std=c17", "-D_GNU_SOURCE"], ["-I.", "-Iinclude", *found])
finish(problems, f"{len(headers)} headers")
