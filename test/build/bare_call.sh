#!/bin/sh
# Calls a program in a bare Debian, as on a machine that has nothing yet:
#
#   test/build/bare_call.sh RELEASE SYSTEM network|alone COMMAND...
#
# RELEASE is bookworm or trixie, as debootstrap makes it, with git and ca-certificates, below build/debian. SYSTEM is a system over it, where
# what COMMAND writes stays for the next call: build/debian/systems/SYSTEM/written. It begins with a clone of this checkout's last
# commit in /haptics. The command stands there; `network` is that of this machine, `alone` has loopback only.
# HAPTIC_BARE_CACHE is a folder for ccache that several systems share. With HAPTIC_BARE_DISK=true the disk obeys fsync, as a user's does.
# Exit code 77: this machine cannot. Needs root, debootstrap and iproute2; nothing stays mounted or running.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd -P)
say() { echo "bare_call: $*" >&2; }
# shellcheck source=test/build/bare.sh
. "$root/test/build/bare.sh"
[ $# -ge 4 ] || { say 'usage: test/build/bare_call.sh RELEASE SYSTEM network|alone COMMAND...'; exit 2; }
case $1 in bookworm | trixie) ;; *) say "release '$1' is neither bookworm nor trixie"; exit 2 ;; esac
case $3 in network | alone) ;; *) say "'$3' is neither network nor alone"; exit 2 ;; esac
in_own_namespaces "$@"
release=$1 system=$root/build/debian/systems/$2 reach=$3
shift 3
make_bare "$root/build/debian/$release" "$release" "$root/build/log/debian-$release.log"
mount_over "$root/build/debian/$release" "$system"
bare=$system/root
if [ -n "${HAPTIC_BARE_CACHE:-}" ]; then  # a compiler's cache that several systems share
  mkdir -p "$bare/root/.cache/ccache" && mount --bind "$HAPTIC_BARE_CACHE" "$bare/root/.cache/ccache"
fi
if [ ! -d "$bare/haptics" ]; then
  git -c safe.directory='*' clone -q --no-local "$root" "$bare/haptics"
fi
# shellcheck disable=SC2016 # expanded by the inner shell
enter "$reach" "$bare" sh -c 'cd /haptics && exec "$@"' sh "$@"
