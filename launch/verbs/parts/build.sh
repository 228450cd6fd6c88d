# Configuring and building below build/, and using what was built. Sourced.

# A shell that has sourced another ROS workspace would build against it.
forget_other_workspaces() {
  unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH ROSLISP_PACKAGE_DIRECTORIES PYTHONPATH PYTHONHOME LD_LIBRARY_PATH
  unset ROS_MASTER_URI ROS_IP ROS_HOSTNAME
  if command -v ccache >/dev/null; then
    # Paths below the repository count as relative: another checkout of it finds the same.
    export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
    export CCACHE_BASEDIR="${CCACHE_BASEDIR:-$ROOT}" CCACHE_NOHASHDIR=1
  fi
}

# A second call costs what ninja needs to see that nothing changed.
configure_and_build() {  # TITLE SOURCE BUILD_FOLDER TARGETS [CMAKE_OPTIONS]
  title=$1 source=$2 folder=$3 targets=$4
  shift 4
  # shellcheck disable=SC2016 # expanded by the inner shell
  with_progress_or_log "$title" "$LOGS/$title.log" sh -c '
    source=$1 folder=$2 targets=$3 plan=$4
    shift 4
    [ -f "$folder/build.ninja" ] || cmake -S "$source" -B "$folder" -G Ninja "$@" || exit 1
    # For the progress line: the objects that are not there. (A dry run ends where the globs would be looked at.)
    (cd "$folder" && ninja -t inputs $targets | grep "\\.o$" | while read -r object; do
      [ -f "$object" ] || echo "$object"
    done) >"$plan.new"
    mv "$plan.new" "$plan"
    exec ninja -C "$folder" $targets' sh "$source" "$folder" "$targets" "$LOGS/$title.plan" "$@"
}

# The stack in build/. Tests are configured from the first call on that asks for them: they need more packages.
build_stack() {  # TARGETS [CATKIN_ENABLE_TESTING]
  forget_other_workspaces
  if [ "${2:-}" = ON ]; then
    testing=ON
    grep -qs '^CATKIN_ENABLE_TESTING:[A-Z]*=\(ON\|1\)$' "$BUILD/CMakeCache.txt" || rm -f "$BUILD/build.ninja"
  else
    testing=$(sed -n 's/^CATKIN_ENABLE_TESTING:[A-Z]*=//p' "$BUILD/CMakeCache.txt" 2>/dev/null)
  fi
  configure_and_build build "$ROOT" "$BUILD" "$1" -DCATKIN_ENABLE_TESTING="${testing:-OFF}"
}

# What a user's shell does after the build: packages, libraries and python modules of build/devel are found.
use_build() {
  set +u
  # shellcheck disable=SC1091 # written by the build
  . "$BUILD/devel/setup.sh"
  set -u
  export ROS_IP=127.0.0.1 ROS_HOME="$BUILD/ros"
}

# Which of the core's two libraries the loader takes here; nothing while neither is built.
chosen_library() {
  for user in "$BUILD"/devel/lib/libspidar_driver.so "$BUILD"/devel/lib/libpenalty_sim_scene.so; do
    [ -f "$user" ] || continue
    case $(ldd "$user" 2>/dev/null | grep libhaptic_core) in
      */glibc-hwcaps/x86-64-v3/*) echo 'x86-64-v3' ;;
      *) echo 'baseline, for any processor' ;;
    esac
    return
  done
}
