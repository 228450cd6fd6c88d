#!/bin/sh
# What builds and tests of a fresh checkout cost, with all packages installed and an empty compiler cache, as lines
# `figure NAME VALUE UNIT` (./run bench build):
#   build_bench.sh FOLDER [users|ci]...   (default: both)
# users: the first demo, then the verbs and programs that come after it; ci: .ci/run, whose times need a quiet machine.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd -P)
[ $# -ge 1 ] || { echo "usage: $0 FOLDER [users|ci]..." >&2; exit 2; }
mkdir -p "$1"
work=$(cd "$1" && pwd -P)
shift
[ $# -gt 0 ] || set -- users ci
unset CCACHE_BASEDIR CCACHE_NOHASHDIR CMAKE_C_COMPILER_LAUNCHER CMAKE_CXX_COMPILER_LAUNCHER

fresh() {  # NAME: a checkout of the commit, and its own empty cache; the shell stands in it
  rm -rf "${work:?}/$1" "$work/$1.ccache"
  git -c safe.directory='*' clone -q "$root" "$work/$1"
  export CCACHE_DIR="$work/$1.ccache"
  cd "$work/$1"
}

cpu_of() {  # COMMAND...: sets cpu_s, the seconds of all its processes
  echo "build_bench: $*"
  "$root/test/cpu_time.sh" "$work/times" "$@"
  cpu_s=$(awk 'NR == 2 { split($1 "m" $2, t, "m"); print 60 * t[1] + t[2] + 60 * t[3] + t[4] }' "$work/times")
}

objects() { find build -name '*.o' -printf '%p %T@\n' | sort; }

# Objects of the first build that a later verb compiled once more.
users() {
  fresh users
  cpu_of ./run demo
  demo_s=$cpu_s all_s=$cpu_s
  echo "figure build.demo_cpu_s $demo_s s"
  objects >"$work/first"
  cp build/.ninja_log "$work/demo.ninja_log"
  for verb in 'check touch_cube' 'check spidar_g6x3r' build 'demo --emulate --device uart --seconds 3' 'test ^links$'; do
    # shellcheck disable=SC2086 # a verb and its arguments
    cpu_of ./run $verb
    case $verb in build | test*) all_s=$(echo "$all_s $cpu_s" | awk '{ print $1 + $2 }') ;; esac
  done
  echo "figure build.all_cpu_s $all_s s"
  # launch/verbs/parts/build_seconds.txt: how long each object took beside the others, scaled to the CPU seconds of the demo's.
  awk -v cpu="$demo_s" '
    $4 !~ /\.o$/ { next }
    { name = $4; sub(/.*CMakeFiles\//, "", name); sub(/\.dir\/(Unity\/)?/, "/", name); took[name] = $2 - $1 }
    NR == FNR { demo[name] = 1; sum += $2 - $1 }
    END { for (name in took) if (took[name] * cpu / sum >= 1) printf "%.0f %s%s\n", took[name] * cpu / sum, name, demo[name] ? "" : " later" }' \
    "$work/demo.ninja_log" build/.ninja_log | sort -k3,3 -k1,1rn >"$work/build_seconds.txt"
  objects >"$work/later"
  echo "figure build.second_run_compiles $(comm -23 "$work/first" "$work/later" | wc -l) 1"
}

ci() {
  fresh ci
  began=$(date +%s)
  .ci/run >"$work/ci.log" 2>&1 || { tail -n 60 "$work/ci.log"; echo "build_bench: .ci/run failed; see $work/ci.log" >&2; exit 1; }
  echo "figure ci.wall_s_quiet $(($(date +%s) - began)) s"
  awk '/^ci: test: / { print "figure test.wall_s_quiet", $3, "s" }
    /^(figure test\.|ci: |build_tools: )/' "$work/ci.log"
}

for part; do
  case $part in
    users | ci) (set -e; "$part") ;;
    *) echo "$0: unknown part '$part'" >&2; exit 2 ;;
  esac
done
