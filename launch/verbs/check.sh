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
#: check DEVICE --report FILE.html [--beside DEVICE] [--force N] [--torque NM]
#:                   the same, and a page, also of two devices side by side: the certified workspace over translations and turns for every
#:                   force up to N (1) together with every torque up to NM (what N makes at the knots), the largest box and ball in it,
#:                   conditioning, isotropy, stiffness, and which strings come near one another
#: check SCENE | DEVICE ... --picture FILE.svg
#:                   the same, and a picture: the certificate as bars; where the device presents which force in every direction
. "$(dirname "$0")/parts/start.sh"

# What a scene's check, a study's and a device's take, and of what kind it is.
SCENE_OPTIONS='all json device=device rate=number default-density=number srdf=file strict missing-meshes=box,skip,stop xacro=setting+ rigid scenes=folder'
STUDY_OPTIONS='subject=text session=count seed=whole order device=device'
DEVICE_OPTIONS='report=output beside=device force=number torque=number'

check_study() {
  local device
  # shellcheck disable=SC2086 # one word per option
  judge 'check of a study' $STUDY_OPTIONS -- "$@"
  at_most 1 'check of a study' 'one study'
  study_file=$(find_study "$option_word_1") || exit 1
  device=$option_device_file
  [ -n "$option_device" ] || device=$(find_device "$(study_device "$study_file")") || exit 1
  SETUP_BUILDS=stack
  setup run pages python experiment
  build_stack 'scene_check haptic_python haptic_msgs_generate_messages_py'
  use_build
  show_and_keep check python3 -B "$ROOT/haptic_bridge/experiment/check_study.py" --device "$device" \
    --program "$BUILD/devel/lib/penalty_sim/scene_check" "$study_file" ${option_subject:+--subject "$option_subject"} \
    ${option_session:+--session "$option_session"} ${option_seed:+--seed "$option_seed"} ${option_order:+--order}
}

check_device() {
  # shellcheck disable=SC2086 # one word per option
  judge 'check of a device' $DEVICE_OPTIONS picture=output -- "$@"
  at_most 1 'check of a device' 'one device'
  device_file=$(find_device "$option_word_1") || exit 1
  [ -n "$option_report" ] || [ -z "$option_beside$option_force$option_torque" ] ||
    fail 'check of a device: --beside, --force and --torque are of the page; give its place by --report FILE.html'
  SETUP_BUILDS=device_check
  # shellcheck disable=SC2046 # one word per section
  setup run $([ -z "$option_picture" ] || echo python)
  build_stack "device_check$([ -z "$option_picture" ] || echo ' haptic_python')"
  use_build
  show_and_keep check "$BUILD/devel/lib/spidar_driver/device_check" "$device_file"
  device_verdict=$?
  [ "$device_verdict" -lt 2 ] && [ -n "$option_report" ] && write_report
  draw_and_exit "$device_verdict" device "$device_file"
}

# The page of `device_file`, and of the device beside it.
write_report() {
  local each said
  [ -z "$option_torque" ] || [ -n "$option_force" ] || option_force=1
  set -- "$(absolute "$option_report")"
  for each in "$device_file" "$option_beside_file"; do
    [ -n "$each" ] || continue
    said=$LOGS/check-report-$(basename "$each" .yaml).json
    echo "check: certifying the workspace of $(basename "$each" .yaml), some seconds"
    "$BUILD/devel/lib/spidar_driver/device_check" "$each" --report ${option_force:+"$option_force"} ${option_torque:+"$option_torque"} >"$said" ||
      exit 1
    set -- "$@" "$said"
  done
  python3 -B "$ROOT/spidar_driver/report/device_page.py" "$@" || exit 1
}

check_scene() {
  # shellcheck disable=SC2086 # one word per option
  judge 'check of a scene' $SCENE_OPTIONS picture=output -- "$@"
  at_most 1 'check of a scene' 'one scene, device or study'
  scene_file=$(find_scene "$option_word_1") || exit 1
  device_file=$option_device_file
  [ -n "$option_device" ] || device_file=$(find_device spidar_g6x3r) || exit 1
  SETUP_BUILDS=scene_check
  setup run
  build_stack scene_check
  use_build
  set -- "$BUILD/devel/lib/penalty_sim/scene_check" --device "$device_file" ${option_rate:+--rate "$option_rate"} \
    ${option_default_density:+--default-density "$option_default_density"} ${option_srdf:+--srdf "$(absolute "$option_srdf")"} \
    ${option_strict:+--strict} ${option_rigid:+--rigid} ${option_missing_meshes:+--missing-meshes "$option_missing_meshes"} \
    ${option_scenes:+--scenes "$(absolute "$option_scenes")"}
  # The picture has a bar for each island.
  [ -z "$option_all$option_picture" ] || set -- "$@" --all
  set -f
  IFS='
'
  for setting in $option_xacro; do set -- "$@" --xacro "$setting"; done
  unset IFS
  set +f
  [ -z "$option_json" ] || { cd "$CALLER" && "$@" --json "$scene_file"; exit; }  # for a program: the object alone, without figures to keep
  show_and_keep check "$@" "$scene_file"
  draw_and_exit "$?" scene "$(basename "${scene_file%.*}")"
}

# Ends with the check's own code, or the picture's.
draw_and_exit() {  # CODE KIND SOURCE
  [ -n "$option_picture" ] || exit "$1"
  python3 -B "$ROOT/penalty_sim/scene/check_picture.py" "$2" "$3" "$(absolute "$option_picture")" <"$LOGS/check.log" || exit
  exit "$1"
}

# The first word that is no option tells whether it is a scene, a device or a study.
# shellcheck disable=SC2086 # one word per option
judge check $SCENE_OPTIONS $STUDY_OPTIONS $DEVICE_OPTIONS picture=output -- "$@"
[ "$option_words" -ge 1 ] || fail "check needs the name of a scene, device or study, or the path of its file"
if is_study "$option_word_1"; then
  check_study "$@"
elif is_device "$option_word_1"; then
  check_device "$@"
else
  check_scene "$@"
fi
