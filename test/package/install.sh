#!/bin/sh
# Installs the packages of `./run package` in a bare Debian of this release and runs them there:
#   test/package/install.sh [--release bookworm|trixie] [--packages FOLDER] [--earlier FOLDER]
# With a folder of an earlier release's packages it installs those first and the new ones over them, as dpkg upgrades. RELEASE is this
# machine's, and FOLDER build/packages, unless given.
# Needs root, debootstrap and a Debian mirror; about three minutes. Ends with `figure package.install_ok 1`.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd -P)
say() { echo "package: $*" >&2; }
# shellcheck disable=SC1091 # of this machine
release=$(. /etc/os-release && echo "$VERSION_CODENAME") packages=$root/build/packages earlier=''
set_options() {
  while [ $# -gt 0 ]; do
    [ $# -ge 2 ] || { say "$1 needs a value"; exit 2; }
    case $1 in
      --release) release=$2 ;;
      --packages) packages=$(cd "$2" && pwd -P) ;;
      --earlier) earlier=$(cd "$2" && pwd -P) ;;
      *) say "unknown option '$1'"; exit 2 ;;
    esac
    shift 2
  done
}
set_options "$@"
ls "$packages"/*.deb >/dev/null 2>&1 || { say "no packages in $packages: ./run package"; exit 1; }
# shellcheck disable=SC1091 # with the other scripts that make bare systems
. "$root/test/build/bare.sh"
in_own_namespaces "$@"
system=$root/build/debian/systems/package-$release log=$root/build/log/package-install.log
bare=$system/root
trap 'umount --recursive --lazy "$bare" 2>/dev/null; rm -rf --one-file-system "$system"' EXIT
rm -rf --one-file-system "$system"
make_bare "$root/build/debian/$release" "$release" "$log"
mkdir -p "$(dirname "$log")"
mount_over "$root/build/debian/$release" "$system"
mkdir "$bare/debs" && cp "$packages"/*.deb "$bare/debs"
rm -f "$bare"/debs/haptic-panel_*.deb  # rviz and Qt: who only runs the loop goes without
say 'installs'
enter network "$bare" apt-get update >>"$log" 2>&1
if [ -n "$earlier" ]; then
  mkdir "$bare/earlier" && cp "$earlier"/*.deb "$bare/earlier" && rm -f "$bare"/earlier/haptic-panel_*.deb
  enter network "$bare" sh -c 'apt-get install -y --no-install-recommends /earlier/*.deb && dpkg -i /debs/*.deb' >>"$log" 2>&1
fi
enter network "$bare" sh -c 'apt-get install -y --no-install-recommends /debs/*.deb' >>"$log" 2>&1
say 'runs'
# Both libraries, found as the processor asks.
enter alone "$bare" sh -c 'ldconfig -p' | grep -q 'x86-64-v3.*/glibc-hwcaps/x86-64-v3/libhaptic_core.so'
enter alone "$bare" env GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2 /usr/lib/spidar_driver/device_check --version | grep -q 'library baseline'
enter alone "$bare" /usr/lib/spidar_driver/device_check --version | grep -q "library $(grep -qw avx2 /proc/cpuinfo && echo x86-64-v3 || echo baseline)"
enter alone "$bare" timeout 120 roslaunch --skip-log-check haptic_bringup demo.launch rviz:=false seconds:=2 figures:=/figures >>"$log" 2>&1 || { tail -n 20 "$log" >&2; exit 1; }
grep -q "^figure demo.ticks 2000 " "$bare/figures" || { tail -n 20 "$log" >&2; exit 1; }
enter alone "$bare" python3 -c 'import haptic; haptic.World("touch_cube").step()'
enter alone "$bare" sh -c 'test -f /usr/lib/udev/rules.d/60-spidar.rules && test -f /usr/lib/systemd/user/haptics.service && test -x /usr/lib/spidar_driver/motor_guard'
enter network "$bare" sh -c 'apt-get remove -y haptic-core' >>"$log" 2>&1
# dpkg goes on to know a package that has been removed and not purged.
# shellcheck disable=SC2016 # dpkg's field
if [ "$(enter alone "$bare" dpkg-query -W -f '${db:Status-Status}' haptic-bridge 2>/dev/null)" = installed ]; then
  say 'haptic-core went, and haptic-bridge, which needs it, stayed'
  exit 1
fi
# All that needs haptic-core went: of the Python that `import haptic` has compiled nothing stays.
if left=$(find "$bare/usr/lib/python3/dist-packages" -path '*haptic/*' | head -n 1) && [ -n "$left" ]; then
  say "haptic-python went and left ${left#"$bare"}"
  exit 1
fi
echo 'figure package.install_ok 1 1'
