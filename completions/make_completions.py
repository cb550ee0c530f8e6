# SPDX-License-Identifier: Apache-2.0
"""Writes the completions of PROGRAM for bash, zsh and fish, from what it says under --help.
usage: make_completions.py PROGRAM OUT_FOLDER"""
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "man"))
import help_text  # noqa: E402

LIGHT = re.compile(r"NAME(=|$)")  # a value that begins with a light's name
LIGHT_OPTIONS = re.compile(r"--(gain|ev|tint|mute|solo|temperature|saturation)$")

BASH = '''# SPDX-License-Identifier: Apache-2.0
# Completion of {name} for bash.
_{id}() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} file
  case $before in
{cases}  esac
  if [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W '{options}' -- "$word"))
{commands}  else
    compopt -o filenames 2>/dev/null
    COMPREPLY=($(compgen -f -- "$word"))
  fi
}}
complete -F _{id} {name}
'''
BASH_LIGHTS = '''  {options})
    # The lights of the pictures that were named so far.
    COMPREPLY=($(for file in "${{COMP_WORDS[@]}}"; do
      [[ -f $file && $file == *.exr ]] && {name} list "$file" 2>/dev/null
    done | sed -n 's/^light \\([^ :]*\\): radiance.*/\\1{end}/p' | sort -u | while read -r file; do
      compgen -W "$file" -- "$word"
    done))
    {nospace}return ;;
'''
ZSH = '''#compdef {name}
# SPDX-License-Identifier: Apache-2.0
# Completion of {name} for zsh.
_arguments -s \\
{lines}
'''
FISH = '''# SPDX-License-Identifier: Apache-2.0
# Completion of {name} for fish.
{lines}
'''


def choices(value):
    """auto|P|R"""
    return value.split("|") if "|" in value else []


def is_file(value):
    return bool(re.search(r"FILE|OUT|\.png|\.json|\.exr|\.nk|CONFIG|SCENE|SCRIPT", value))


def bash(name, options, commands):
    cases, lights = "", {n: v for n, v in options.items() if LIGHT_OPTIONS.match(n)}
    for end in ("=", ""):
        group = [n for n, v in lights.items() if v.startswith("NAME") and ("=" in v) == bool(end)]
        if group:
            nospace = "compopt -o nospace 2>/dev/null\n    " if end else ""
            cases += BASH_LIGHTS.format(options=" | ".join(group), name=name, end=end, nospace=nospace)
    for option, value in options.items():
        if choices(value):
            cases += f"  {option})\n    COMPREPLY=($(compgen -W '{' '.join(choices(value))}' -- \"$word\"))\n    return ;;\n"
        elif value and option not in lights and not is_file(value):
            cases += f"  {option}) return ;;\n"
    first = f"  elif (( COMP_CWORD == 1 )); then\n    COMPREPLY=($(compgen -W '{' '.join(commands)}' -- \"$word\"))\n" if commands else ""
    return BASH.format(name=name, id=name.replace("-", "_"), cases=cases, options=" ".join(options), commands=first)


def about(option, text):
    """The help's words on an option, where it stands alone in its line."""
    for block in help_text.blocks(text):
        for entry in block.entries:
            if list(entry.options()) == [option] and entry.left.startswith(option):
                return entry.text
    return ""


def zsh_quote(text):
    return re.sub(r"([\[\]:\\])", r"\\\1", text).replace("'", "'\\''")


def zsh(name, options, commands, text):
    lines = []
    for option, value in options.items():
        line = option + (f"[{zsh_quote(about(option, text))}]" if about(option, text) else "")
        if value:
            what = f"({' '.join(choices(value))})" if choices(value) else "_files" if is_file(value) else ""
            line += f":{zsh_quote(value)}:{what}"
        lines.append(f"  '*{line}' \\")
    if commands:
        lines.append(f"  '1:command:({' '.join(commands)})' \\")
    return ZSH.format(name=name, lines="\n".join(lines) + "\n  '*:file:_files'")


def fish_quote(text):
    return text.replace("\\", "\\\\").replace("'", "\\'")


def fish(name, options, commands, text):
    lines = []
    for option, value in options.items():
        short = "-l " + option[2:] if option.startswith("--") else "-s " + option[1:]
        line = f"complete -c {name} {short}"
        if value:
            line += " -r" + (f" -f -a '{' '.join(choices(value))}'" if choices(value) else " -F" if is_file(value) else " -f")
        if about(option, text):
            line += f" -d '{fish_quote(about(option, text))}'"
        lines.append(line)
    for command, what in commands.items():
        lines.append(f"complete -c {name} -n __fish_use_subcommand -a {command} -d '{fish_quote(what)}'")
    return FISH.format(name=name, lines="\n".join(lines))


def main():
    program, folder = sys.argv[1:]
    name, text = os.path.basename(program), help_text.read(program)
    options, commands = help_text.options(text), help_text.commands(text)
    for path, script in ((f"bash/{name}", bash(name, options, commands)), (f"zsh/_{name}", zsh(name, options, commands, text)),
                         (f"fish/{name}.fish", fish(name, options, commands, text))):
        os.makedirs(os.path.dirname(os.path.join(folder, path)), exist_ok=True)
        with open(os.path.join(folder, path), "w", encoding="utf-8") as file:
            file.write(script)


main()
