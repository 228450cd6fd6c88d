#!/bin/sh
# Installs the packages of `./run package` in a bare Debian 12 and runs them there, as root: test/package/install.sh [FOLDER]
# Needs debootstrap and a Debian mirror; about three minutes. Ends with `figure package.install_ok 1`.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd -P)
bare=${1:-/var/tmp/haptics-bare}
mirror=$(sed -n 's/^deb \(\[[^]]*\] \)*\([^ ]*\) bookworm .*/\2/p; s/^URIs: *//p' /etc/apt/sources.list /etc/apt/sources.list.d/* 2>/dev/null | head -n 1)
say() { echo "package: $*" >&2; }
enter() { chroot "$bare" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive "$@"; }
leave() {
  umount "$bare/dev/shm" "$bare/proc" 2>/dev/null || true
  rm -rf --one-file-system "$bare"
}

[ "$(id -u)" = 0 ] || { say 'needs root, for a chroot'; exit 1; }
ls "$root"/build/packages/*.deb >/dev/null 2>&1 || { say 'no packages in build/packages: ./run package'; exit 1; }
[ ! -e "$bare" ] || { say "$bare exists: take it away, or name another folder"; exit 1; }
trap leave EXIT
say "a bare system in $bare, from ${mirror:=http://deb.debian.org/debian}"
debootstrap --variant=minbase bookworm "$bare" "$mirror" >"$root/build/log/bare.log" 2>&1
# The same sources, proxies and names as here.
for file in /etc/apt/sources.list /etc/apt/sources.list.d /etc/apt/apt.conf.d /etc/apt/trusted.gpg.d /etc/resolv.conf /etc/hosts; do
  [ ! -e "$file" ] || { rm -rf "${bare:?}$file" && cp -rL "$file" "$bare$file"; }
done
grep -q localhost "$bare/etc/hosts" 2>/dev/null || echo '127.0.0.1 localhost' >>"$bare/etc/hosts"
mount -t proc proc "$bare/proc" || { say 'this container may not mount; skipped'; exit 77; }
mkdir -p "$bare/dev/shm" && mount -t tmpfs tmpfs "$bare/dev/shm"
mkdir "$bare/debs" && cp "$root"/build/packages/*.deb "$bare/debs"
rm -f "$bare"/debs/haptic-panel_*.deb  # rviz and Qt: who only runs the loop goes without
say 'installs'
enter apt-get update >>"$root/build/log/bare.log" 2>&1
enter sh -c 'apt-get install -y --no-install-recommends /debs/*.deb' >>"$root/build/log/bare.log" 2>&1
say 'runs'
enter timeout 120 roslaunch --skip-log-check haptic_bringup demo.launch rviz:=false seconds:=2 figures:=/figures >>"$root/build/log/bare.log" 2>&1 && grep -q "^figure demo.ticks 2000 " "$bare/figures" ||
  { tail -n 20 "$root/build/log/bare.log" >&2; exit 1; }
enter python3 -c 'import haptic; haptic.World("touch_cube").step()'
enter sh -c 'test -f /usr/lib/udev/rules.d/60-spidar.rules && test -f /usr/lib/systemd/user/haptics.service && test -x /usr/lib/spidar_driver/motor_guard'
enter sh -c 'apt-get remove -y haptic-core' >>"$root/build/log/bare.log" 2>&1
! enter dpkg -s haptic-bridge >/dev/null 2>&1  # what needs it has gone with it
echo 'figure package.install_ok 1 1'
