#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Makes the pictures of docs/blender.md. Needs build/bin, blender, xvfb, xauth.
set -euo pipefail
cd "$(dirname "$0")/../.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
CAUSTICS_BIN=${CAUSTICS_BIN:-$PWD/build/bin} LIBGL_ALWAYS_SOFTWARE=1 HOME=$work xvfb-run -a -s "-screen 0 1600x1000x24" \
  blender --factory-startup --window-geometry 0 0 1600 1000 --python bench/blender/window.py -- "$work"
cp "$work"/blender_{panel,progress,plan,result,nodes}.png docs/images/
