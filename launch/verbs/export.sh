#!/bin/sh
#: export BAG | SESSION [--csv] [--npz] [--mcap] [--session] [--output PREFIX]
#:                   a recording as columns for your own analysis, one row per tick; --mcap: all its messages for Foxglove, Lichtblick
#:                   and PlotJuggler, with BAG.layout.json, which opens on the right panels in the first two; --session: BAG.session,
#:                   which touch.html (./run docs) replays in a browser, bit for bit. SESSION: every trial of a study's session
. "$(dirname "$0")/parts/start.sh"
judge export csv npz mcap session output=prefix -- "$@"
at_most 1 export 'one recording, or the folder of a session'
[ "$option_words" = 1 ] || fail "export needs the path of a bag that ./run demo --record has written"
if is_session "$option_word_1"; then
  [ -z "$option_output" ] || fail "export of a session writes beside each trial's recording: leave --output out"
  set -- "$(absolute "$option_word_1")"/trials/*.bag
  [ -f "$1" ] || fail "export: $option_word_1 has no recording yet"
else
  ensure_recording export "$option_word_1"
  set -- "$(absolute "$option_word_1")"
fi
SETUP_BUILDS=stack
setup run pages
build_stack 'haptic_msgs_generate_messages_py session_table'
use_build
for recording; do
  show_and_keep export python3 -B "$ROOT/penalty_sim/session/session_export.py" --program "$BUILD/devel/lib/penalty_sim/session_table" \
    "$recording" ${option_csv:+--csv} ${option_npz:+--npz} ${option_mcap:+--mcap} ${option_session:+--session} \
    ${option_output:+--output "$option_output"} || exit
done
