# A device's motor boards on a pseudo-terminal. Sourced.

ensure_boards() {  # VERB DEVICE_FILE
  grep -q '^boards:' "$2" || fail "$1: --emulate: $2 names no boards; take --device spidar_g6x5r, or write its boards there"
}

# FOLDER/emulated_boards becomes the port of boards with the device's twin behind them; the grip is at home until the first drive, then it
# follows the script of touch_cube. They end with this verb, or with the program that it becomes by exec.
start_emulator() {  # VERB DEVICE_FILE FOLDER
  local emulator_output emulator_waited
  emulator_output=$3/emulator.log
  hold_signals
  start_keeper
  setsid "$BUILD/devel/lib/spidar_driver/spidar_board_emulator" --device "$2" --link "$3/emulated_boards" \
    --hand touch_cube >"$emulator_output" 2>&1 </dev/null 9>&- &
  keep "$!"
  let_signals
  emulator_waited=0  # tenths of a second
  while ! grep -q '^port ' "$emulator_output"; do
    kill -0 "$!" 2>/dev/null || fail "$1: $(tail -n 1 "$emulator_output")"
    [ "$emulator_waited" -lt 50 ] || fail "$1: the emulator opened no port within 5 s; see $emulator_output"
    sleep 0.1
    emulator_waited=$((emulator_waited + 1))
  done
}
