#!/bin/sh
#: demo [--scene S] [--device D] [--rate HZ] [--seconds N] [--rviz] [--dark] [--record FILE.bag|FILE.mcap]
#:      [--hardware | --port P | --emulate] [--default-density KG_PER_M3] [--missing-meshes box|skip|stop]
#:      [--xacro NAME:=VALUE]... [--master-port N]
#:                   close the loop between a device (a simulated one by default) and a scene; ends after
#:                   N seconds (10 unless --rviz), with figures; --hardware and --port take the real device,
#:                   --dark is --rviz on a dark ground; closing rviz ends the demo; --emulate: its motor boards on a pseudo-terminal, where its file
#:                   names boards (--device uart: those of SPIDAR-G6X5R); --scene param:/robot_description takes the
#:                   robot from the parameter server of ROS_MASTER_URI; its own master is at a free port, which it prints for
#:                   rosservice and rostopic in other shells, or at --master-port (11311: they find it as it is)
caller_master=${ROS_MASTER_URI:-http://127.0.0.1:11311}
. "$(dirname "$0")/parts/start.sh"
# With what other launch files start, so that a shell that has sourced devel/setup.sh has it.
TARGETS='haptic_bridge penalty_sim spidar_driver penalty_sim_node spidar_driver_node haptic_msgs_generate_messages_cpp
  haptic_msgs_generate_messages_py haptic_bridge_gencfg'

# Judges the words of the call; what they stand for is set here and read below.
read_call() {
  judge demo scene=scene device=text rate=number seconds=number rviz dark record=text hardware emulate port=port \
    default-density=number missing-meshes=box,skip,stop xacro=setting+ master-port=count -- "$@"
  at_most 0 demo 'options alone'
  option_scene=${option_scene:-touch_cube} option_device=${option_device:-spidar_g6x3r}
  [ "$option_device" != uart ] || { option_device=spidar_g6x5r option_emulate=true; }
  case $option_scene in
    param:*) scene_file='' ;;  # read once there is a folder for it
    *) scene_file=$(find_scene "$option_scene") || exit 1 ;;
  esac
  device_file=$(find_device "$option_device") || exit 1
  rviz=${option_rviz:-${option_dark:-false}} ground=light wire='twin' port=$option_port record=''
  [ -z "$option_dark" ] || ground=dark
  [ -z "$option_hardware$option_port" ] || wire='file'
  [ -z "$option_emulate" ] || ensure_boards demo "$device_file"
  [ -z "$option_emulate" ] || [ -z "$option_hardware$option_port" ] || fail 'demo: --emulate stands in for the hardware: take one of them'
  [ -z "$option_master_port" ] || ensure_master_port "$option_master_port"
  seconds=$option_seconds
  if [ "$rviz" = true ]; then
    [ -n "${DISPLAY:-}" ] || fail "demo: --rviz needs a display; set DISPLAY, or use xvfb-run ./run demo --rviz"
  else
    seconds=${seconds:-10}
  fi
  [ -n "$option_record" ] || return 0
  record=$(absolute "$option_record")
  case $record in *.bag | *.mcap) ;; *) record=$record.bag ;; esac
  can_be_written 'demo: --record' "$option_record" "$record"
}

# A folder of this run alone, so that two runs in one checkout do not meet. What failed stays there for a week.
begin_run() {
  mkdir -p "$BUILD/run" "$FIGURES" "$LOGS"
  find "$BUILD/run" -mindepth 1 -maxdepth 1 -mtime +7 -exec rm -rf {} +
  run=$(mktemp -d "$BUILD/run/demo-XXXXXX") || fail "demo: no folder can be made in $BUILD/run"
  lines=$run/figures log=$run/log
  touch "$run/begin"
  case $option_scene in
    param:*)
      scene_file=$run/${option_scene##*/}.urdf
      python3 -B launch/verbs/parts/read_parameter.py "$caller_master" "${option_scene#param:}" "$scene_file" 2>"$run/problem" ||
        fail "demo: --scene $option_scene: $(tail -n 1 "$run/problem")" ;;
  esac
}

# Says what a run has written once it has looked at it.
tell_results() {
  local bag_problem layout
  layout=''
  if [ -n "$record" ]; then
    bag_problem=$(python3 -B launch/verbs/parts/look_at_recording.py "$record" "$run/begin" \
      "$(awk '$2 == "demo.ticks" { print $3 }' "$lines")" 2>&1) ||
      fail "demo: $(echo "$bag_problem" | tail -n 1)"
    case $record in *.mcap) layout=$(python3 -B penalty_sim/session/mcap_layout.py "$record") || fail "demo: the layout beside $record cannot be written" ;; esac
    echo "demo: recorded $record${layout:+; a layout for Lichtblick and Foxglove: $layout}"
  fi
  keep_figures demo "$lines" '-O3 -DNDEBUG -ffp-contract=off' "$run" || exit 1
  grep '^not measured' "$lines"
  if ! { mv -f "$run/demo.csv" "$FIGURES/demo.csv" && mv -f "$log" "$LOGS/demo.log"; }; then fail "demo: $FIGURES cannot be written"; fi
  rm -rf "$run"
}

# A scene whose pointers name the devices `left` and `right` needs two drivers.
launch_file_for() {  # SCENE_FILE
  if grep -Eq 'device(=|: *)"?left' "$1" && grep -Eq 'device(=|: *)"?right' "$1"; then
    echo two_hands.launch
  else
    echo demo.launch
  fi
}

read_call "$@"
[ "$rviz" = false ] || TARGETS="$TARGETS haptic_panel"
[ "$wire$option_emulate" = twin ] || TARGETS="$TARGETS motor_guard"
[ -z "$option_emulate" ] || TARGETS="$TARGETS spidar_board_emulator"
SETUP_BUILDS=$TARGETS
# shellcheck disable=SC2046 # one word per section
setup run $([ "$rviz" = false ] || echo view) $([ "$rviz$wire$option_emulate$record" = falsetwin ] || echo tools)
build_stack "$TARGETS"
use_build
begin_run
at_home=false
if [ -n "$option_emulate" ]; then
  start_emulator demo "$device_file" "$run"
  port=$run/emulated_boards wire='file' at_home=true
fi
[ "$wire" = file ] || at_home=true
[ -z "$option_master_port" ] || ensure_master_port "$option_master_port"
master=${option_master_port:-$(free_port)}
export ROS_MASTER_URI="http://127.0.0.1:$master"
echo "demo: in other shells: . $BUILD/devel/setup.sh; export ROS_MASTER_URI=$ROS_MASTER_URI"
# roslaunch asks its nodes to stop, and stops them itself 5 s later: enough to close a bag.
with_progress demo "$log" roslaunch -p "$master" --disable-title --skip-log-check --no-summary \
  --sigint-timeout=5 --sigterm-timeout=1 haptic_bringup "$(launch_file_for "$scene_file")" scene:="$scene_file" \
  device:="$device_file" transport:="$wire" port:="$port" at_home:="$at_home" rate:="${option_rate:-1000}" seconds:="${seconds:-0}" \
  rviz:="$rviz" ground:="$ground" record:="$record" figures:="$lines" default_density:="${option_default_density:-0}" \
  missing_meshes:="${option_missing_meshes:-stop}" xacro:="$(printf %s "$option_xacro" | sed 's/:=/=/' | tr '\n' ' ')"  # roslaunch takes no := within an argument
code=$?
# Whoever closes rviz ends a demo that counts no seconds: it has no figures, and that is no fault.
closed=false
[ "$rviz" = false ] || [ -s "$lines" ] || ! grep -q 'REQUIRED process \[view' "$log" || closed=true
if [ "$code" != 0 ] || ! { [ "$closed" = true ] || [ -s "$lines" ]; }; then
  first_told() { sed -n "s/\x1b\[[0-9;]*m//g; s/^\[ *$1\] *\(\[[^]]*\]\)*:* *//p" "$log" | head -n 1; }
  reason=$(first_told FATAL)
  [ -n "$reason" ] || [ -z "$record" ] || reason=$(first_told ERROR)  # rosbag's: it ends where it cannot record
  fail "demo: ${reason:-stopped before its figures were written; see $log}"
fi
[ "$closed" = false ] || echo 'demo: rviz was closed, which ends the demo'
echo "demo: core library $(sed -n 's/.*core: .*, library \([^,]*\),.*/\1/p' "$log" | head -n 1)"
tell_results
