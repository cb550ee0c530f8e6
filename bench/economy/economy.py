#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What an effect costs a scene that has none of it.

  economy.py [--photons N] [--work FOLDER] [EFFECT...]

For each effect the renderer is built once more with the effect's code cut out (the functions of EFFECTS, in a copy of the tree),
and both programs render a scene that lacks the effect, under callgrind: the same pictures, to the byte, and nearly as
many instructions. Beside it the CPU seconds of the scene with the effect and without it. A row is wrong when the bytes differ
or when the code that is not called for takes more than 1 % of the instructions. Exit code 1 then. Needs valgrind."""
import argparse
import copy
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LIMIT = 0.01

BALL = {
    "caustics_scene": 1,
    "camera": {"type": "perspective", "look": {"from": [0, -4, 2.5], "to": [-0.2, 0, 0.4]}, "hfov_deg": 40, "resolution": [64, 36]},
    "materials": {"floor": {"type": "diffuse", "color": [0.8, 0.8, 0.8]}, "glass": {"type": "glass", "color": [1, 1, 1]},
                  "card": {"type": "transparent", "color": [0.5, 0.5, 0.5]}, "rough": {"type": "glass", "color": [1, 1, 1], "roughness": 0.3}},
    "objects": [{"name": "Floor", "shape": {"type": "plane", "size": [10, 10]}, "material": "floor"},
                {"name": "Ball", "shape": {"type": "sphere", "radius": 0.5}, "position": [0, 0, 0.7], "material": "glass"}],
    "lights": [{"name": "Lamp", "type": "area", "shape": "disk", "size": [0.3, 0.3], "power_w": 100,
                "look": {"from": [1.5, 0, 2.6], "to": [0, 0, 0.7]}}],
}


def changed(change):
    scene = copy.deepcopy(BALL)
    change(scene)
    return scene


def coarse(scene):
    scene["objects"][1]["shape"]["segments"] = 32


def standing(scene):
    scene["objects"].append({"name": "Box", "shape": {"type": "box", "size": [0.3, 0.3, 0.3]}, "position": [0.9, 0, 0.15], "material": "glass"})


def hidden(scene):
    scene["objects"].append({"name": "Roof", "shape": {"type": "plane", "size": [10, 10]}, "position": [0, 0, 4], "material": "floor",
                             "visible_to_camera": False, "visible_to": ["diffuse"]})


def card(scene):
    scene["objects"].append({"name": "Card", "shape": {"type": "plane", "size": [1, 1]}, "position": [1, 0, 2], "material": "card"})


def limits(scene):
    scene["bounces"] = {"total": 24, "diffuse": 4, "glossy": 16, "transmission": 16}


PHOTONS = ["--estimator", "P", "--effects", "direct"]
# Name: how a scene gets it, options, and what is cut: (file, function, what its body becomes).
EFFECTS = {
    "bent normals": (coarse, PHOTONS, [
        ("render/trace/photons.c", "may_bend", "return false;"),
        ("render/trace/photons.c", "leaves_bent", "return false;"),
        ("render/trace/bent.c", "bent_create", "*out = (BentSet){0}; return CAU_OK;")]),
    "faces in one place": (standing, PHOTONS, [
        ("render/trace/embree_build.c", "find_contacts", ""),
        ("render/trace/embree.c", "nearest", "return settled(s, ray, hit);")]),
    "light along what stands on a receiver": (standing, PHOTONS, [
        ("render/gather/support.h", "support_mirror", "")]),
    "wavefronts": (None, PHOTONS, [
        ("render/trace/photons.c", "wave_goes_on", "return false;"),
        ("render/render.c", "make_view", "return CAU_OK;"),
        ("render/render_waves.c", "waves_draw", "return CAU_OK;"),
        ("render/render_probe.c", "probe_waves", "return CAU_OK;")]),
    "objects hidden from some rays": (hidden, PHOTONS, [
        ("render/trace/embree.c", "trace_nearest", "return nearest(s, ray, hit);")]),
    "transparent objects": (card, PHOTONS, [
        ("render/trace/embree.c", "trace_transmittance", "return rgb_grey(trace_anything_between(s, ray) ? 0 : 1);")]),
    "bounce limits": (limits, PHOTONS, [
        ("render/trace/photons.c", "within_limits", "return true;"),
        ("render/gather/photon_gather.c", "bounces_limited", "return false;")]),
}


def cut(folder, path, function, body):
    path = os.path.join(folder, path)
    with open(path, encoding="utf-8") as file:
        text = file.read()
    head = re.compile(r"^(?:static )?[A-Za-z_][\w ]*[ *]" + function + r"\([^;{]*\) \{\n", re.M)
    match = head.search(text)
    if not match:
        sys.exit(f"{path}: there is no function {function} to cut")
    end = text.index("\n}\n", match.end() - 1)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text[:match.end()] + "    " + body + text[end:])


def build(folder, cuts):
    """A copy of the tree with the cuts; returns its program."""
    tree = os.path.join(folder, "tree")
    if not os.path.isdir(tree):
        for name in subprocess.run(["git", "-C", SOURCE, "ls-files", "-z"], check=True, capture_output=True, text=True).stdout.split("\0"):
            if name and name.split("/")[0] in ("CMakeLists.txt", "cmake", "core", "image", "bridge", "render", "composite", "include",
                                               "accuracy", "plugins", "man", "completions", "LICENSE", "README.md"):
                os.makedirs(os.path.dirname(os.path.join(tree, name)), exist_ok=True)
                shutil.copy2(os.path.join(SOURCE, name), os.path.join(tree, name))
    for path in {c[0] for c in cuts} | set(build.last):
        shutil.copy(os.path.join(SOURCE, path), os.path.join(tree, path))
    build.last = [c[0] for c in cuts]
    for c in cuts:
        cut(tree, *c)
    out = os.path.join(folder, "build")
    for words in (["cmake", "-S", tree, "-B", out, "-DCAUSTICS_TESTS=OFF", "-DCAUSTICS_WERROR=OFF"],
                  ["cmake", "--build", out, "--parallel", "2", "--target", "caustic-render"]):
        done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        if done.returncode:
            sys.exit(done.stdout[-3000:])
    return os.path.join(out, "bin", "caustic-render")


build.last = []


def render(program, scene, folder, options, photons, callgrind):
    """(instructions or CPU seconds, bytes of the picture)"""
    path, out = os.path.join(folder, "scene.json"), os.path.join(folder, "out.exr")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)
    words = [program, path, "-o", out, "--photons", str(photons), "--threads", "1", "--quiet"] + options
    if callgrind:
        words = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"] + words
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    # Each copy has its own libraries; the paths within name the folder that all were built in.
    libraries = {**os.environ, "LD_LIBRARY_PATH": os.path.dirname(os.path.dirname(program))}
    done = subprocess.run(words, capture_output=True, text=True, check=True, env=libraries)
    cost = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    if callgrind:
        cost = int(re.search(r"Collected : (\d+)", done.stderr)[1])
    with open(out, "rb") as file:
        return cost, file.read()


def row(name, program, folder, photons):
    add, options, cuts = EFFECTS[name]
    whole = render(program(()), BALL, folder, options, photons, True)
    without = render(program(cuts), BALL, folder, options, photons, True)
    share, same = whole[0] / without[0] - 1, whole[1] == without[1]
    off, on = (min(render(program(()), s, folder, options, 20 * photons, False)[0] for _ in range(3)) if s else None
               for s in (BALL, changed(add) if add else None))
    ok = same and share < LIMIT
    seconds = f"{off:.2f}, {on:.2f}" if on else f"{off:.2f}, -"
    print(f"| {name} | {without[0] / 1e6:.1f} | {whole[0] / 1e6:.1f} | {100 * share:+.2f} % | {'the same' if same else 'DIFFER'} | {seconds} | "
          f"{'ok' if ok else 'WRONG'} |", flush=True)
    return ok


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("effects", nargs="*", metavar="EFFECT", help=", ".join(EFFECTS))
    p.add_argument("--photons", type=int, default=20000)
    p.add_argument("--work")
    a = p.parse_args()
    if not shutil.which("valgrind"):
        sys.exit("valgrind is missing")
    with tempfile.TemporaryDirectory(prefix="caustics_economy_") as temporary:
        work = a.work or temporary
        os.makedirs(work, exist_ok=True)
        programs = {}

        def program(cuts):
            key = str(cuts)
            if key not in programs:
                programs[key] = os.path.join(work, f"program{len(programs)}")
                built = build(work, list(cuts))
                shutil.rmtree(programs[key], ignore_errors=True)
                shutil.copytree(os.path.dirname(os.path.dirname(built)), programs[key], symlinks=True,
                                ignore=shutil.ignore_patterns("CMakeFiles", "tree"))
            return os.path.join(programs[key], "bin", "caustic-render")
        print("| effect that the scene lacks | million instructions without its code | with it | more | bytes | CPU s off, on | |\n|---|---|---|---|---|---|---|")
        failed = [n for n in a.effects or EFFECTS if not row(n, program, work, a.photons)]
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
