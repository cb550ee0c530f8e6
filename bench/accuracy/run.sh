#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The tables of docs/accuracy.md: direct caustics alone, then all of them, with Cycles where Blender is installed.
# usage: bench/accuracy/run.sh FOLDER_OF_PROGRAMS OUT_FOLDER [SCENE...]
set -euo pipefail
programs=$(realpath "$1")
out=$2
shift 2
mkdir -p "$out"
out=$(realpath "$out")
cd "$(dirname "$0")/../.."
scenes=("$@")
[ ${#scenes[@]} -gt 0 ] || scenes=(a_ball b_ring c_water aquarium)
ladder=(--resolution 160x90 --ladder 1e4,3e4,1e5,3e5 --reference-photons 3e6)
for name in "${scenes[@]}"; do
  for effects in direct direct,indirect; do
    cycles=()
    [ "$effects" = direct ] || cycles=(--cycles scenes/blender_scenes.py)
    "$programs/caustic-accuracy" "scenes/$name.json" "${ladder[@]}" --effects "$effects" "${cycles[@]}" --quiet \
      -o "$out/${name}_${effects/,/_}" >"$out/${name}_${effects/,/_}.md"
  done
done
cat "$out"/*.md
