#!/bin/sh
#: shrink BAG [--fault NAME | --test COMMAND] [--output FILE.bag]
#:                   reduce a recorded session that shows a fault to the least ticks, bodies and parameters that still show it:
#:                   BAG.shrunk.bag, a few kilobytes for an issue, which ./run replay replays. The fault: the worst that is there, or
#:                   a flag's NAME, stopped, difference, late; or what COMMAND tells, which gets a bag as its last word and ends
#:                   with 0 where the fault is there
. "$(dirname "$0")/parts/start.sh"
judge shrink fault=text test=text output=output -- "$@"
at_most 1 shrink 'one bag'
[ "$option_words" = 1 ] || fail "shrink needs the path of a bag that ./run demo --record has written"
[ -z "$option_fault" ] || [ -z "$option_test" ] || fail 'shrink: --fault and --test name the fault twice: take one of them'
ensure_recording shrink "$option_word_1"
bag=$(absolute "$option_word_1")
output=${option_output:-${option_word_1%.bag}.shrunk.bag}
file=$(absolute "$output")
[ "$file" != "$bag" ] || fail "shrink: --output is the recording itself: name another file"
SETUP_BUILDS=stack
setup run tools
copy=$(mktemp -d) || fail "shrink: no folder can be made in ${TMPDIR:-/tmp}"
trap 'stop_children; rm -rf "$copy"; end_relays' EXIT
bag=$(python3 -B "$ROOT/penalty_sim/session/cut_recording.py" "$bag" "$copy" 2>"$copy/said") ||
  fail "shrink: $(tail -n 1 "$copy/said")"
[ ! -s "$copy/said" ] || echo "shrink: $(tail -n 1 "$copy/said")" >&2
if is_mcap "$bag"; then  # the replay reads bags
  problem=$(python3 -B "$ROOT/penalty_sim/session/mcap_bag.py" "$bag" "$copy/$(basename "$bag").bag" 2>&1) ||
    fail "shrink: $(echo "$problem" | tail -n 1)"
  bag=$copy/$(basename "$bag").bag
fi
build_stack haptic_shrink
use_build
show_and_keep shrink "$BUILD/devel/lib/penalty_sim/haptic_shrink" "$bag" "$file" ${option_fault:+--fault "$option_fault"} \
  ${option_test:+--test "$option_test"} || exit
echo "shrink: $output"
