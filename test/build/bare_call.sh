#!/bin/sh
# Calls a program in a bare Debian, as on a machine that has nothing yet:
#
#   test/build/bare_call.sh RELEASE SYSTEM network|alone COMMAND...
#
# RELEASE is bookworm or trixie, as debootstrap makes it, with git and ca-certificates, below build/debian. SYSTEM is a system over it, where
# what COMMAND writes stays for the next call: build/debian/systems/SYSTEM/written. It begins with a clone of this checkout's last
# commit in /haptics, or of the branch or commit HAPTIC_BARE_COMMIT. The command stands there; `network` is that of this machine, `alone`
# has loopback only. HAPTIC_BARE_USER runs it as that user of the system (made when it is not there), who owns /haptics then.
# HAPTIC_BARE_CACHE is a folder for ccache that several systems share.
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
  [ -z "${HAPTIC_BARE_COMMIT:-}" ] || git -C "$bare/haptics" -c safe.directory='*' checkout -q --detach "$HAPTIC_BARE_COMMIT"
fi
if [ -n "${HAPTIC_BARE_USER:-}" ]; then
  chroot "$bare" id "$HAPTIC_BARE_USER" >/dev/null 2>&1 || chroot "$bare" useradd --create-home "$HAPTIC_BARE_USER"
  chroot "$bare" chown -R "$HAPTIC_BARE_USER:" /haptics
  # shellcheck disable=SC2016 # expanded by the inner shell
  set -- setpriv --reuid="$HAPTIC_BARE_USER" --regid="$HAPTIC_BARE_USER" --init-groups env HOME="/home/$HAPTIC_BARE_USER" "$@"
fi
# shellcheck disable=SC2016 # expanded by the inner shell
enter "$reach" "$bare" sh -c 'cd /haptics && exec "$@"' sh "$@"
