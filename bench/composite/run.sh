#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What the tests do in small, in full: 200 random cases against numpy, 200 kills, then speed and memory.
# usage: bench/composite/run.sh [BUILD] [FOLDER]   (a finished build with caustic-merge; about 7 GB free in FOLDER)
set -euo pipefail
cd "$(dirname "$0")/../.."
build=${1:-build} folder=${2:-/tmp/caustics_bench}
mkdir -p "$folder"
CAUSTIC_MERGE=$(realpath "$build/bin/caustic-merge")
export CAUSTIC_MERGE
/usr/bin/python3 -B tests/composite/random_cases.py --count 200 --seed 1000
CAUSTICS_KILLS=200 /usr/bin/python3 -B tests/composite/test_files.py -v Output.test_kill_leaves_old_or_new
read -ra flags <<<"$(pkg-config --cflags --libs OpenEXR)"
cc -O2 -std=c17 bench/composite/bare_core.c -o "$folder/bare_core" "${flags[@]}" -lOpenEXRCore
/usr/bin/python3 -B bench/composite/speed.py "$CAUSTIC_MERGE" "$folder/bare_core" "$folder"
