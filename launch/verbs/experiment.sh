#!/bin/sh
#: experiment STUDY --subject ID [--session N] [--seed N] [--windows] [--rviz] [--hardware | --port P] [--device D]
#:            [--emulate] [--marker-port P] [--simulate N] [--output FOLDER]
#:                   run a session of a study of urdf/experiments: each trial's row and recording are on disk before the next;
#:                   the same command goes on with a session that was interrupted. --simulate: a simulated subject on the twin; --emulate:
#:                   the motor boards of the device on a pseudo-terminal, where its file names boards; a script moves the grip
#: experiment STUDY --power
#:                   how many trials the study needs, by simulated subjects
. "$(dirname "$0")/parts/start.sh"
judge experiment subject=text session=count seed=whole device=device output=text hardware port=port emulate windows rviz marker-port=port \
  simulate=whole power -- "$@"
at_most 1 experiment 'the name of one study, or the path of its file'
[ "$option_words" = 1 ] || fail "experiment needs the name of a study, or the path of its file"
study_file=$(find_study "$option_word_1") || exit 1
[ -n "$option_subject$option_power" ] || fail "experiment: --subject is missing: a session needs one, --power does not"
case $option_subject in *[!A-Za-z0-9]*) fail "experiment: --subject '$option_subject' is no pseudonym of letters and digits, as s01" ;; esac
if [ -n "$option_windows$option_rviz" ]; then
  [ -n "${DISPLAY:-}" ] || fail "experiment: --windows and --rviz need a display; set DISPLAY, or use xvfb-run"
fi
device_file=$option_device_file
[ -n "$device_file" ] || device_file=$(find_device "$(study_device "$study_file")") || exit 1
targets='haptic_bridge penalty_sim spidar_driver spidar_stop motor_guard session_table haptic_python
  haptic_msgs_generate_messages_cpp haptic_msgs_generate_messages_py haptic_bridge_gencfg'
if [ -n "$option_emulate" ]; then
  [ -z "$option_simulate" ] || fail 'experiment: --simulate leads the grip of the twin, --emulate moves it by a script: take one of them'
  [ -z "$option_hardware$option_port" ] || fail 'experiment: --emulate stands in for the hardware: take one of them'
  ensure_boards experiment "$device_file"
  targets="$targets spidar_board_emulator"
fi
SETUP_BUILDS=stack
# shellcheck disable=SC2046 # one word per section
setup run pages python experiment $([ -z "$option_windows$option_rviz" ] || echo view)
build_stack "$targets"
use_build
HAPTIC_VERSION=$("$ROOT/launch/verbs/version.sh" | head -n 1)
export HAPTIC_VERSION
if [ -n "$option_emulate" ]; then
  mkdir -p "$BUILD/run"
  emulated=$(mktemp -d "$BUILD/run/experiment-XXXXXX") || fail "experiment: no folder can be made in $BUILD/run"
  start_emulator experiment "$device_file" "$emulated"
  option_port=$emulated/emulated_boards
fi
cd "$CALLER" || exit 1
exec python3 -B "$ROOT/haptic_bridge/experiment/experiment.py" --program "$BUILD/devel/lib/penalty_sim/session_table" \
  "$study_file" --device "$device_file" ${option_subject:+--subject "$option_subject"} ${option_session:+--session "$option_session"} \
  ${option_seed:+--seed "$option_seed"} ${option_output:+--output "$option_output"} ${option_hardware:+--hardware} \
  ${option_port:+--port "$option_port"} ${option_emulate:+--emulated} ${option_windows:+--windows} ${option_rviz:+--rviz} \
  ${option_marker_port:+--marker-port "$option_marker_port"} ${option_simulate:+--simulate "$option_simulate"} ${option_power:+--power}
