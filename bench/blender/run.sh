#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The add-on's long tests, in the installed Blender: against Cycles, hand-over of meshes, a killed animation, a real window.
# usage: bench/blender/run.sh [against_cycles|lamps|mesh_handover|animation|window|versions]...     needs build/bin; all by default
# versions: the add-on's tests, and the lamps, in other Blenders, those that bench/hosts/run.sh installs into build/bpy.
set -euo pipefail
cd "$(dirname "$0")/../.."
export CAUSTICS_BIN=${CAUSTICS_BIN:-$PWD/build/bin} PYTHONDONTWRITEBYTECODE=1
[ $# -gt 0 ] || set -- against_cycles lamps mesh_handover animation window versions
in_blender() { "${BLENDER:-blender}" -b --factory-startup --python-exit-code 1 --python "$@" | grep -v -e '^Fra:' -e '^Saved'; }
failed=()
try() { # name command...: goes on after a failure
  local name=$1
  shift
  "$@" || { failed+=("$name") && echo "FAILED: $name"; }
}
for what in "$@"; do
  case $what in
  window) try window docs/images/blender.sh ;;
  versions)
    for blender in "${CAUSTICS_BPY:-build/bpy}"/*/blender; do
      version=$(basename "$(dirname "$blender")")
      export BLENDER=$blender CAUSTICS_BLENDER=$blender
      for t in scenes surfaces baking bases edges runs hosting; do try "$version: $t" in_blender "tests/blender_addon/test_$t.py"; done
      try "$version: lamps" in_blender bench/blender/lamps.py
      unset BLENDER CAUSTICS_BLENDER
    done
    ;;
  *) try "$what" in_blender "bench/blender/$what.py" ;;
  esac
done
[ ${#failed[@]} -eq 0 ] || { printf 'failed: %s\n' "${failed[@]}" >&2 && exit 1; }
