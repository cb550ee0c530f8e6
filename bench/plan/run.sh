#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Does the plan choose the better estimator? W and P, each forced, on scenes that nobody chose: see plan.py.
#   bench/plan/run.sh [--seconds S] [--out FILE.json] [SEED...]   70 scenes in a quarter of an hour on an idle core
#   bench/plan/run.sh --hard [--seconds S]                    what wavefronts are bad at
#   bench/plan/run.sh --race [--hard] [--seconds S] [SEED...] seconds to an error, the plan beside each alone: see race.py
# BUILD names the build folder [build-bench].
set -euo pipefail
cd "$(dirname "$0")/../.."
build=${BUILD:-build-bench}
[[ $build = /* ]] || build=$PWD/$build
if ! [ -x "$build/bin/caustic-render" ]; then
  cmake -G Ninja -B "$build" -DCAUSTICS_TESTS=OFF > /dev/null
fi
cmake --build "$build" --target caustic-render > /dev/null
export CAUSTIC_RENDER="$build/bin/caustic-render" PYTHONDONTWRITEBYTECODE=1
program=plan.py
[ "${1:-}" = --race ] && shift && program=race.py
exec /usr/bin/python3 "bench/plan/$program" "$@"
