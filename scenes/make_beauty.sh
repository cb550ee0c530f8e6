#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Render the beauties, caustics off, that stand in scenes/beauty/: make_beauty.sh SCENE... (default: all of them).
# Each is a half MultiLayer EXR with a light group per layer; samples as in the table. Needs Blender 3.4 or later.
set -eu
cd "$(dirname "$0")"
samples() {
  case $1 in
    c_water) echo 16 ;;
    a_ball | b_ring) echo 512 ;;
    d_wineglass | still_life) echo 1024 ;;
    aquarium) echo 512 ;;
    *) echo 256 ;;
  esac
}
[ $# -gt 0 ] || set -- a_ball b_ring c_water d_wineglass still_life aquarium pool
mkdir -p beauty
for s in "$@"; do
  log=$(mktemp)
  nice -n 19 "${BLENDER:-blender}" -b --factory-startup --python blender_scenes.py -- --scene "$s.json" --mode off \
    --spp "$(samples "$s")" --res 480x270 --multilayer --half --groups --threads "${THREADS:-1}" \
    --out "beauty/$s.incomplete.exr" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
  grep -E '^(JOB|WARNING)' "$log"
  rm -f "$log"
  mv "beauty/$s.incomplete.exr" "beauty/$s.exr"
done
