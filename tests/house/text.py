# SPDX-License-Identifier: Apache-2.0
"""Licence lines, lengths, links, and words that do not belong in the project."""
import re

from house import ROOT, finish, lines, tracked

FILE_MAX, TEST_FILE_MAX = 500, 650
FUNCTION_MAX = 60  # lines; most are far below
SOURCES = (".c", ".h", ".cpp", ".def", ".py", ".sh", ".cmake")
MACHINE_PATH = re.compile(r"(?<![\w.$}])/(work|home|Users|mnt|shared)/")
LIBRARY = re.compile(r"(core|image|bridge|render|composite)/(?!.*_main\.c|cli/)")
ENDS_THE_HOST = re.compile(r"\b(exit|_exit|abort|quick_exit)\s*\(")

problems = []


def check_functions(path, text):
    start = None
    for number, line in enumerate(text, 1):
        if line.endswith("{") and not line.startswith((" ", "}", "#", "extern")) and "(" in "".join(text[max(0, number - 3) : number]):
            start = number
        elif line == "}" and start:
            if number - start > FUNCTION_MAX:
                problems.append(f"{path}:{start}: a function of {number - start} lines, limit {FUNCTION_MAX}")
            start = None


def check_source(path, text):
    if not any("SPDX-License-Identifier: Apache-2.0" in line for line in text[:3]):
        problems.append(f"{path}: no SPDX licence line at its top")
    if path.suffix not in (".c", ".h", ".cpp"):
        return
    limit = TEST_FILE_MAX if path.parts[0] == "tests" else FILE_MAX
    if len(text) > limit:
        problems.append(f"{path}: {len(text)} lines, limit {limit}")
    if path.parts[0] != "tests":
        check_functions(path, text)
    if LIBRARY.match(str(path)):
        for number, line in enumerate(text, 1):
            if ENDS_THE_HOST.search(re.sub(r'"[^"]*"|/\*.*?\*/|^\s*\*.*', "", line)):
                problems.append(f"{path}:{number}: a library never ends its host")


def check_links(path, text):
    for number, line in enumerate(text, 1):
        for target in re.findall(r"\]\(([^)#:\s]+)\)", line):
            if not (ROOT / path.parent / target).exists():
                problems.append(f"{path}:{number}: a link to {target}, which does not exist")


count = 0
for path in tracked():
    try:
        text = lines(path)
    except UnicodeDecodeError:
        continue
    count += 1
    for number, line in enumerate(text, 1):
        if MACHINE_PATH.search(line):
            problems.append(f"{path}:{number}: a path of one machine")
    if path.suffix == ".md":
        check_links(path, text)
    if path.name.endswith(SOURCES):
        check_source(path, text)
finish(problems, f"{count} text files")
