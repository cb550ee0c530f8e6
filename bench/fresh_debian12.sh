#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A fresh clone in a fresh Debian 12: ./demo, then ./test, each with its minutes, installation included.
# usage: bench/fresh_debian12.sh [FOLDER]     (as root; FOLDER is removed at the end unless KEEP=1)
set -euo pipefail
. "$(dirname "$0")/debian_root.sh"
root=${1:-/var/tmp/caustics-debian12}

start=$(seconds)
debian_root bookworm "$root"
clone_into "$root"
report "debootstrap (not counted)" "$start"

failed=0
for command in ./demo ./test; do
  start=$(seconds)
  in_root "$root" sh -c "cd /root/caustics && $command" || { echo "$command failed"; failed=1; }
  report "$command" "$start"
done
[ "${KEEP:-0}" = 1 ] || rm -rf --one-file-system "$root" "$root.log"
exit $failed
