# SPDX-License-Identifier: Apache-2.0
# Sourced by fresh_debian12.sh and debian13.sh: a Debian of its own in a folder, and commands run inside it.
# Needs root and debootstrap. Packages come from the mirror that this machine's apt uses.

repository=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# debian_root SUITE FOLDER: a minimal system, nothing but what debootstrap installs.
debian_root() {
  local suite=$1 root=$2 mirror
  [ "$(id -u)" = 0 ] || { echo "must run as root" >&2; return 1; }
  command -v debootstrap >/dev/null || { echo "please install debootstrap" >&2; return 1; }
  [ ! -e "$root/etc" ] || { echo "$root exists; remove it first" >&2; return 1; }
  # shellcheck disable=SC2016 # apt fills these in
  mirror=$(apt-get indextargets --format '$(ORIGIN) $(CODENAME) $(REPO_URI)' 'Identifier: Packages' |
    awk '$1 == "Debian" && $2 !~ /-/ {print $3; exit}')
  [ -n "$mirror" ] || { echo "apt knows no Debian mirror" >&2; return 1; }
  mkdir -p "$root"
  proxy_environment
  debootstrap --variant=minbase --include=ca-certificates "$suite" "$root" "$mirror" >"$root.log" 2>&1 ||
    { tail -20 "$root.log" >&2; return 1; }
  # The machine's way to the mirror: proxies, certificates, checks.
  apt-config dump | grep -E '^Acquire::(https?|ftp|Check|Retries)' >"$root/etc/apt/apt.conf.d/00mirror" || true
  cp -rp /etc/apt/auth.conf.d "$root/etc/apt/" 2>/dev/null || true
  cp /etc/resolv.conf "$root/etc/" 2>/dev/null || true
}

proxy_environment() {
  local proxy
  eval "$(apt-config shell proxy Acquire::http::Proxy)"
  [ -z "${proxy:-}" ] || export http_proxy=$proxy
}

# in_root FOLDER COMMAND...: with /proc and /dev, in a mount namespace that takes its mounts along when it ends.
in_root() {
  local root=$1
  shift
  # shellcheck disable=SC2016 # the inner shell fills these in
  unshare --mount --fork bash -c '
    root=$1; shift
    mount -t proc proc "$root/proc"
    for d in null zero full random urandom tty; do touch "$root/dev/$d"; mount --bind "/dev/$d" "$root/dev/$d"; done
    mkdir -p "$root/dev/pts" && mount --bind /dev/pts "$root/dev/pts"
    mkdir -p "$root/dev/shm" && mount -t tmpfs tmpfs "$root/dev/shm"
    exec env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 \
      TERM=dumb chroot "$root" "$@"' - "$root" "$@"
}

# clone_into FOLDER: the committed state of the repository as /root/caustics.
clone_into() {
  git clone -q --no-local "$repository" "$1/root/caustics"
}

seconds() { date +%s; }

# report NAME START: one line with the minutes since START.
report() { awk -v n="$1" -v s="$2" -v e="$(seconds)" 'BEGIN {printf "%s: %.1f minutes\n", n, (e - s) / 60}'; }
