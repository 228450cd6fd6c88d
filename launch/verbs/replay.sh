#!/bin/sh
#: replay BAG [--rviz]
#: replay SESSION --trial N [--rviz] [--with KEY=VALUE]
#:                   run a session that --record has kept once more and compare it bit for bit: headless and as
#:                   fast as it goes, or at its own pace in rviz. A recording of an earlier release is replayed too: it
#:                   says that its last bits are those of another build. A trial of a study's session likewise; --with leads its
#:                   recorded hand through a changed world, as stiffness=2e7
. "$(dirname "$0")/parts/start.sh"
[ $# -ge 1 ] || fail "replay needs the path of a bag that ./run demo --record has written"
bag='' rviz=false trial='' changes=''
while [ $# -gt 0 ]; do
  case $1 in
    --rviz) rviz=true ;;
    --trial | --with)
      [ $# -ge 2 ] || fail "replay: $1 needs a value"
      case $1 in --trial) trial=$2 ;; *) changes="$changes --with $2" ;; esac
      shift ;;
    -*) fail "replay: unknown option '$1'; there are --rviz, --trial, --with" ;;
    *) [ -z "$bag" ] || fail "replay takes one bag"
      bag=$1 ;;
  esac
  shift
done
[ -n "$bag" ] || fail "replay needs the path of a bag"
session=''
if is_session "$bag"; then
  [ -n "$trial" ] || fail "replay: $bag is a session; say --trial N"
  session=$(absolute "$bag")
  bag=$(trial_bag "$session" "$trial") || exit 1
else
  [ -z "$trial$changes" ] || fail "replay: --trial and --with want the folder of a session, sub-ID/ses-N"
  bag=$(absolute "$bag")
fi
[ -f "$bag" ] || fail "replay: '$bag': no such file"
if is_mcap "$bag"; then  # the replay reads bags
  setup run tools
  copy=$(mktemp -d) || fail "replay: no folder can be made in ${TMPDIR:-/tmp}"
  trap 'stop_children; rm -rf "$copy"' EXIT
  problem=$(python3 -B "$ROOT/penalty_sim/session/mcap_bag.py" "$bag" "$copy/$(basename "$bag").bag" 2>&1) ||
    fail "replay: $(echo "$problem" | tail -n 1)"
  bag=$copy/$(basename "$bag").bag
fi
if [ -n "$changes" ]; then
  setup run pages python experiment
  build_stack 'session_table haptic_msgs_generate_messages_py'
  use_build
  # shellcheck disable=SC2086 # one word per option
  show_and_keep replay python3 -B "$ROOT/haptic_bridge/experiment/changed_replay.py" \
    --program "$BUILD/devel/lib/penalty_sim/session_table" $changes "$session" "$bag"
elif [ "$rviz" = false ]; then
  setup run
  build_stack haptic_replay
  use_build
  show_and_keep replay "$BUILD/devel/lib/penalty_sim/haptic_replay" "$bag"
else
  [ -n "${DISPLAY:-}" ] || fail "replay: --rviz needs a display; set DISPLAY, or use xvfb-run ./run replay BAG --rviz"
  setup run view
  build_stack all
  use_build
  port=$(free_port)
  export ROS_MASTER_URI="http://127.0.0.1:$port"
  with_progress replay "$LOGS/replay.log" roslaunch -p "$port" --disable-title --skip-log-check --no-summary \
    haptic_bringup replay.launch bag:="$bag"
  keep_figures replay "$LOGS/replay.log" '-O3 -DNDEBUG -ffp-contract=off'
fi
