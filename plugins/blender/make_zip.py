# SPDX-License-Identifier: Apache-2.0
"""Packs the add-on with the programs and every library that they need beyond the C library of the system.

usage: make_zip.py OUT_FOLDER VERSION PLATFORM LICENSE PROGRAM...
Writes OUT_FOLDER/caustics-VERSION-PLATFORM.zip: one folder `caustics`, which both kinds of Blender install (add-ons before 4.2,
extensions since). Libraries are found by ldd, as the programs would find them here. Same input, same bytes."""
import os
import pathlib
import re
import subprocess
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
# Bound to the kernel and to each other: those of the system that runs it.
SYSTEM = re.compile(r"(ld-linux.*|libc|libm|libdl|librt|libpthread|libresolv|libutil|linux-vdso)\.so")
EPOCH = (1980, 1, 1, 0, 0, 0)


def libraries(program):
    """{file name: path} of what a program loads."""
    out = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    found = {}
    for line in out.splitlines():
        words = line.split()
        if "not found" in line:
            sys.exit(f"make_zip.py: {program} needs {words[0]}, which is not found")
        if len(words) >= 3 and words[1] == "=>" and not SYSTEM.match(words[0]):
            found[words[0]] = words[2]
    return found


def add(archive, name, data, mode):
    entry = zipfile.ZipInfo("caustics/" + name, EPOCH)
    entry.external_attr, entry.compress_type = (0o100000 | mode) << 16, zipfile.ZIP_DEFLATED
    archive.writestr(entry, data)


def main(folder, version, platform, license_file, *programs):
    path = pathlib.Path(folder) / f"caustics-{version}-{platform}.zip"
    beside = path.with_suffix(".part")
    wanted = {}
    for program in programs:
        wanted.update(libraries(program))
    with zipfile.ZipFile(beside, "w", compresslevel=6) as archive:
        for source in sorted((HERE / "caustics").glob("*")):
            if source.suffix in (".py", ".toml"):
                text = source.read_text(encoding="utf-8").replace("@CAUSTICS_PLATFORM@", platform)
                add(archive, source.name, text, 0o644)
        add(archive, "LICENSE", pathlib.Path(license_file).read_bytes(), 0o644)
        for program in sorted(programs):
            add(archive, "bin/" + os.path.basename(program), pathlib.Path(program).read_bytes(), 0o755)
        for name in sorted(wanted):
            add(archive, "lib/" + name, pathlib.Path(wanted[name]).read_bytes(), 0o755)
    os.replace(beside, path)
    print(f"{path.name}: {len(wanted)} libraries, {path.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main(*sys.argv[1:])
