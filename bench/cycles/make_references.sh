#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# What Cycles makes of the caustics: mean and standard error of (on - off) for a few scenes, in reference/.
# make_references.sh [NAME...]; renders that are there already are not made again. See README.md.
set -eu
cd "$(dirname "$0")"
[ $# -gt 0 ] || set -- a_ball_sun5 b_ring d_wineglass plastic_room pool aquarium
for n in "$@"; do
  spp=2048 seeds=8 extra=
  case $n in
    a_ball_sun5) spp=2048 seeds=22 ;;
    b_ring) spp=4096 seeds=22 extra="--off-seeds 4" ;;
    d_wineglass) spp=2048 seeds=36 extra=--groups ;;
    plastic_room) spp=1024 seeds=8 ;;
    pool) spp=1024 seeds=13 ;;
    aquarium) spp=1024 seeds=8 ;;
  esac
  # shellcheck disable=SC2086
  "${PYTHON:-/usr/bin/python3}" reference.py "../../scenes/$n.json" --mode diff -o "reference/$n" --spp $spp \
    --seeds "${SEEDS:-$seeds}" --res 96x54 $extra
done
