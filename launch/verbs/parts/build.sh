# Configuring and building below build/, and using what was built. Sourced.

# A shell that has sourced another ROS workspace would build against it.
forget_other_workspaces() {
  unset CMAKE_PREFIX_PATH ROS_PACKAGE_PATH ROSLISP_PACKAGE_DIRECTORIES PYTHONPATH PYTHONHOME LD_LIBRARY_PATH
  unset ROS_MASTER_URI ROS_IP ROS_HOSTNAME
  if command -v ccache >/dev/null; then
    # Paths below the repository count as relative: another checkout of it finds the same.
    export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
    export CCACHE_BASEDIR="${CCACHE_BASEDIR:-$ROOT}" CCACHE_NOHASHDIR=1
    ccache_can_write || export CCACHE_DIR="$BUILD/ccache"
    # Where nothing can be found nothing is looked for: the preprocessor would run once more for each source, 3 % of a first build.
    ccache_has_objects || export CCACHE_DEPEND=1
  fi
}

# A home may be read-only, or none: ccache would fail, and CMake with it.
ccache_can_write() {
  local ccache_folder
  ccache_folder=$(ccache --get-config cache_dir 2>/dev/null) && [ -n "$ccache_folder" ] &&
    { mkdir -p "$ccache_folder" && : >"$ccache_folder/.$$"; } 2>/dev/null && rm -f "$ccache_folder/.$$"
}

ccache_has_objects() { [ -n "$(find "$(ccache --get-config cache_dir 2>/dev/null)" -name '*M' -print -quit 2>/dev/null)" ]; }

# A second call costs what ninja needs to see that nothing changed. A folder is configured again when the packages that CMake
# may find have changed since, by whatever way.
configure_and_build() {  # TITLE SOURCE BUILD_FOLDER TARGETS [CMAKE_OPTIONS]
  local build_title build_source build_folder build_targets build_key
  build_title=$1 build_source=$2 build_folder=$3 build_targets=$4
  shift 4
  build_key=$(installed_key)
  [ "$(cat "$build_folder/.installed" 2>/dev/null)" = "$build_key" ] || rm -f "$build_folder/build.ninja"
  # shellcheck disable=SC2016 # expanded by the inner shell
  with_progress_or_log "$build_title" "$LOGS/$build_title.log" sh -c '
    source=$1 folder=$2 targets=$3 plan=$4 key=$5
    shift 5
    if ! [ -f "$folder/build.ninja" ]; then
      cmake -S "$source" -B "$folder" -G Ninja "$@" && echo "$key" >"$folder/.installed" || exit 1
    fi
    # For the progress line: the objects that are not there. (A dry run ends where the globs would be looked at.)
    (cd "$folder" && ninja -t inputs $targets | grep "\\.o$" | while read -r object; do
      [ -f "$object" ] || echo "$object"
    done) >"$plan.new"
    mv "$plan.new" "$plan"
    exec ninja -C "$folder" $targets' sh "$build_source" "$build_folder" "$build_targets" "$LOGS/$build_title.plan" "$build_key" "$@"
}

# What the configured stack says of an option; nothing before the first configuration.
configured() { sed -n "s/^$1:[A-Z]*=//p" "$BUILD/CMakeCache.txt" 2>/dev/null; }  # OPTION

# Does the loader of this machine take the core's library for x86-64-v3, unless it is told otherwise (GLIBC_TUNABLES)?
v3_is_taken() {
  case ${GLIBC_TUNABLES:-} in *hwcaps*) return 1 ;; esac
  /lib64/ld-linux-x86-64.so.2 --help 2>/dev/null | grep -q '^ *x86-64-v3 (supported, searched)'
}

# The stack in build/. Tests are configured from the first call on that asks for them: they need more packages. The core's
# library for any processor is compiled from the first call on that asks for all of the stack, or where the loader would take it.
build_stack() {  # TARGETS [CATKIN_ENABLE_TESTING]
  local stack_testing stack_v3
  forget_other_workspaces
  stack_testing=${2:-$(configured CATKIN_ENABLE_TESTING)} stack_v3=$(configured HAPTIC_X86_64_V3)
  case $1 in all*) stack_v3=ON ;; *) stack_v3=${stack_v3:-ONLY} ;; esac
  [ "$stack_v3" != ONLY ] || v3_is_taken || stack_v3=ON
  [ "${stack_testing:=OFF} $stack_v3" = "$(configured CATKIN_ENABLE_TESTING) $(configured HAPTIC_X86_64_V3)" ] || rm -f "$BUILD/build.ninja"
  configure_and_build build "$ROOT" "$BUILD" "$1" -DCATKIN_ENABLE_TESTING="$stack_testing" -DHAPTIC_X86_64_V3="$stack_v3"
}

# What a user's shell does after the build: packages, libraries and python modules of build/devel are found.
use_build() {
  local use_logs
  set +u
  # shellcheck disable=SC1091 # written by the build
  . "$BUILD/devel/setup.sh"
  set -u
  export ROS_IP=127.0.0.1 ROS_HOME="$BUILD/ros"
  # roslaunch and its nodes end in a traceback each where they cannot log. Only writing tells, as for recordings.
  use_logs=${ROS_LOG_DIR:-$ROS_HOME/log}
  { mkdir -p "$use_logs" && : >"$use_logs/.$$"; } 2>/dev/null ||
    fail "ROS_LOG_DIR '$use_logs' cannot be written: unset it, or give a folder that is writable"
  rm -f "$use_logs/.$$"
}

# Which of the core's two libraries the loader takes here; nothing while neither is built.
chosen_library() {
  local user
  for user in "$BUILD"/devel/lib/libspidar_driver.so "$BUILD"/devel/lib/libpenalty_sim_scene.so; do
    [ -f "$user" ] || continue
    case $(ldd "$user" 2>/dev/null | grep libhaptic_core) in
      */glibc-hwcaps/x86-64-v3/*) echo 'x86-64-v3' ;;
      *) echo 'baseline, for any processor' ;;
    esac
    return
  done
}
