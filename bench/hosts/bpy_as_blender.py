# SPDX-License-Identifier: Apache-2.0
"""Takes the options of the program blender that the tests use, and does the same with the Python package bpy."""
import runpy
import sys
import traceback

words = sys.argv[1:]
import bpy  # noqa: E402  takes sys.argv for its own


def run(code):
    try:
        code()
    except Exception:
        traceback.print_exc()
        sys.exit(3)


sys.argv = ["blender", *words]
while words:
    word = words.pop(0)
    if word == "--":
        break
    if word in ("-b", "--factory-startup", "--disable-autoexec"):
        continue
    if word == "--python-exit-code":
        words.pop(0)
    elif word == "--python":
        path = words.pop(0)
        run(lambda: runpy.run_path(path, run_name="__main__"))
    elif word == "--python-expr":
        text = words.pop(0)
        run(lambda: exec(text, {"__name__": "__main__"}))
    else:
        run(lambda: bpy.ops.wm.open_mainfile(filepath=word, use_scripts=False))
