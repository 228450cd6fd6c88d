#!/bin/sh
#: check SCENE [--all] [--json] [--device D] [--rate HZ] [--default-density KG_PER_M3] [--srdf FILE] [--strict]
#:       [--missing-meshes box|skip|stop] [--xacro NAME:=VALUE]... [--rigid]
#:                   load a scene or robot and say the verdict, what was replaced or chosen, what a hand on device D
#:                   (spidar_g6x3r) feels and carries, which drives cannot hold the start pose, what overlaps there, and
#:                   what it becomes, equal things once; --all: also each link and collision, the plan, every contact of the
#:                   certificate; --json: for a program; --rigid: as if all surfaces said so. Fails where
#:                   the hand would ring at any depth up to the workspace's end
#: check STUDY [--subject ID] [--session N] [--seed N] [--order] [--device D]
#:                   a study's trials, time and order, and what the hand will get of each of its conditions
#: check DEVICE      what an arrangement of strings can do, what is wrong with it, its first-motion test
#: check SCENE | DEVICE ... --picture FILE.svg
#:                   the same, and a picture: the certificate as bars; where the device presents which force in every direction
. "$(dirname "$0")/parts/start.sh"
picture='' before=''
for word; do  # the picture's name is taken out; the other words go on in their order
  shift
  if [ "$before" = --picture ]; then picture=$word; elif [ "$word" != --picture ]; then set -- "$@" "$word"; fi
  before=$word
done
[ "$before" != --picture ] || fail "check: --picture wants the name of a file, e.g. check.svg"
[ $# -ge 1 ] || fail "check needs the name of a scene, device or study, or the path of its file"

# A study's device is the one that its file names, unless another is given. Sets device_file; the other words are left in order.
check_study() {
  study_file=$(find_study "$1") || exit 1
  shift
  device=$(study_device "$study_file") before=''
  for word; do
    shift
    if [ "$before" = --device ]; then device=$word; elif [ "$word" != --device ]; then set -- "$@" "$word"; fi
    before=$word
  done
  device_file=$(find_device "$device") || exit 1
  setup run pages python experiment
  build_stack 'scene_check haptic_python haptic_msgs_generate_messages_py'
  use_build
  show_and_keep check python3 -B "$ROOT/haptic_bridge/experiment/check_study.py" --device "$device_file" \
    --program "$BUILD/devel/lib/penalty_sim/scene_check" "$study_file" "$@"
}

# Ends with the check's own code, or the picture's.
draw_and_exit() {  # CODE KIND SOURCE
  [ -n "$picture" ] || exit "$1"
  python3 -B "$ROOT/penalty_sim/scene/check_picture.py" "$2" "$3" "$(absolute "$picture")" <"$LOGS/check.log" || exit
  exit "$1"
}

if is_study "$1"; then
  [ -z "$picture" ] || fail "check of a study draws no picture: leave --picture out"
  check_study "$@"
elif is_device "$1"; then
  [ $# = 1 ] || fail "check of a device takes no options"
  device_file=$(find_device "$1") || exit 1
  # shellcheck disable=SC2046 # one word per section
  setup run $([ -z "$picture" ] || echo python)
  build_stack "device_check$([ -z "$picture" ] || echo ' haptic_python')"
  use_build
  show_and_keep check "$BUILD/devel/lib/spidar_driver/device_check" "$device_file"
  draw_and_exit "$?" device "$device_file"
else
  scene_file=$(find_scene "$1") || exit 1
  shift
  device=spidar_g6x3r before=''
  for word; do  # the device's name becomes its file; the other options go on in their order
    shift
    if [ "$before" = --device ]; then
      device=$word
    elif [ "$word" != --device ]; then
      set -- "$@" "$word"
    fi
    before=$word
  done
  [ "$before" != --device ] || fail "check: --device wants the name of a device or the path of its file"
  device_file=$(find_device "$device") || exit 1
  [ -z "$picture" ] || set -- --all "$@"  # the picture has a bar for each island
  setup run
  build_stack scene_check
  use_build
  for word; do  # for a program: the object alone, without figures to keep
    [ "$word" != --json ] || { cd "$CALLER" && exec "$BUILD/devel/lib/penalty_sim/scene_check" --device "$device_file" "$@" "$scene_file"; }
  done
  show_and_keep check "$BUILD/devel/lib/penalty_sim/scene_check" --device "$device_file" "$@" "$scene_file"
  draw_and_exit "$?" scene "$(basename "${scene_file%.*}")"
fi
