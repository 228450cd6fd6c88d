#!/bin/sh
#: demo [--scene S] [--device D] [--rate HZ] [--seconds N] [--rviz] [--light] [--record FILE.bag|FILE.mcap]
#:      [--hardware | --port P | --emulate] [--default-density KG_PER_M3] [--missing-meshes box|skip|stop]
#:      [--xacro NAME:=VALUE]...
#:                   close the loop between a device (a simulated one by default) and a scene; ends after
#:                   N seconds (10 unless --rviz), with figures; --hardware and --port take the real device,
#:                   --light is --rviz on a light ground; --emulate: its motor boards on a pseudo-terminal, where its file
#:                   names boards (--device uart: those of SPIDAR-G6X5R); --scene param:/robot_description takes the
#:                   robot from the parameter server of ROS_MASTER_URI
caller_master=${ROS_MASTER_URI:-http://127.0.0.1:11311}
. "$(dirname "$0")/parts/start.sh"
TARGETS='haptic_bridge penalty_sim spidar_driver haptic_msgs_generate_messages_cpp haptic_msgs_generate_messages_py haptic_bridge_gencfg'

read_options() {
  scene=touch_cube device=spidar_g6x3r rate=1000 seconds='' rviz=false ground=dark record='' density=0 missing=stop xacro=''
  wire=twin port='' emulate=false at_home=false layout=''
  while [ $# -gt 0 ]; do
    case $1 in
      --rviz) rviz=true && shift && continue ;;
      --light) rviz=true ground=light && shift && continue ;;
      --hardware) wire=file && shift && continue ;;
      --emulate) emulate=true && shift && continue ;;
      --scene | --device | --rate | --seconds | --record | --port | --default-density | --missing-meshes | --xacro)
        [ $# -ge 2 ] || fail "demo: $1 needs a value" ;;
      *) fail "demo: unknown option '$1'; there are --scene --device --rate --seconds --rviz --light --record --hardware --port --emulate --default-density --missing-meshes --xacro" ;;
    esac
    case $1 in
      --scene) scene=$2 ;;
      --device) device=$2 ;;
      --rate) rate=$2 ;;
      --seconds) seconds=$2 ;;
      --record) record=$2 ;;
      --port) port=$2 wire=file ;;
      --default-density) density=$2 ;;
      --missing-meshes) missing=$2 ;;
      --xacro) xacro="$xacro${xacro:+ }$(printf %s "$2" | sed 's/:=/=/')" ;;  # roslaunch takes no := within an argument
    esac
    shift 2
  done
  [ "$device" != uart ] || { device=spidar_g6x5r emulate=true; }
}

check_options() {
  case $scene in
    param:*) ;;  # read once there is a folder for it
    *) scene_file=$(find_scene "$scene") || exit 1 ;;
  esac
  device_file=$(find_device "$device") || exit 1
  [ "$emulate" = false ] || grep -q '^boards:' "$device_file" ||
    fail "demo: --emulate: $device_file names no boards; take --device uart, or write its boards there"
  is_number "$rate" || fail "demo: --rate '$rate' is not a number of ticks per second"
  case $missing in box | skip | stop) ;; *) fail "demo: --missing-meshes '$missing' is none of box, skip, stop" ;; esac
  if [ -n "$seconds" ]; then is_number "$seconds" || fail "demo: --seconds '$seconds' is not a time in seconds"; fi
  if [ "$density" != 0 ]; then is_number "$density" || fail "demo: --default-density '$density' is not a density in kg/m3"; fi
  if [ "$rviz" = true ]; then
    [ -n "${DISPLAY:-}" ] || fail "demo: --rviz needs a display; set DISPLAY, or use xvfb-run ./run demo --rviz"
  else
    seconds=${seconds:-10}
  fi
  [ -n "$record" ] || return 0
  record=$(absolute "$record")
  [ -d "$(dirname "$record")" ] || fail "demo: --record '$record': no such folder"
  case $record in *.bag | *.mcap) ;; *) record=$record.bag ;; esac
  [ ! -d "$record" ] || fail "demo: --record '$record' is a folder"
  # root may write where a disk is read-only, or so the permissions say: only writing tells.
  (: >"$record.$$") 2>/dev/null || fail "demo: --record '$record' cannot be written: give a folder that is writable"
  rm -f "$record.$$"
}

# A folder of this run alone, so that two runs in one checkout do not meet. What failed stays there for a week.
begin_run() {
  mkdir -p "$BUILD/run" "$FIGURES" "$LOGS"
  find "$BUILD/run" -mindepth 1 -maxdepth 1 -mtime +7 -exec rm -rf {} +
  run=$(mktemp -d "$BUILD/run/demo-XXXXXX") || fail "demo: no folder can be made in $BUILD/run"
  lines=$run/figures log=$run/log
  touch "$run/begin"
  case $scene in
    param:*)
      scene_file=$run/${scene##*/}.urdf
      python3 -B launch/verbs/parts/read_parameter.py "$caller_master" "${scene#param:}" "$scene_file" 2>"$run/problem" ||
        fail "demo: --scene $scene: $(tail -n 1 "$run/problem")" ;;
  esac
}

# Says what a run has written once it has looked at it.
tell_results() {
  if [ -n "$record" ]; then
    bag_problem=$(python3 -B launch/verbs/parts/look_at_recording.py "$record" "$run/begin" \
      "$(awk '$2 == "demo.ticks" { print $3 }' "$lines")" 2>&1) ||
      fail "demo: $(echo "$bag_problem" | tail -n 1)"
    case $record in *.mcap) layout=$(python3 -B penalty_sim/session/mcap_layout.py "$record") || fail "demo: the layout beside $record cannot be written" ;; esac
    echo "demo: recorded $record${layout:+; a layout for Lichtblick and Foxglove: $layout}"
  fi
  (FIGURES=$run && keep_figures demo "$lines" '-O3 -DNDEBUG -ffp-contract=off') || exit 1
  grep '^not measured' "$lines"
  mv -f "$run/demo.csv" "$FIGURES/demo.csv" && mv -f "$log" "$LOGS/demo.log" || fail "demo: $FIGURES cannot be written"
  rm -rf "$run"
}

# The device's motor boards on a pseudo-terminal, with its twin behind them; the grip is at home until the first drive.
start_emulator() {
  link=$run/emulated_boards output=$run/emulator.log
  start_keeper
  setsid "$BUILD/devel/lib/spidar_driver/spidar_board_emulator" --device "$device_file" --link "$link" \
    --hand touch_cube >"$output" 2>&1 </dev/null 9>&- &
  keep "$!"
  waited=0  # tenths of a second
  while ! grep -q '^port ' "$output"; do
    kill -0 "$!" 2>/dev/null || fail "demo: $(tail -n 1 "$output")"
    [ "$waited" -lt 50 ] || fail "demo: the emulator opened no port within 5 s; see $output"
    sleep 0.1
    waited=$((waited + 1))
  done
  port=$link wire=file at_home=true
}

# A scene whose pointers name the devices `left` and `right` needs two drivers.
launch_file_for() {  # SCENE_FILE
  if grep -Eq 'device(=|: *)"?left' "$1" && grep -Eq 'device(=|: *)"?right' "$1"; then
    echo two_hands.launch
  else
    echo demo.launch
  fi
}

read_options "$@"
check_options
# shellcheck disable=SC2046 # one word per section
setup run $([ "$rviz" = false ] || echo view) $([ "$rviz$wire$emulate$record" = falsetwinfalse ] || echo tools)
[ "$rviz" = false ] || TARGETS="$TARGETS haptic_panel"
[ "$wire" = twin ] && [ "$emulate" = false ] || TARGETS="$TARGETS motor_guard"
[ "$emulate" = false ] || TARGETS="$TARGETS spidar_board_emulator"
build_stack "$TARGETS"
use_build
begin_run
[ "$emulate" = false ] || start_emulator
[ "$wire" = file ] || at_home=true
master=$(free_port)
export ROS_MASTER_URI="http://127.0.0.1:$master"
[ "$rviz" = false ] && [ "$wire" = twin ] || echo "demo: in other shells: . $BUILD/devel/setup.sh; export ROS_MASTER_URI=$ROS_MASTER_URI" >&2
# roslaunch asks its nodes to stop, and stops them itself 5 s later: enough to close a bag.
with_progress demo "$log" roslaunch -p "$master" --disable-title --skip-log-check --no-summary \
  --sigint-timeout=5 --sigterm-timeout=1 haptic_bringup "$(launch_file_for "$scene_file")" scene:="$scene_file" \
  device:="$device_file" transport:="$wire" port:="$port" at_home:="$at_home" rate:="$rate" seconds:="${seconds:-0}" \
  rviz:="$rviz" ground:="$ground" record:="$record" figures:="$lines" default_density:="$density" \
  missing_meshes:="$missing" xacro:="$xacro"
code=$?
if [ "$code" != 0 ] || ! [ -s "$lines" ]; then
  first_told() { sed -n "s/\x1b\[[0-9;]*m//g; s/^\[ *$1\] *\(\[[^]]*\]\)*:* *//p" "$log" | head -n 1; }
  reason=$(first_told FATAL)
  [ -n "$reason" ] || [ -z "$record" ] || reason=$(first_told ERROR)  # rosbag's: it ends where it cannot record
  fail "demo: ${reason:-stopped before its figures were written; see $log}"
fi
echo "demo: core library $(sed -n 's/.*core: .*, library \([^,]*\),.*/\1/p' "$log" | head -n 1)"
tell_results
