#!/bin/sh
#: replay BAG [--rviz]
#:                   run a session that --record has kept once more and compare it bit for bit: headless and as
#:                   fast as it goes, or at its own pace in rviz. A recording of an earlier release is replayed too: it
#:                   says that its last bits are those of another build
. "$(dirname "$0")/parts/start.sh"
[ $# -ge 1 ] || fail "replay needs the path of a bag that ./run demo --record has written"
bag='' rviz=false
for word; do
  case $word in
    --rviz) rviz=true ;;
    -*) fail "replay: unknown option '$word'; there is --rviz" ;;
    *) [ -z "$bag" ] || fail "replay takes one bag"
      bag=$(absolute "$word") ;;
  esac
done
[ -n "$bag" ] || fail "replay needs the path of a bag"
[ -f "$bag" ] || fail "replay: '$bag': no such file"
if is_mcap "$bag"; then  # the replay reads bags
  setup run tools
  copy=$(mktemp -d) || fail "replay: no folder can be made in ${TMPDIR:-/tmp}"
  trap 'stop_children; rm -rf "$copy"' EXIT
  problem=$(python3 -B "$ROOT/penalty_sim/session/mcap_bag.py" "$bag" "$copy/$(basename "$bag").bag" 2>&1) ||
    fail "replay: $(echo "$problem" | tail -n 1)"
  bag=$copy/$(basename "$bag").bag
fi
if [ "$rviz" = false ]; then
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
