# SPDX-License-Identifier: Apache-2.0
"""Writes a man page: the text of TEMPLATE, with @OPTIONS@ made from what PROGRAM says under --help.
usage: make_page.py PROGRAM TEMPLATE VERSION OUT"""
import re
import sys

import help_text


def roff(text):
    """Characters that roff would take for its own."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("^", "\\(ha").replace("~", "\\(ti")
    return re.sub(r"^([.'])", r"\\&\1", text)


def bold(left):
    """Options and commands bold, what they take in italics."""
    return "".join(part if part.isspace() else
                   (r"\fB%s\fR" if re.match(r"--?[a-z]|[a-z]+$", part) else r"\fI%s\fR") % roff(part)
                   for part in re.split(r"(\s+)", left))


def options(text):
    lines = []
    for block in help_text.blocks(text):
        entries = [e for e in block.entries if e.options() or help_text.commands(f"  {e.left}  {e.text}")]
        if not entries:
            continue
        if block.title:
            lines += [".SS " + roff(block.title)]
        for entry in entries:
            lines += [".TP", bold(entry.left), roff(entry.text) if entry.text else r"\&"]
    return "\n".join(lines)


def main():
    program, template, version, out = sys.argv[1:]
    with open(template, encoding="utf-8") as file:
        page = file.read()
    page = page.replace("@VERSION@", version).replace("@OPTIONS@", options(help_text.read(program)))
    with open(out, "w", encoding="utf-8") as file:
        file.write(page)


main()
