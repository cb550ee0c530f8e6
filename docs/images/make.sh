#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Puts the pictures of ./demo side by side for the README: before, caustics, after. Needs openimageio-tools.
set -euo pipefail
cd "$(dirname "$0")/../.."
PHOTONS=${PHOTONS:-30000000} ./demo
cd build/demo
oiiotool before.png caustics.png after.png --mosaic:pad=6 3x1 -o ../../docs/images/still_life.png
