# shellcheck shell=sh
# A bare Debian in a folder: debootstrap's smallest, with git and ca-certificates, to try this project where nothing is installed yet.
# Sourced by scripts that define `say`; needs root and the package debootstrap.
#
# The script runs in name spaces of its own: its mounts are not seen outside, and the kernel ends its processes and takes its mounts
# away with it, whatever ends it.

# Calls the script again inside. Exit code 77, here and below: this machine cannot (no root, no mounts, no mirror).
in_own_namespaces() {  # ARGUMENTS of the script
  [ -z "${HAPTIC_BARE_INSIDE:-}" ] || return 0
  [ "$(id -u)" = 0 ] || { say 'needs root, for a chroot'; exit 77; }
  command -v debootstrap >/dev/null || { say 'debootstrap is not installed: ./run setup test'; exit 77; }
  unshare --mount --pid --fork true 2>/dev/null || { say 'this container may not mount; skipped'; exit 77; }
  HAPTIC_BARE_INSIDE=1 setpriv --pdeathsig KILL unshare --mount --pid --fork --kill-child "$0" "$@" &
  trap 'kill -KILL "$!"' INT TERM HUP
  wait "$!" && exit
  exit "$?"
}

# Where apt of this machine has Debian from. LABEL: Debian or Debian-Security.
debian_site() {
  # shellcheck disable=SC2016 # a field of apt's
  apt-get indextargets --format '$(REPO_URI)' 'Identifier: Packages' 'Origin: Debian' "Label: $1" | head -n 1
}

# What is written over LOWER lands in UPPER; UPPER/../root shows both. dpkg asks the disk to finish after each file, milliseconds
# each: a disk whose machine is thrown away at a crash need not. With HAPTIC_BARE_DISK it does, for times that users see.
overlay() {  # LOWER FOLDER
  mkdir -p "$2/written" "$2/work" "$2/root"
  rm -rf "$2/work/work/incompat"  # the mark of an earlier mount, which would have this one refused
  mount -t overlay overlay -o "lowerdir=$1,upperdir=$2/written,workdir=$2/work$([ -n "${HAPTIC_BARE_DISK:-}" ] || echo ,volatile)" "$2/root" ||
    { say 'this machine has no overlay file system; skipped'; exit 77; }
}

# A whole system or none: one that was interrupted is made again.
make_bare() {  # FOLDER RELEASE LOG
  [ ! -e "$1" ] || return 0
  mirror=$(debian_site Debian) security=$(debian_site Debian-Security)
  [ -n "$mirror" ] || { say 'apt here knows no mirror of Debian: apt-get update'; exit 77; }
  say "a bare $2 in $1, from $mirror"
  rm -rf "$1.part" "$1.made"
  mkdir -p "$(dirname "$3")" "$1.made/nothing"
  overlay "$1.made/nothing" "$1.made"
  debootstrap --variant=minbase --include=git,ca-certificates "$2" "$1.made/root" "$mirror" >"$3" 2>&1 || { tail -n 20 "$3" >&2; say "debootstrap failed; see $3"; exit 77; }
  umount --recursive "$1.made/root"
  mv "$1.made/written" "$1.part"
  rm -rf "$1.made"
  {
    echo "deb $mirror $2 main"
    echo "deb $mirror $2-updates main"
    [ -z "$security" ] || echo "deb $security $2-security main"
  } >"$1.part/etc/apt/sources.list"
  apt-config dump Acquire::http >"$1.part/etc/apt/apt.conf.d/10proxy"
  cp -L /etc/apt/trusted.gpg.d/* "$1.part/etc/apt/trusted.gpg.d" 2>/dev/null || true  # keys of a mirror that has its own
  cp -L /etc/resolv.conf "$1.part/etc/resolv.conf"
  printf '127.0.0.1 localhost %s\n::1 localhost\n' "$(hostname)" >"$1.part/etc/hosts"
  mv "$1.part" "$1"
}

# A system of its own over a bare one, which stays as it is: FOLDER/root, with what it writes in FOLDER/written.
mount_over() {  # BARE FOLDER
  overlay "$1" "$2"
  mount_kernel "$2/root"
}

# What programs find on every machine.
mount_kernel() {  # FOLDER
  mount -t proc proc "$1/proc"
  mount -t sysfs -o ro sysfs "$1/sys"
  mount -t devpts -o newinstance,ptmxmode=0666 devpts "$1/dev/pts"
  mkdir -p "$1/dev/shm"
  mount -t tmpfs tmpfs "$1/dev/shm"
}

# network: that of this machine. alone: loopback only, and every port free.
enter() {  # network|alone FOLDER COMMAND...
  reach=$1 folder=$2
  shift 2
  set -- chroot "$folder" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root TERM="${TERM:-dumb}" \
    DEBIAN_FRONTEND=noninteractive "$@"
  # shellcheck disable=SC2016 # expanded by the inner shell
  [ "$reach" = network ] || set -- unshare --net sh -c 'ip link set lo up && exec "$@"' sh "$@"
  "$@"
}
