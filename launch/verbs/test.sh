#!/bin/sh
#: test [--sanitize address|undefined|thread] [REGEX]
#:                   build and run all tests, or those whose name matches; ends with ctest's summary. --sanitize: those of
#:                   the core alone, built with that sanitizer below build/sanitize-KIND
. "$(dirname "$0")/parts/start.sh"

# The core and its tests, compiled with a sanitizer that ends a test at its first finding.
test_sanitized() {  # KIND [REGEX]
  kind=$1 folder=$BUILD/sanitize-$1
  case $kind in
    address | undefined | thread) ;;
    *) fail "test: --sanitize '$kind' is unknown; there are address, undefined, thread" ;;
  esac
  [ $# -le 2 ] || fail "test takes at most one regular expression"
  setup run test
  forget_other_workspaces
  only=${2:-}
  # Threads meet in these two rooms alone; the others' tests would take twenty times as long to say nothing.
  if [ "$kind" = thread ]; then only=${2:-'core_(base|loop)'}; fi
  targets=$(for room in test/core/*/; do echo "core_$(basename "$room")"; done | grep -E -e "$only" | sed 's/$/_test/' | tr '\n' ' ')
  [ -n "$targets" ] || fail "test: --sanitize: no room of the core matches '$only'; there are: $(cd test/core && echo */ | tr -d /)"
  configure_and_build "sanitize-$kind" "$ROOT/src" "$folder" "$targets" -DHAPTIC_CORE_TESTS=ON -DHAPTIC_X86_64_V3=OFF \
    -DCMAKE_CXX_FLAGS="-fsanitize=$kind -fno-sanitize-recover=all -fno-omit-frame-pointer -g1" \
    -DCMAKE_CXX_FLAGS_RELEASE='-O1 -DNDEBUG'
  TSAN_OPTIONS=halt_on_error=1 ctest --test-dir "$folder" --no-tests=error --output-on-failure -j "$(nproc)" ${only:+-R "$only"}
}

# The ten tests that took the most CPU seconds, and all together.
show_test_times() {
  for file in "$BUILD/test_times/"*; do
    [ -s "$file" ] && awk -v name="$(basename "$file")" '
      NR == 2 { split($1 "m" $2, t, "m"); printf "%.1f %s\n", 60 * t[1] + t[2] + 60 * t[3] + t[4], name }' "$file"
  done | sort -rn >"$LOGS/test_times.txt"
  awk 'NR == 1 { print "test: CPU seconds of the slowest:"; slowest = $1 }
    NR <= 10 { printf "%8.1f %s\n", $1, $2 }
    { sum += $1 }
    END { if (NR) printf "figure test.slowest_s %.1f s\nfigure test.cpu_s %.1f s\n", slowest, sum }' "$LOGS/test_times.txt"
}

if [ "${1:-}" = --sanitize ]; then
  [ $# -ge 2 ] || fail "test: --sanitize needs a kind: address, undefined or thread"
  shift
  test_sanitized "$@"
  exit
fi
[ $# -le 1 ] || fail "test takes at most one regular expression"
# shellcheck disable=SC2046 # one word per section: a test may call any verb
setup $(package_sections)
build_stack 'all tests' ON
use_build
rm -f "$BUILD/test_times/"*
# Many wait for a clock or a process rather than compute.
ctest --test-dir "$BUILD" --no-tests=error --output-on-failure -j $((2 * $(nproc))) ${1:+-R "$1"}
code=$?
show_test_times
exit "$code"
