# SPDX-License-Identifier: Apache-2.0
"""What each library exports, is called, and needs.
usage: libraries.py NAME=FILE..."""
import re
import subprocess
import sys

from house import ROOT, finish

HEADERS = {
    "caustics": ["error.h", "scene.h", "render.h"],
    "caustics-io": ["scene_file.h", "render_file.h"],
    "caustics-composite": ["error.h", "composite.h"],
}
SYSTEM = r"lib(c|m|pthread|gcc_s|stdc\+\+)\.so.*|ld-linux.*|lib(asan|ubsan|tsan)\.so.*"
NEEDS = {
    "caustics": r"libembree[34]\.so.*",
    "caustics-io": r"libcaustics\.so\.0|lib(OpenEXR|OpenEXRCore|Imath|Iex|IlmThread)-.*|libjansson.*|libassimp.*|libdeflate.*",
    "caustics-composite": r"lib(OpenEXR|OpenEXRCore|Imath|Iex|IlmThread)-.*|libjansson.*|libOpenColorIO.*|libpng.*|libjpeg.*|libdeflate.*",
}
problems = []


def declared(names):
    text = "".join((ROOT / "include/caustics" / n).read_text() for n in names)
    return set(re.findall(r"CAU_API[^;({]*[ *](cau_\w+)\(", text))


def tool(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def check(name, path):
    exported = {w[-1].split("@")[0] for w in map(str.split, tool("nm", "-D", "--defined-only", path).splitlines()) if w[-2] != "A"}
    for symbol in sorted(exported - declared(HEADERS[name])):
        problems.append(f"{name} exports {symbol}, which its headers do not declare")
    for symbol in sorted(declared(HEADERS[name]) - exported):
        problems.append(f"{name} does not export {symbol}, which its headers declare")
    dynamic = tool("readelf", "-dW", path)
    soname = re.search(r"SONAME.*\[(.*)\]", dynamic)[1]
    if soname != f"lib{name}.so.0":
        problems.append(f"{name} calls itself {soname}")
    for needed in re.findall(r"NEEDED.*\[(.*)\]", dynamic):
        if not re.fullmatch(SYSTEM, needed) and not re.fullmatch(NEEDS[name], needed):
            problems.append(f"{name} needs {needed}")
        if name == "caustics" and "stdc++" in needed:
            problems.append(f"{name} needs the C++ library")


for argument in sys.argv[1:]:
    check(*argument.split("=", 1))
headers = {p.name for p in (ROOT / "include/caustics").glob("*.h")}
for header in sorted(headers - {h for names in HEADERS.values() for h in names}):
    if declared([header]):
        problems.append(f"{header} declares functions that no library is said to export")
finish(problems, f"{len(sys.argv) - 1} libraries")
