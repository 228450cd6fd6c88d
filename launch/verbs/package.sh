#!/bin/sh
#: package           Debian packages of the stack, with what they depend on, udev rule and systemd user unit:
#:                   build/packages/*.deb, to be installed by `apt install ./haptic-*.deb ./penalty-*.deb ./spidar-*.deb`
. "$(dirname "$0")/parts/start.sh"
judge package -- "$@"
at_most 0 package 'no words'
SETUP_BUILDS=all
setup run view python package
build_stack all
# The same build, installed elsewhere: nothing is compiled again.
rm -rf "$BUILD/packages"
# shellcheck disable=SC2016 # expanded by the inner shell
with_progress_or_log package "$LOGS/package.log" sh -c '
  cmake "$1" -DHAPTIC_PACKAGES=ON -DCMAKE_INSTALL_PREFIX=/usr -DCATKIN_BUILD_BINARY_PACKAGE=ON && ninja -C "$1" package &&
    exec cmake "$1" -DHAPTIC_PACKAGES=OFF -DCATKIN_BUILD_BINARY_PACKAGE=OFF -UCMAKE_INSTALL_PREFIX' sh "$BUILD"
find "$BUILD/packages" -name '*.deb' | sort
