#!/bin/sh
#: test [--sanitize address|undefined|thread] [REGEX]
#:                   build and run all tests, or those whose name matches; ends with ctest's summary. --sanitize: those of
#:                   the core alone, built with that sanitizer below build/sanitize-KIND
. "$(dirname "$0")/parts/start.sh"

# The core and its tests, compiled with a sanitizer that ends a test at its first finding.
test_sanitized() {  # KIND [REGEX]
  local kind folder only targets room
  kind=$1 folder=$BUILD/sanitize-$1 only=${2:-}
  # Threads meet in these two rooms alone; the others' tests would take twenty times as long to say nothing.
  if [ "$kind" = thread ]; then only=${2:-'core_(base|loop)'}; fi
  targets=$(for room in test/core/*/; do echo "core_$(basename "$room")"; done | grep -E -e "$only" | sed 's/$/_test/' | tr '\n' ' ')
  [ -n "$targets" ] || fail "test: --sanitize: no room of the core matches '$only'; there are: $(cd test/core && echo */ | tr -d /)"
  SETUP_BUILDS='all tests'
  setup run test
  forget_other_workspaces
  configure_and_build "sanitize-$kind" "$ROOT/src" "$folder" "$targets" -DHAPTIC_CORE_TESTS=ON -DHAPTIC_X86_64_V3=OFF \
    -DCMAKE_CXX_FLAGS="-fsanitize=$kind -fno-sanitize-recover=all -fno-omit-frame-pointer -g1" \
    -DCMAKE_CXX_FLAGS_RELEASE='-O1 -DNDEBUG'
  TSAN_OPTIONS=halt_on_error=1 ctest --test-dir "$folder" --no-tests=error --output-on-failure -j "$(nproc)" ${only:+-R "$only"}
}

# The ten tests that took the most CPU seconds, and all together.
show_test_times() {  # SINCE, a file: of those that ended later
  local file
  find "$BUILD/test_times" -type f -newer "$1" -size +0 | while read -r file; do
    awk -v name="$(basename "$file")" '
      NR == 2 { split($1 "m" $2, t, "m"); printf "%.1f %s\n", 60 * t[1] + t[2] + 60 * t[3] + t[4], name }' "$file"
  done | sort -rn >"$LOGS/test_times.txt"
  awk 'NR == 1 { print "test: CPU seconds of the slowest:"; slowest = $1 }
    NR <= 10 { printf "%8.1f %s\n", $1, $2 }
    { sum += $1 }
    END { if (NR) printf "figure test.slowest_s %.1f s\nfigure test.cpu_s %.1f s\n", slowest, sum }' "$LOGS/test_times.txt"
}

# Programs of the rooms of the core that REGEX matches; nothing where it matches, or may match, another test as well.
only_rooms() {  # REGEX
  local room each
  case $1 in core_* | ^core_*) ;; *) return 0 ;; esac
  case $1 in *'|'*) return 0 ;; esac
  for room in test/core/*/; do
    each=core_$(basename "$room")
    echo "$each" | grep -qE -e "$1" && printf '%s_test ' "$each"
  done
}

judge test sanitize=address,undefined,thread -- "$@"
at_most 1 test 'one regular expression'
only=${option_word_1:-}
grep -E -e "$only" /dev/null 2>/dev/null
[ $? -lt 2 ] || fail "test: '$only' is no regular expression"
if [ -n "$option_sanitize" ]; then
  test_sanitized "$option_sanitize" "$only"
  exit
fi
# Tests of the core alone need no more than their own programs. Another may call any verb.
rooms=$(only_rooms "$only")
if [ -n "$rooms" ]; then
  SETUP_BUILDS=$rooms
  setup run unit
  build_stack "$rooms" ON
else
  SETUP_BUILDS='all tests'
  # shellcheck disable=SC2046 # one word per section
  setup $(package_sections)
  build_stack 'all tests' ON
fi
use_build
begun=$(mktemp) || fail "test: no file can be made in ${TMPDIR:-/tmp}"
# Many wait for a clock or a process rather than compute.
ctest --test-dir "$BUILD" --no-tests=error --output-on-failure -j $((2 * $(nproc))) ${only:+-R "$only"}
code=$?
show_test_times "$begun"
rm -f "$begun"
exit "$code"
