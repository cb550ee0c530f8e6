#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# libFuzzer on the readers of caustic-merge, under ASan and UBSan. An input may take 6 s, and the process 1 GB: the
# sanitizers take that much more than the 2 s and 512 MB that the program may.
# usage: bench/composite/fuzz.sh [MINUTES] [FOLDER]   (30 minutes of CPU time; needs clang, libclang-rt-dev
# and OpenImageIO's tools)
set -euo pipefail
cd "$(dirname "$0")/../.."
minutes=${1:-30} folder=${2:-/tmp/caustics_fuzz}
mkdir -p "$folder/found"
python3=/usr/bin/python3
[ -d "$folder/corpus" ] || $python3 -B bench/composite/fuzz_seeds.py "$folder"

flags=(-g -O1 -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer -I. -Iinclude
  -D_GNU_SOURCE '-DCAUSTICS_VERSION="fuzz"')
read -ra libraries <<<"$(pkg-config --cflags OpenEXR OpenColorIO libpng libjpeg libdeflate jansson | sed 's/-I/-isystem /g')"
objects=()
for source in core/*.c image/*.c composite/*.c bridge/*.cpp bench/composite/fuzz_readers.c; do
  case $source in composite/*_main.c) continue ;; esac
  object=$folder/$(echo "$source" | tr / _).o
  objects+=("$object")
  [ "$object" -nt "$source" ] && [ -z "$(find include core image composite bridge -name '*.h' -newer "$object")" ] && continue
  case $source in
  *.c) clang -std=c17 "${flags[@]}" "${libraries[@]}" -c "$source" -o "$object" ;;
  *) clang++ -std=c++17 "${flags[@]}" "${libraries[@]}" -c "$source" -o "$object" ;;
  esac
done
read -ra link <<<"$(pkg-config --libs OpenEXR OpenColorIO libpng libjpeg libdeflate jansson)"
clang++ -fsanitize=fuzzer,address,undefined "${objects[@]}" "${link[@]}" -lOpenEXRCore -lpthread -o "$folder/fuzz_readers"
export FUZZ_BEAUTY=$folder/beauty.exr FUZZ_CAUSTICS=$folder/caustics.exr FUZZ_OUTPUT=/dev/shm/caustics_fuzz_$$.exr
export ASAN_OPTIONS=allocator_may_return_null=1 LSAN_OPTIONS=suppressions=$PWD/bench/composite/fuzz.supp
unset OCIO
# libFuzzer knows the clock only, and a busy machine gives less. No subshell: that would have times of its own.
spend() {
  times >"$folder/times"
  spent=$(awk -F '[ms ]+' 'END { print int($1 * 60 + $2 + $3 * 60 + $4) }' "$folder/times")
}
spend
before=$spent
while [ $((left = minutes * 60 + before - spent)) -gt 0 ]; do
  "$folder/fuzz_readers" -max_total_time="$left" -timeout=6 -rss_limit_mb=1024 -malloc_limit_mb=8192 -max_len=16384 \
    -artifact_prefix="$folder/found/" -print_final_stats=1 "$folder/corpus"
  spend
done
echo "$((spent - before)) s of CPU time, nothing found"
