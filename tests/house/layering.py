# SPDX-License-Identifier: Apache-2.0
"""The one-way flow: a folder includes what it rests on and the stages before it, nothing else."""
import re

from house import finish, lines, tracked

BASE = {"core", "include/caustics"}
SHARED = BASE | {"bridge", "image"}
SCENE = {"render/scene", "render/material", "render/light"}
STAGES = ["render/analyse", "render/emit", "render/trace", "render/gather", "render/gather/wave", "render/film"]

ALLOWED = {
    "core": BASE,
    "image": SHARED,
    "bridge": SHARED,
    "render/material": BASE,
    "render/light": BASE,
    "render/scene": BASE | SCENE,
    "render/scene/reference": BASE | SCENE,  # writes docs/, not installed
    "render/scene/io": SHARED | SCENE,
    "render/layers": SHARED | SCENE | set(STAGES),
    "render": SHARED | SCENE | set(STAGES),
    "composite": SHARED,
    "composite/hosts": SHARED | {"composite"},
    "composite/cli": BASE,
}
for index, stage in enumerate(STAGES):
    ALLOWED[stage] = SHARED | SCENE | set(STAGES[:index])

# A library's headers and those of one file's halves, and the files that may include them.
FOREIGN = {
    r"embree[34]/": r"render/trace/embree_internal\.h",
    r"render/trace/embree_internal\.h": r"render/trace/embree.*\.c",
    r"(Imf|Imath|Iex|OpenEXR/|OpenColorIO/|OpenImageIO/)": r"bridge/.*\.cpp",
    r"openexr.*\.h": r"image/.*",
    r"assimp/": r"render/scene/io/.*",
    r"jansson\.h": r"(image|composite|render/scene/io|render/scene/reference|render/layers)/.*",
    r"png\.h": r"composite/png\.c",
    r"jpeglib\.h": r"composite/jpeg\.c",
    r"pthread\.h": r"(core/.*|render/render_internal\.h)",
}

# What a program's own files may see of the project: the public headers, core, and each other.
PROGRAM = r"render/[a-z_]*_main\.c|composite/composite_main\.c|composite/cli/.*"
PROGRAM_MAY = r"caustics/|core/|composite/cli/|render/render_options\.h"

problems = []


def includes(path):
    for number, line in enumerate(lines(path), 1):
        match = re.match(r'\s*#\s*include\s+(["<])([^">]+)[">]', line)
        if match:
            yield f"{path}:{number}", match[1] == '"', match[2]


def check_own(place, folder, path, name):
    target = "include/" + name if name.startswith("caustics/") else name
    target = target.rsplit("/", 1)[0]
    if folder == "include/caustics":
        allowed = {"include/caustics"}
    else:
        allowed = ALLOWED.get(folder, set()) | {folder}
    if str(path) == "composite/composite_main.c":
        allowed = allowed | {"composite/cli"}
    if target not in allowed:
        problems.append(f"{place}: {folder}/ must not include {name}")
    if re.fullmatch(PROGRAM, str(path)) and not re.match(PROGRAM_MAY, name):
        problems.append(f"{place}: a program uses the public headers, not {name}")


def check_foreign(place, path, name):
    for pattern, where in FOREIGN.items():
        if re.match(pattern, name) and not re.fullmatch(where, str(path)):
            problems.append(f"{place}: <{name}> belongs in {where} only")


sources = [p for p in tracked(".c", ".h", ".cpp", ".def") if p.parts[0] not in ("tests", "plugins", "accuracy", "bench")]
for path in sources:
    folder = str(path.parent)
    if folder not in ALLOWED and folder != "include/caustics":
        problems.append(f"{path}: the folder has no place in the order of tests/house/layering.py")
        continue
    if path.suffix == ".cpp" and folder != "bridge":
        problems.append(f"{path}: C++ lives in bridge/ only")
    for place, own, name in includes(path):
        if own:
            check_own(place, folder, path, name)
        check_foreign(place, path, name)
finish(problems, f"{len(sources)} files")
