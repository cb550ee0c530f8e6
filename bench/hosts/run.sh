#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The tests of the Blender script in other Blenders than the installed one: the Python package bpy, from PyPI, of the
# versions named (default: 4.2 LTS, 4.5 LTS, 5.0), which python3.11 can load. A few hundred MB each.
# usage: bench/hosts/run.sh [VERSION...]     needs build/bin/caustic-merge, python3.11, python3-numpy
set -euo pipefail
cd "$(dirname "$0")/../.."
merge=${CAUSTIC_MERGE:-$PWD/build/bin/caustic-merge}
cache=${CAUSTICS_BPY:-$PWD/build/bpy}
[ $# -gt 0 ] || set -- '4.2.*' '4.5.*' '5.0.*'
for version in "$@"; do
  place=$cache/${version//\*/x}
  if [ ! -x "$place/bin/python" ]; then
    python3.11 -m venv "$place"
    "$place/bin/pip" install --quiet "bpy==$version"
  fi
  printf '#!/bin/sh\nexec "%s" -B "%s" "$@"\n' "$place/bin/python" "$PWD/bench/hosts/bpy_as_blender.py" >"$place/blender"
  chmod +x "$place/blender"
  echo "bpy $version"
  BLENDER=$place/blender CAUSTIC_MERGE=$merge /usr/bin/python3 -B tests/hosts/test_blender.py
done
