#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Render the small beauties (caustics off) of this folder again: make_tests.sh [NAME...]. See README.md.
set -eu
cd "$(dirname "$0")"
ref="../../../bench/cycles/reference.py"
[ $# -gt 0 ] || set -- orthographic shift spot_blend area_spread plastic sun10 exposure2 filter_box filter_gauss filter_bh \
  a_ball b_ring d_wineglass c_water rough cards emission plastic_rough plastic_principled plastic_rough_principled
for n in "$@"; do
  res=80x45 spp=1024 scene=$n.json
  case $n in
    filter_*) res=64x36 ;;
    [a-d]_*) res=96x54 scene=../../../scenes/$n.json ;;
  esac
  [ "$n" != c_water ] || spp=64
  "${PYTHON:-/usr/bin/python3}" "$ref" "$scene" --mode off -o "./$n" --spp $spp --seeds 8 --res $res
done
