#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Speed, in CPU time: see docs/benchmarks.md.
#   bench/speed/run.sh throughput [SCENE...]   photons against bare Embree on the same rays; where a pass spends its time
#   bench/speed/run.sh shares [SCENE...]       smooth, rough, indirect: share of the dropped light, seconds to 5 %
#   bench/speed/run.sh memory [SCENE]          peak memory against picture size
#   bench/speed/run.sh ball [RAYS...]          error against seconds at a glass ball's exact caustic, W beside P
#   bench/speed/run.sh peers [SCENE...]        ball lens, mirror ring, water: W, P and POV-Ray to relMSE 1e-2, 1e-3, 1e-4
#   bench/speed/run.sh scenes [SCENE...]       bundled scenes a to d at 160x90 to nMSE .01
#   bench/speed/run.sh scaling [PART...]       threads, triangles, lights, photons: seconds and memory
# BUILD names the build folder [build-bench]. On two cores a minute, shares ten, peers half an hour.
set -euo pipefail
cd "$(dirname "$0")/../.."
build=${BUILD:-build-bench}
[[ $build = /* ]] || build=$PWD/$build
what=${1:-}
shift || true

make() {
  cmake -G Ninja -B "$build" -DCAUSTICS_TESTS=OFF \
    -DCMAKE_PROJECT_caustics_INCLUDE="$PWD/bench/speed/throughput.cmake" > /dev/null
  cmake --build "$build" --target "$1" > /dev/null
}

case "$what" in
throughput)
  make throughput
  [ $# -gt 0 ] || set -- aquarium still_life plastic_room pool
  for scene in "$@"; do
    printf '\n**%s**\n\n' "$scene"
    "$build/bin/throughput" "scenes/$scene.json"
  done
  ;;
shares)
  make caustic-render
  [ $# -gt 0 ] || set -- aquarium still_life plastic_room
  CAUSTIC_RENDER="$build/bin/caustic-render" PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 bench/speed/shares.py "$@"
  ;;
memory)
  make caustic-render
  CAUSTIC_RENDER="$build/bin/caustic-render" /usr/bin/python3 bench/speed/memory.py "$@"
  ;;
scaling)
  make caustic-render
  CAUSTIC_RENDER="$build/bin/caustic-render" PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 bench/speed/scaling.py "$@"
  ;;
ball | peers | scenes)
  make caustic-render
  [ "$what" = ball ] || set -- --cache "$build/truth" "$@"
  CAUSTIC_RENDER="$build/bin/caustic-render" PYTHONDONTWRITEBYTECODE=1 /usr/bin/python3 "bench/speed/$what.py" "$@"
  ;;
*)
  sed -n '3,11s/^# \{0,1\}//p' "$0"
  exit 2
  ;;
esac
