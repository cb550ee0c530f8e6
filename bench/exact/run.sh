#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The long versions of tests/exact and tests/hard, one command each; each prints a table and fails when a row is wrong.
#   bench/exact/run.sh answers|flux|kernels|wave|agreement [SCENE... [--estimators P]]|coverage [SCENE...]|lights|memory|hard|rays|all
# BUILD names the build folder [build]. Minutes each on two cores, answers one hour; agreement half a day, with PATHS=5e6 three hours.
set -euo pipefail
cd "$(dirname "$0")/../.."
build=$PWD/${BUILD:-build}
export CAUSTIC_RENDER="$build/bin/caustic-render" PYTHONPATH="$PWD/tests/exact" PYTHONDONTWRITEBYTECODE=1
python=/usr/bin/python3
scenes=(a_ball_sun5 b_ring d_wineglass still_life plastic_room aquarium pool a_ball c_water)

case "${1:-}" in
answers) $python tests/exact/exact_answers.py 8 ;;
flux) EFFORT=20 $python tests/exact/flux_account.py ;;
kernels) EFFORT=8 $python tests/exact/kernels.py ;;
wave) EFFORT=8 $python tests/exact/wave.py ;;
agreement)
  shift
  for soft in "" --soft; do
    $python tests/exact/agreement.py "${PHOTONS:-4e6}" "${PATHS:-1e7}" --seeds 8 $soft "${@:-${scenes[@]}}" || failed=1
  done
  exit "${failed:-0}"
  ;;
coverage)
  shift
  $python tests/exact/coverage.py "${PHOTONS:-1e6}" "${LONG:-3e7}" "${@:-${scenes[@]}}"
  ;;
lights) $python tests/exact/lights.py ;;
memory) $python tests/exact/lights.py memory 1e6 1e8 ;;
hard) $python tests/hard/hard_scenes.py ;;
rays) RAYS=400000 "$build/bin/test_rays" ;;
all) for part in answers flux kernels wave lights hard rays memory agreement; do
  echo "== $part"
  "$0" "$part" || failed=1
done
  exit "${failed:-0}" ;;
*)
  sed -n '3,5s/^# \?//p' "$0"
  exit 2
  ;;
esac
