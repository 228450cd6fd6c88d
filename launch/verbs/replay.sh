#!/bin/sh
#: replay BAG [--rviz]
#: replay SESSION --trial N [--rviz] [--with KEY=VALUE]
#:                   run a session that --record has kept once more and compare it bit for bit: headless and as
#:                   fast as it goes, or at its own pace in rviz. A recording of an earlier release is replayed too: it
#:                   says that its last bits are those of another build. A trial of a study's session likewise; --with leads its
#:                   recorded hand through a changed world, as stiffness=2e7
. "$(dirname "$0")/parts/start.sh"
judge replay rviz trial=count with=setting+ -- "$@"
at_most 1 replay 'one bag, or the folder of a session'
[ "$option_words" = 1 ] || fail "replay needs the path of a bag that ./run demo --record has written"
session=''
if is_session "$option_word_1"; then
  [ -n "$option_trial" ] || fail "replay: $option_word_1 is a session; say --trial N"
  session=$(absolute "$option_word_1")
  bag=$(trial_bag "$session" "$option_trial") || exit 1
else
  [ -z "$option_trial$option_with" ] || fail "replay: --trial and --with want the folder of a session, sub-ID/ses-N"
  ensure_recording replay "$option_word_1"
  bag=$(absolute "$option_word_1")
fi
[ -z "$option_rviz" ] || [ -n "${DISPLAY:-}" ] || fail "replay: --rviz needs a display; set DISPLAY, or use xvfb-run ./run replay BAG --rviz"
SETUP_BUILDS=stack
setup run tools
copy=$(mktemp -d) || fail "replay: no folder can be made in ${TMPDIR:-/tmp}"
trap 'stop_children; rm -rf "$copy"; end_relays' EXIT
bag=$(python3 -B "$ROOT/penalty_sim/session/cut_recording.py" "$bag" "$copy" 2>"$copy/said") ||
  fail "replay: $(tail -n 1 "$copy/said")"
[ ! -s "$copy/said" ] || echo "replay: $(tail -n 1 "$copy/said")" >&2
if is_mcap "$bag"; then  # the replay reads bags
  problem=$(python3 -B "$ROOT/penalty_sim/session/mcap_bag.py" "$bag" "$copy/$(basename "$bag").bag" 2>&1) ||
    fail "replay: $(echo "$problem" | tail -n 1)"
  bag=$copy/$(basename "$bag").bag
fi
if [ -n "$option_with" ]; then
  setup run pages python experiment
  build_stack 'session_table haptic_msgs_generate_messages_py'
  use_build
  # shellcheck disable=SC2046,SC2086 # one word per setting
  show_and_keep replay python3 -B "$ROOT/haptic_bridge/experiment/changed_replay.py" \
    --program "$BUILD/devel/lib/penalty_sim/session_table" $(printf -- '--with %s ' $option_with) "$session" "$bag"
elif [ -z "$option_rviz" ]; then
  setup run
  build_stack haptic_replay
  use_build
  show_and_keep replay "$BUILD/devel/lib/penalty_sim/haptic_replay" "$bag"
else
  setup run view
  build_stack all
  use_build
  port=$(free_port)
  export ROS_MASTER_URI="http://127.0.0.1:$port"
  with_progress replay "$LOGS/replay.log" roslaunch -p "$port" --disable-title --skip-log-check --no-summary \
    haptic_bringup replay.launch bag:="$bag"
  keep_figures replay "$LOGS/replay.log" '-O3 -DNDEBUG -ffp-contract=off'
fi
