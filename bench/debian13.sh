#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds against Embree 4 in a Debian 13 of its own and runs the renderer's tests there.
# usage: bench/debian13.sh [FOLDER] [ctest arguments]     (as root; FOLDER is removed at the end unless KEEP=1)
set -euo pipefail
. "$(dirname "$0")/debian_root.sh"
root=${1:-/var/tmp/caustics-debian13}
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- -L 'core|scene|material|light|render|exact|image|cli|house'

debian_root trixie "$root"
clone_into "$root"
failed=0
in_root "$root" sh -ec '
  cd /root/caustics
  .ci/install build
  apt-get install -y -qq --no-install-recommends python3-numpy python3-openimageio openexr \
    openimageio-tools >/dev/null
  dpkg-query -W -f "\${Package} \${Version}\n" libembree-dev
  cmake -G Ninja -B build -DCAUSTICS_WERROR=OFF
  cmake --build build
  exec ctest --test-dir build --output-on-failure "$@"' - "$@" || failed=1
[ "${KEEP:-0}" = 1 ] || rm -rf --one-file-system "$root" "$root.log"
exit $failed
