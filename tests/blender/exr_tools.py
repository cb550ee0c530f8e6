# SPDX-License-Identifier: Apache-2.0
"""The files as OpenEXR's exrheader and OpenImageIO's oiiotool see them: parts, names, types, compression, metadata."""
import json
import re
import shutil
import subprocess
import sys
import tempfile

from layers import HEIGHT, LONG, NAMED, SUFFIXES, WIDTH, Check, np, read, render

ATTRIBUTE = re.compile(r"^(\S+) \(type (\w+)\): ?(.*)$")
CHANNEL = re.compile(r"^    (\S+), (.+), sampling 1 1$")
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
OURS = {"layers", "complete", "version", "scene_hash", "seed", "photons", "plan", "error", "repairs", "repaired_nan",
        "clamped"}
TYPES = {"float": ("32-bit floating-point", "f"), "half": ("16-bit floating-point", "h")}


def said_by(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def exrheader(path):
    """(flags, [{attribute: text, "channels": {name: type}} of each part])"""
    text, parts, flags = said_by("exrheader", path).splitlines(), [{}], 0
    for line in text:
        if line.startswith("file format version"):
            flags = int(line.rpartition(" ")[2], 16)
        elif re.match(r" part \d+:$", line) and not line.startswith(" part 0:"):
            parts.append({})
        elif match := ATTRIBUTE.match(line):
            name, _, value = match.groups()
            parts[-1][name] = {} if name == "channels" else value.strip('"')
        elif match := CHANNEL.match(line):
            parts[-1]["channels"][match[1]] = match[2]
        elif line.startswith("compression"):
            parts[-1]["compression"] = line.partition("): ")[2]
    return flags, parts


def names_of(path, check):
    """Every layer's name, in the header's order."""
    rows = json.loads(read(path)[1]["caustics/layers"])
    names = [row["layer"] for row in rows]
    stem = next(row["layer"] for row in rows if row["light"] == LONG and row["kind"] == "radiance")
    check.that(sorted(names) == sorted(NAMED + [stem + s for s in SUFFIXES]), f"caustics/layers lists {len(names)} layers")
    kinds = {"": "radiance", "_ind": "indirect", "_E": "irradiance", "_S": "seen", "_err": "error", "_ind_err": "error"}
    right = {f"caustics_{light}{s}": (group, kind) for light, group in (("Key_light", "Key light"), ("warm", "warm"))
             for s, kind in kinds.items()}
    check.that(all(right.get(r["layer"], (LONG, r["kind"])) == (r["light"], r["kind"]) for r in rows),
               "with each layer's light and kind")
    check.that(all(NAME.fullmatch(n) and len(n) + 2 <= 31 for n in names),
               "names of letters, digits and _, at most 31 with .R")
    return names


def check_parts(path, names, kind, check):
    flags, parts = exrheader(path)
    check.that(flags & 0x1000 and not flags & 0xa00, f"{kind}: several parts, no tiles, no deep data (flags {flags:#x})")
    check.that([p.get("name") for p in parts] == ["rgb"] + names,
               f"{kind}: {len(parts)} parts, the sum first, named as the layers")
    right = [{c: TYPES[kind][0] for c in "RGB"}] + [{f"{n}.{c}": TYPES[kind][0] for c in "RGB"} for n in names]
    check.that([p["channels"] for p in parts] == right,
               f"{kind}: channels carry the layer's name, all {TYPES[kind][0]}")
    check_common(parts, kind, check)
    text = said_by("oiiotool", "--info", "-v", "-a", path)
    check.that(re.findall(r'oiio:subimagename: "(.*)"', text) == ["rgb"] + names, f"{kind}: oiiotool gives the same names")
    listed = [line.split(", ") for line in re.findall(r"channel list: (.*)", text)]
    check.that(listed == [list(p) for p in [["R", "G", "B"]] + [[f"{n}.{c}" for c in "RGB"] for n in names]],
               f"{kind}: oiiotool gives the same channels, in the order R, G, B")
    short = TYPES[kind][1]
    check.that(text.count(f"[{short},{short},{short}]") == len(parts), f"{kind}: oiiotool gives the same type")


def check_common(parts, what, check):
    check.that(all(p["compression"].startswith("zip") for p in parts), f"{what}: ZIP in every part")
    window = f"(0 0) - ({WIDTH - 1} {HEIGHT - 1})"
    check.that(all(p["dataWindow"] == p["displayWindow"] == window for p in parts),
               f"{what}: data window = display window")
    check.that(all(p.get("type", "scanlineimage") == "scanlineimage" for p in parts), f"{what}: scan lines")
    first = parts[0]
    check.that(first.get("colorInteropID") == "lin_rec709_scene", f"{what}: colorInteropID is {first.get('colorInteropID')}")
    ours = {k.partition("/")[2] for k in first if k.startswith("caustics/")}
    check.that(ours == OURS, f"{what}: caustics/ attributes: {' '.join(sorted(ours))}")
    check.that(first["caustics/complete"] == "1" and first["caustics/photons"] == "4800" and first["caustics/seed"] == "0",
               f"{what}: complete, photons, seed")
    times = [k for p in parts for k in p if re.search(r"(?i)date|time|host|user", k)]
    check.that(not times, f"{what}: no times, no names of people or machines {' '.join(times)}")


def check_sum(path, names, tolerance, check):
    planes = read(path)[0]
    for c in "RGB":
        total = sum(planes[f"{n}.{c}"].astype(float) for n in names if not n.endswith(("_E", "_S", "_err")))
        check.that(float(total.max()) > 0 and np.all(np.abs(total - planes[c]) <= tolerance(planes[c], len(names))),
                   f"{c} is the sum of the direct and indirect layers")


def main():
    for tool in ("exrheader", "oiiotool"):
        if not shutil.which(tool):
            print(f"not run: no {tool}; Debian's packages are openexr and openimageio-tools")
            sys.exit(77)
    check = Check()
    with tempfile.TemporaryDirectory(prefix="caustics_exr_tools_") as folder:
        plain = render(folder, "float.exr")
        names = names_of(plain, check)
        check_parts(plain, names, "float", check)
        check_sum(plain, names, lambda x, n: 1e-6 * x + 1e-30, check)
        half = render(folder, "half.exr", "--type", "half")
        check_parts(half, names, "half", check)
        check_sum(half, names, lambda x, n: 2.0 ** -10 * x + (n + 1) * 2.0 ** -25, check)
        single = render(folder, "single.exr", "--interleave")
        flags, parts = exrheader(single)
        check.that(flags == 0 and len(parts) == 1, f"interleave: one part (flags {flags:#x})")
        check.that(sorted(parts[0]["channels"]) == sorted(f"{n}.{c}" if n else c for n in [""] + names for c in "RGB"),
                   "interleave: the same channels")
        check_common(parts, "interleave", check)
        a, b = read(plain)[0], read(single)[0]
        check.that(all(np.array_equal(a[n], b[n]) for n in a), "interleave: the same values")
        cropped = exrheader(render(folder, "crop.exr", "--crop", "--region", "4,2,20,10"))[1]
        check.that(all(p["dataWindow"] == "(4 2) - (19 9)" and p["displayWindow"] == f"(0 0) - ({WIDTH - 1} {HEIGHT - 1})"
                       for p in cropped), "crop: the data window is the region")
    check.end()


if __name__ == "__main__":
    main()
