# SPDX-License-Identifier: Apache-2.0
"""Installs the build into an empty prefix, moves it, and builds a program against it twice: by pkg-config and by
find_package.
usage: install.py BUILD CMAKE GENERATOR CC VERSION [FLAGS]"""
import os
import pathlib
import shutil
import subprocess
import sys

from house import finish

build, cmake, generator, cc, version, flags = (sys.argv + [""])[1:7]
here = pathlib.Path(__file__).resolve().parent / "consumer"
place = pathlib.Path(build) / "tests" / "installed"
problems = []


def run(*command, **env):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, env={**os.environ, **env})
    if done.returncode:
        print(done.stdout, done.stderr)
        finish([f"{command[0]} failed"], "installation")
    return done.stdout


def expect(what, said):
    if said.split()[-1:] != [version]:
        problems.append(f"{what} says {said!r}, not {version}")


shutil.rmtree(place, ignore_errors=True)
place.mkdir(parents=True)
run(cmake, "--install", build, "--prefix", place / "first")
prefix = (place / "first").rename(place / "prefix")
libdir = next(prefix.rglob("libcaustics.so")).parent
for program in ("caustic-render", "caustic-merge", "caustic-accuracy"):
    expect(program, run(prefix / "bin" / program, "--version"))

found = {"PKG_CONFIG_PATH": str(libdir / "pkgconfig")}
words = run("pkg-config", "--cflags", "--libs", "caustics-io", "caustics-composite", **found).split()
run(cc, "-std=c99", "-Wall", "-Werror", *flags.split(), here / "consumer.c", "-o", place / "by_pkgconfig", *words)
expect("by pkg-config", run(place / "by_pkgconfig", LD_LIBRARY_PATH=str(libdir)))

run(cmake, "-G", generator, "-S", here, "-B", place / "build", f"-DCMAKE_PREFIX_PATH={prefix}", f"-DCMAKE_C_COMPILER={cc}",
    f"-DCMAKE_C_FLAGS={flags}")
run(cmake, "--build", place / "build")
expect("by find_package", run(place / "build" / "consumer"))
finish(problems, "two programs")
