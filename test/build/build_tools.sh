#!/bin/sh
# Each way to build this project that the README names, once, from a clean copy of the sources:
#   build_tools.sh FOLDER [core|cmake|colcon|isolated|install|consumer|sources]...   (default: all of them)
# Tests, benchmarks and the core's second library are left out, and nothing is optimised: the ordinary build does it. The core
# compiles alike in all of them, once where there is a ccache: each has its build folder as deep below the copy, and no debug
# symbols, which name it. `sources` reads each source by itself, with all that it includes.
export PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd -P)
[ $# -ge 1 ] || { echo "usage: $0 FOLDER [core|cmake|colcon|isolated|install|consumer|sources]..." >&2; exit 2; }
mkdir -p "$1"
work=$(cd "$1" && pwd -P)
shift
[ $# -gt 0 ] || set -- core cmake colcon isolated install consumer sources
unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH PYTHONPATH
if command -v ccache >/dev/null; then
  export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_BASEDIR="$work" CCACHE_NOHASHDIR=1
fi

# A clean copy: nothing that another build left in the tree may help this one.
copy=$work/haptics
rm -rf "$copy"
mkdir -p "$copy"
(cd "$root" && tar -cf - --exclude=./build --exclude=./log --exclude=./install --exclude=./.git .) | tar -xf - -C "$copy"
cd "$copy"

quick='-DCMAKE_BUILD_TYPE=None -DHAPTIC_X86_64_V3=OFF'
packages='haptic_core haptic_msgs haptic_description haptic_bringup'
for package in spidar_driver penalty_sim haptic_bridge; do
  [ ! -f "$package/package.xml" ] || packages="$packages $package"
done

expect() {  # WHERE: a shell that sources WHERE/setup.sh finds every package
  # shellcheck disable=SC2016,SC2086 # expanded by the inner shell; one word per package
  sh -c '. "$0/setup.sh"; for package; do rospack find "$package" >/dev/null || exit 1; done' "$1" $packages
}

# Users without catkin: an installed core, found by find_package in the project that the documentation shows.
build_consumer() {
  build core
  ninja -C b/alone/haptic_core install
  cmake -S launch/doc/hello_touch -B b/hello -G Ninja -DCMAKE_PREFIX_PATH="$copy/b/prefix"
  ninja -C b/hello
  b/hello/hello_touch urdf/devices/spidar_g6x3r.yaml | tee b/hello/said
  tail -n 1 b/hello/said | awk '$5 > 0.5 && $5 < 4 { felt = 1 } END { exit !felt }'  # 2 mm into 2000 N/m, by a hand of 500 N/m
}

# shellcheck disable=SC2086 # several words
build() {
  case $1 in
    core)
      cmake -S src -B b/alone/haptic_core -G Ninja $quick -DCMAKE_INSTALL_PREFIX="$copy/b/prefix"
      ninja -C b/alone/haptic_core
      ! grep -q catkin b/alone/haptic_core/CMakeCache.txt ;;  # the core alone must not know of ROS
    cmake)
      cmake -S . -B b/cmake -G Ninja $quick -DCATKIN_ENABLE_TESTING=OFF
      ninja -C b/cmake
      expect b/cmake/devel ;;
    colcon)
      colcon --log-base b/log build --build-base b/colcon --install-base b/colcon_install \
        --event-handlers console_direct- --cmake-args $quick -DCATKIN_ENABLE_TESTING=OFF
      expect b/colcon_install ;;
    isolated)  # as on a machine without librviz-dev: without the panel
      mkdir -p b/isolated
      catkin_make_isolated --source . --build b/isolated --devel b/isolated/devel \
        --cmake-args $quick -DCMAKE_DISABLE_FIND_PACKAGE_rviz=ON -DCATKIN_ENABLE_TESTING=OFF
      expect b/isolated/devel ;;
    install)
      mkdir -p "$work/installed"
      catkin_make_isolated --source . --build b/isolated --devel b/isolated/devel --install \
        --install-space "$work/installed" --cmake-args $quick -DCMAKE_DISABLE_FIND_PACKAGE_rviz=ON -DCATKIN_ENABLE_TESTING=OFF
      expect "$work/installed" ;;
    sources)
      cmake -S . -B b/sources -G Ninja $quick -DHAPTIC_UNITY=OFF -DCATKIN_ENABLE_TESTING=OFF
      ninja -C b/sources haptic_msgs_generate_messages_cpp
      cmake -S . -B b/sources -DCMAKE_EXPORT_COMPILE_COMMANDS=ON
      python3 -c 'import json, sys; print(*("cd {directory} && {command} -fsyntax-only".format(**each) for each in json.load(sys.stdin)), sep="\0", end="")' \
        <b/sources/compile_commands.json | xargs -0 -n 1 -P "$(nproc)" sh -c ;;
    consumer) build_consumer ;;
    *) echo "$0: unknown build '$1'" >&2; return 2 ;;
  esac
}

for tool; do
  echo "build_tools: $tool"
  started=$(date +%s)
  mkdir -p b
  touch b/CATKIN_IGNORE b/COLCON_IGNORE
  set +e  # -e has no effect inside the left side of ||
  (set -e; build "$tool") >"$work/$tool.log" 2>&1 </dev/null
  code=$?
  set -e
  if [ "$code" != 0 ]; then
    tail -n 40 "$work/$tool.log" >&2
    echo "build_tools: $tool failed; all of its output is in $work/$tool.log" >&2
    exit 1
  fi
  echo "build_tools: $tool: $(($(date +%s) - started)) s"
done
rm -rf "$copy/b"
