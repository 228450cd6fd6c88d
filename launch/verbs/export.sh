#!/bin/sh
#: export BAG | SESSION [--csv] [--npz] [--mcap] [--session] [--output PREFIX]
#:                   a recording as columns for your own analysis, one row per tick; --mcap: all its messages for Foxglove, Lichtblick
#:                   and PlotJuggler, with BAG.layout.json, which opens on the right panels in the first two; --session: BAG.session,
#:                   which touch.html (./run docs) replays in a browser, bit for bit. SESSION: every trial of a study's session
. "$(dirname "$0")/parts/start.sh"
[ $# -ge 1 ] || fail "export needs the path of a bag that ./run demo --record has written"
setup run pages
build_stack 'haptic_msgs_generate_messages_py session_table'
use_build
if is_session "$1"; then
  session=$1
  shift
  for word; do [ "$word" != --output ] || fail "export of a session writes beside each trial's recording: leave --output out"; done
  for bag in "$(absolute "$session")"/trials/*.bag; do
    [ -f "$bag" ] || fail "export: $session has no recording yet"
    show_and_keep export python3 -B "$ROOT/penalty_sim/session/session_export.py" \
      --program "$BUILD/devel/lib/penalty_sim/session_table" "$bag" "$@" || exit
  done
  exit
fi
show_and_keep export python3 -B "$ROOT/penalty_sim/session/session_export.py" \
  --program "$BUILD/devel/lib/penalty_sim/session_table" "$@"
