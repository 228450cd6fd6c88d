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
  targets=all only=${2:-}
  # Threads meet in these two rooms alone; the others' tests would take twenty times as long to say nothing.
  if [ "$kind" = thread ]; then targets='core_base_test core_loop_test' only=${2:-'core_(base|loop)'}; fi
  configure_and_build "sanitize-$kind" "$ROOT/src" "$folder" "$targets" -DHAPTIC_CORE_TESTS=ON \
    -DCMAKE_CXX_FLAGS="-fsanitize=$kind -fno-sanitize-recover=all -fno-omit-frame-pointer -g1" \
    -DCMAKE_CXX_FLAGS_RELEASE='-O1 -DNDEBUG'
  TSAN_OPTIONS=halt_on_error=1 ctest --test-dir "$folder" --no-tests=error --output-on-failure ${only:+-R "$only"}
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
ctest --test-dir "$BUILD" --no-tests=error --output-on-failure ${1:+-R "$1"}
