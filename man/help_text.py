# SPDX-License-Identifier: Apache-2.0
"""What a program's --help says, taken apart: man pages and completions are made from it, so they cannot drift."""
import re
import subprocess
from dataclasses import dataclass, field

OPTION = re.compile(r"(?<![\w-])(--?[a-z][a-z-]*)(?: ([A-Za-z#%][^\s]*))?")


@dataclass
class Entry:
    """One line of help, with those that go on."""
    left: str
    text: str

    def options(self):
        """{option: placeholder of its value, or ""}"""
        return {name: value.rstrip(",") for name, value in OPTION.findall(self.left)}


@dataclass
class Block:
    """Entries under a title; other lines between them are entries without a text."""
    title: str = ""
    entries: list = field(default_factory=list)


def read(program):
    return subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout


def split(line):
    """The two columns of a line."""
    left, _, right = line.strip().partition("  ")
    while right.strip().startswith("-"):  # several options side by side
        more, _, rest = right.strip().partition("  ")
        left, right = f"{left}   {more}", rest
    return left, right.strip()


def blocks(text):
    out, titled = [Block()], False
    for line in text.splitlines():
        if not line.strip():
            out.append(Block())
            titled = False
        elif not line.startswith(" "):
            if out[-1].entries or titled:
                out.append(Block())
            out[-1].title, titled = line.strip(), True
        elif re.match(" {12}", line) and out[-1].entries:
            out[-1].entries[-1].text += (" " if out[-1].entries[-1].text else "") + line.strip()
        else:
            out[-1].entries.append(Entry(*split(line)))
    return [b for b in out if b.title or b.entries]


def options(text):
    """{option: placeholder or ""} of the whole help."""
    found = {}
    for block in blocks(text):
        for entry in block.entries:
            beside = {n: v.rstrip(",;:)") for n, v in OPTION.findall(entry.text) if n.startswith("--")}
            for name, value in {**beside, **entry.options()}.items():
                found[name] = found.get(name) or value
    return found


def commands(text):
    """Lower-case words that begin an entry: "add BEAUTY", "nuke FILE, blender FILE"."""
    found = {}
    for block in blocks(text):
        for entry in block.entries if not block.title else ():
            pieces = [p.split() for p in entry.left.split(",")]
            if all(p and re.fullmatch("[a-z]+", p[0]) for p in pieces) and entry.text:
                found.update({p[0]: entry.text for p in pieces})
    return found
