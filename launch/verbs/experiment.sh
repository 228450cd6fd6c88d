#!/bin/sh
#: experiment STUDY --subject ID [--session N] [--seed N] [--windows] [--rviz] [--hardware | --port P] [--device D]
#:            [--marker-port P] [--simulate N] [--output FOLDER]
#:                   run a session of a study of urdf/experiments: each trial's row and recording are on disk before the next;
#:                   the same command goes on with a session that was interrupted. --simulate: a simulated subject on the twin
#: experiment STUDY --power
#:                   how many trials the study needs, by simulated subjects
. "$(dirname "$0")/parts/start.sh"
[ $# -ge 1 ] || fail "experiment needs the name of a study, or the path of its file"
study_file=$(find_study "$1") || exit 1
shift
device='' windows='' before=''
for word; do
  shift
  case $before in
    --device) device=$word ;;
    *) [ "$word" = --device ] || set -- "$@" "$word" ;;
  esac
  case $word in
    --windows | --rviz) windows=yes ;;
  esac
  before=$word
done
if [ -n "$windows" ]; then
  [ -n "${DISPLAY:-}" ] || fail "experiment: --windows and --rviz need a display; set DISPLAY, or use xvfb-run"
fi
device_file=$(find_device "${device:-$(study_device "$study_file")}") || exit 1
# shellcheck disable=SC2046 # one word per section
setup run pages python experiment $([ -z "$windows" ] || echo view)
build_stack 'haptic_bridge penalty_sim spidar_driver spidar_stop motor_guard session_table haptic_python
  haptic_msgs_generate_messages_cpp haptic_msgs_generate_messages_py haptic_bridge_gencfg'
use_build
HAPTIC_VERSION=$("$ROOT/launch/verbs/version.sh" | head -n 1)
export HAPTIC_VERSION
cd "$CALLER" || exit 1
exec python3 -B "$ROOT/haptic_bridge/experiment/experiment.py" --program "$BUILD/devel/lib/penalty_sim/session_table" \
  "$study_file" --device "$device_file" "$@"
