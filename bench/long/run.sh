#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Long renders: see docs/farms.md.
#   bench/long/run.sh kill [SCENE]   20 kills and goings on, 4 shards joined: the bytes of one render
#   bench/long/run.sh flicker        48 frames of a ball in a moving sun: flicker beside the error in space
# BUILD names the build folder [build]. On two cores some minutes each.
set -euo pipefail
cd "$(dirname "$0")/../.."
program=${BUILD:-build}/bin/caustic-render
case "${1:-}" in
kill) python3 bench/long/kill.py "$program" "scenes/${2:-still_life}.json" ;;
flicker) python3 bench/long/flicker.py "$program" scenes ;;
*)
  sed -n '4,5p' "$0" >&2
  exit 2
  ;;
esac
