#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the pictures of docs/hosts.md. Needs build/bin, openimageio-tools, imagemagick, blender, xvfb, xauth.
set -euo pipefail
cd "$(dirname "$0")/../.."
bin=${CAUSTICS_BIN:-$PWD/build/bin}
images=$PWD/docs/images
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp tests/data/beauty/d_off_ml_groups_crypto_half.exr "$work/beauty.exr"
"$bin/caustic-render" scenes/d_wineglass.json -o "$work/caustics.exr" --resolution 320x180 --photons "${PHOTONS:-4000000}" --quiet
grade=(--ev key=1.5 --tint key=1,0.6,0.25 --ev fill=2)
"$bin/caustic-merge" preview "$work/beauty.exr" -o "$work/1.png" --quiet
"$bin/caustic-merge" add "$work/beauty.exr" "$work/caustics.exr" -o "$work/plain.exr" --preview "$work/2.png" --quiet
"$bin/caustic-merge" add "$work/beauty.exr" "$work/caustics.exr" -o "$work/out.exr" --preview "$work/3.png" --quiet "${grade[@]}"
oiiotool "$work/1.png" "$work/2.png" "$work/3.png" --mosaic:pad=4 3x1 -o "$work/relight.png"
convert "$work/relight.png" -colors 160 -strip "$images/hosts_relight.png"
"$bin/caustic-merge" blender "$work/out.exr" -o "$work/shot.py"
LIBGL_ALWAYS_SOFTWARE=1 HOME=$work xvfb-run -a -s "-screen 0 1280x800x24" blender --factory-startup \
  --window-geometry 0 0 1280 800 --python "$work/shot.py" --python "$images/blender_window.py" -- \
  "$work/beauty.exr" "$work/window.png" >/dev/null
convert "$work/window.png" -trim -colors 96 -strip "$images/hosts_blender.png"
ls -l "$images"/hosts_*.png
