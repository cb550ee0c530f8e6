#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The tests of the Blender script in other Blenders than the installed one: the Python package bpy, from PyPI, of the
# versions named (default: 4.2 LTS, 4.5 LTS, 5.0, 5.2 LTS), each with the Python that it is made for. A few hundred MB each.
# usage: bench/hosts/run.sh [VERSION...]     needs build/bin/caustic-merge, python3.11 and for 5.1 on python3.13, python3-numpy
set -euo pipefail
cd "$(dirname "$0")/../.."
merge=${CAUSTIC_MERGE:-$PWD/build/bin/caustic-merge}
cache=${CAUSTICS_BPY:-$PWD/build/bpy}
[ $# -gt 0 ] || set -- '4.2.*' '4.5.*' '5.0.*' '5.2.*'
for version in "$@"; do
  place=$cache/${version//\*/x}
  if [ ! -x "$place/bin/python" ]; then
    case $version in 4.* | 5.0.*) python=python3.11 ;; *) python=python3.13 ;; esac
    "$python" -m venv "$place"
    "$place/bin/pip" install --quiet "bpy==$version"
  fi
  printf '#!/bin/sh\nexec "%s" -B "%s" "$@"\n' "$place/bin/python" "$PWD/bench/hosts/bpy_as_blender.py" >"$place/blender"
  chmod +x "$place/blender"
  echo "bpy $version"
  BLENDER=$place/blender CAUSTIC_MERGE=$merge /usr/bin/python3 -B tests/hosts/test_blender.py
done
