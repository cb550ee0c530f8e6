# SPDX-License-Identifier: Apache-2.0
"""Man pages and completions: they hold every word of --help, the shells take them, and they are installed.
Environment: CAUSTIC_ACCURACY, CAUSTIC_MERGE, CAUSTIC_RENDER, CAUSTICS_BUILD (the build folder), CMAKE."""
import os
import pty
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(SOURCE, "man"))
import help_text  # noqa: E402

PROGRAMS = {name: os.environ[name.upper().replace("-", "_")] for name in ("caustic-accuracy", "caustic-merge", "caustic-render")}
BUILD = os.environ["CAUSTICS_BUILD"]


def run(*command, **more):
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=60, **more)


def read(*path):
    with open(os.path.join(BUILD, *path), encoding="utf-8") as file:
        return file.read()


def plain(roff):
    """The words of a page without its marks."""
    return " ".join(re.sub(r"\\f.|\\&|^\.\w+ ?|\\e", "", roff.replace("\\(ha", "^").replace("\\-", "-"), flags=re.M).split())


class Pages(unittest.TestCase):
    def test_help_is_understood(self):
        """Every option in --help is found, and the program knows every option and command that is found."""
        for name, program in PROGRAMS.items():
            text = help_text.read(program)
            options = help_text.options(text)
            self.assertEqual(set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", text)), {o for o in options if o.startswith("--")})
            self.assertGreater(len(options), 10)
            for option, value in options.items():
                said = run(program, *([option] if not value else [f"{option}"])).stderr
                self.assertNotIn("unknown option", said, f"{name} {option}")
            for command in help_text.commands(text):
                self.assertNotIn("unknown command", run(program, command).stderr, command)
        commands = help_text.commands(help_text.read(PROGRAMS["caustic-merge"]))
        self.assertTrue({"add", "list", "check", "preview", "nuke", "blender", "recipe"} <= set(commands), commands)

    def test_pages_hold_the_help(self):
        for name, program in PROGRAMS.items():
            page = plain(read("man", name + ".1"))
            for block in help_text.blocks(help_text.read(program)):
                for entry in block.entries:
                    if entry.options() or entry.text:
                        self.assertIn(" ".join(entry.left.split()), page)
                        self.assertIn(" ".join(entry.text.split()), page)
            for section in ("NAME", "SYNOPSIS", "DESCRIPTION", "EXAMPLES", "EXIT STATUS", "SEE ALSO"):
                self.assertRegex(page, section)

    def test_pages_are_sound(self):
        found = [tool for tool in (["mandoc", "-T", "lint", "-W", "warning"], ["groff", "-man", "-Tascii", "-ww"])
                 if shutil.which(tool[0])]
        if not found:
            self.skipTest("neither mandoc nor groff")
        for tool in found:
            for name in PROGRAMS:
                done = run(*tool, os.path.join(BUILD, "man", name + ".1"))
                said = (done.stdout if tool[0] == "mandoc" else "") + done.stderr
                self.assertEqual([s for s in said.splitlines() if "missing date" not in s], [], tool)

    def test_installed(self):
        with tempfile.TemporaryDirectory(prefix="caustics_pages_") as folder:
            done = run(os.environ["CMAKE"], "--install", BUILD, "--prefix", folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            for name in PROGRAMS:
                for path in (f"share/man/man1/{name}.1", f"share/bash-completion/completions/{name}",
                             f"share/zsh/site-functions/_{name}", f"share/fish/vendor_completions.d/{name}.fish"):
                    self.assertTrue(os.path.getsize(os.path.join(folder, path)) > 200, path)

    def bash(self, *words):
        """What bash offers for the last word."""
        script = ('source "$1"; shift; name=$1; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); compopt() { :; }; '
                  '$(complete -p "$name" | sed "s/.*-F \\([^ ]*\\).*/\\1/"); printf "%s\\n" "${COMPREPLY[@]}"')
        path = os.path.dirname(PROGRAMS["caustic-merge"]) + ":" + os.environ["PATH"]
        done = run("bash", "-c", script, "bash", os.path.join(BUILD, "completions", "bash", words[0]), *words,
                   env={**os.environ, "PATH": path})
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    def test_bash(self):
        self.assertEqual(set(self.bash("caustic-merge", "")), set(help_text.commands(help_text.read(PROGRAMS["caustic-merge"]))))
        self.assertEqual(self.bash("caustic-merge", "nu"), ["nuke"])
        self.assertEqual(self.bash("caustic-merge", "add", "--mut"), ["--mute"])
        self.assertEqual(self.bash("caustic-render", "--estimator", ""), ["auto", "W", "P", "R"])
        for name, program in PROGRAMS.items():
            options = {o for o in help_text.options(help_text.read(program)) if o.startswith("--")}
            self.assertEqual(set(self.bash(name, "x", "--")), options)

    def test_bash_lights(self):
        """Names of lights come out of the pictures on the line."""
        try:
            sys.path.insert(0, os.path.join(SOURCE, "tests", "composite"))
            import numpy
            import exrlib
        except ImportError:
            self.skipTest("no numpy")
        with tempfile.TemporaryDirectory(prefix="caustics_pages_") as folder:
            path = os.path.join(folder, "c.exr")
            zeros = numpy.zeros((2, 3), "<f4")
            exrlib.write(path, [(None, {f"caustics_{n}.{c}": zeros for n in ("key", "rim") for c in "RGB"}, {})])
            self.assertEqual(self.bash("caustic-merge", "add", "b.exr", path, "--mute", ""), ["key", "rim"])
            self.assertEqual(self.bash("caustic-merge", "add", "b.exr", path, "--ev", "k"), ["key="])

    @unittest.skipUnless(shutil.which("fish"), "no fish")
    def test_fish(self):
        script = os.path.join(BUILD, "completions", "fish", "caustic-merge.fish")
        with tempfile.TemporaryDirectory() as home:
            done = run("fish", "--no-config", "-c", f"source {script}; complete -C 'caustic-merge '; complete -C 'caustic-merge add --'",
                       env={**os.environ, "HOME": home})
        offered = {line.split("\t")[0] for line in done.stdout.splitlines()}
        self.assertEqual(done.stderr, "")
        self.assertTrue({"nuke", "recipe", "--from-nuke", "--ev"} <= offered, offered)

    @unittest.skipUnless(shutil.which("zsh"), "no zsh")
    def test_zsh(self):
        """It compiles, and a shell in a terminal completes with it."""
        for name in PROGRAMS:
            script = os.path.join(BUILD, "completions", "zsh", "_" + name)
            self.assertEqual(run("zsh", "-n", script).stderr, "")
        with tempfile.TemporaryDirectory() as home:
            said = self.type_in_zsh(home, f"fpath=({BUILD}/completions/zsh $fpath); autoload -Uz compinit; compinit -u -D; echo RE''ADY\n",
                                    "READY", "caustic-merge nu\t", "nuke")
        self.assertIn("nuke", said)

    def type_in_zsh(self, home, *exchange):
        """Types a text, waits until the shell has shown another, and so on; what it showed, after 30 s at the latest."""
        child, terminal = pty.fork()
        if child == 0:
            os.execvpe("zsh", ["zsh", "-f", "-i"], {**os.environ, "HOME": home, "TERM": "vt100", "PS1": "%% "})
        said, texts = "", list(exchange)
        try:
            while texts:
                os.write(terminal, texts.pop(0).encode())
                awaited, said = texts.pop(0), ""
                while awaited not in said and select.select([terminal], [], [], 30)[0]:
                    said += os.read(terminal, 4096).decode(errors="replace")
        finally:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            os.close(terminal)
        return said


if __name__ == "__main__":
    unittest.main()
