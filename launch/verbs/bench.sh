#!/bin/sh
#: bench [NAME]      measure the core, all of it or what NAME matches; `anywhere`: pages in 3-D, MCAP, the gallery, a page to touch scenes,
#:                   an hour; `build`: what builds and tests of a fresh checkout cost; `dispatch`: bits and times of the two
#:                   libraries;
#:                   `house`: how the core is built, whether observers and order change the motion, and instructions, over those of
#:                   another build folder with `house --before BUILD`; `first`: first calls on bare systems of both releases;
#:                   `experiment`: studies on the twin, 45 minutes; `fuzz`: a search for contacts that go wrong; `python`: what a
#:                   step costs from Python; `workbench`: what people see, type and publish; `scenes` also writes the table of all shipped scenes, build/figures/scenes.md, and `robots`
#:                   that of the robots below ../shared and the folder HAPTIC_ROBOTS, build/figures/robots.md
. "$(dirname "$0")/parts/start.sh"

# What the sources are held to: sizes of functions, classes and of the core, files that an extension touches.
bench_structure() {
  with_progress 'bench structure' "$LOGS/bench-structure.log" python3 -B test/architecture/structure.py --list ||
    failed="$failed structure"
  keep_figures "$csv" "$LOGS/bench-structure.log" none
}

# How the core's sources are built, and instructions of three pieces of work.
bench_house() {
  with_progress 'bench house' "$LOGS/bench-house-sources.log" python3 -B test/benchmark/house.py --build "$BUILD/bench" \
    ${before:+--before "$before"} || failed="$failed house"
  keep_figures "$csv" "$LOGS/bench-house-sources.log" '-O3 -DNDEBUG -ffp-contract=off'
}

# Which sources ask a shape for its kind.
bench_kinds() {
  with_progress 'bench kinds' "$LOGS/bench-kinds.log" python3 -B test/architecture/shape_kinds_test.py --figures ||
    failed="$failed kinds"
  keep_figures "$csv" "$LOGS/bench-kinds.log" none
}

# The demo figures of all shipped scenes as one table in markdown.
bench_scene_table() {
  python3 -B test/benchmark/scenes_table.py "$LOGS/bench-scenes.log" "$(machine), $(commit)" \
    >"$FIGURES/scenes.md" || failed="$failed scenes_table"
  echo "bench: figures of every scene in $FIGURES/scenes.md"
}

# Every robot that was tried, as one table in markdown.
bench_robots_table() {
  python3 -B test/benchmark/robots_table.py "$LOGS/bench-robots.log" "$(machine), $(commit)" \
    >"$FIGURES/robots.md" || failed="$failed robots_table"
  echo "bench: every robot that was tried in $FIGURES/robots.md"
}

# Robots with odd texts in every attribute: what they end, through the library, Python and ~spawn of a running loop.
bench_texts() {
  setup run test python
  build_stack 'odd_files haptic_python haptic_bridge penalty_sim spidar_driver motor_guard haptic_msgs_generate_messages
    haptic_bridge_gencfg' ON
  use_build
  with_progress 'bench texts' "$LOGS/bench-texts.log" python3 -B test/benchmark/odd_texts.py \
    --program "$(find "$BUILD" -name odd_files -type f)" || failed="$failed texts"
  keep_figures "$csv" "$LOGS/bench-texts.log" '-O3 -DNDEBUG -ffp-contract=off'
}

# 100 rounds of loading and unloading each nodelet of a running loop: no crash, no thread, no memory left behind.
bench_reload() {
  local lines
  lines=$LOGS/reload.lines
  rm -f "$lines"
  # shellcheck disable=SC2046 # one word per section
  setup $(package_sections)
  build_stack 'all tests' ON
  use_build
  with_progress 'bench reload' "$LOGS/bench-reload.log" env HAPTIC_RELOAD_ROUNDS=100 HAPTIC_FIGURES="$lines" \
    rostest -t "$ROOT/test/ros/reload.test" || failed="$failed reload"
  [ ! -f "$lines" ] || keep_figures "$csv" "$lines" '-O3 -DNDEBUG -ffp-contract=off'
}

# What strangers on the network get through, and success that is claimed falsely: nodes, masters, hosts and disks of their own.
bench_strangers() {
  local lines each
  lines=$LOGS/strangers.lines
  rm -f "$lines"
  # shellcheck disable=SC2046 # one word per section
  setup $(package_sections)
  build_stack all
  use_build
  for each in strangers written; do
    with_progress "bench $each" "$LOGS/bench-$each.log" env HAPTIC_STRANGERS=334 HAPTIC_FIGURES="$lines" \
      python3 -B "$ROOT/test/commands/${each}_test.py" -v || failed="$failed $each"
  done
  [ ! -f "$lines" ] || keep_figures "$csv" "$lines" '-O3 -DNDEBUG -ffp-contract=off'
}

# STOP without a master, what a run leaves when its parent is killed, and programs that are stopped and go on: processes of the whole
# stack. The suspends take half an hour.
bench_processes() {
  local each
  setup run test
  build_stack 'haptic_bridge penalty_sim spidar_driver spidar_driver_node spidar_stop spidar_board_emulator motor_guard
    haptic_msgs_generate_messages haptic_bridge_gencfg'
  use_build
  for each in processes suspends; do
    with_progress "bench $each" "$LOGS/bench-$each.log" python3 -B "$ROOT/test/benchmark/$each.py" || failed="$failed $each"
    keep_figures "$csv" "$LOGS/bench-$each.log" '-O3 -DNDEBUG -ffp-contract=off'
  done
}

# Bodies and bases that others lead, when a clock goes back: a manager with a clock of its own.
bench_set_clock() {
  local lines
  lines=$LOGS/set-clock.lines
  rm -f "$lines"
  # shellcheck disable=SC2046 # one word per section
  setup $(package_sections)
  build_stack 'all tests' ON
  use_build
  with_progress 'bench set_clock' "$LOGS/bench-set_clock.log" env HAPTIC_FIGURES="$lines" rostest -t "$ROOT/test/ros/set_clock.test" ||
    failed="$failed set_clock"
  [ ! -f "$lines" ] || keep_figures "$csv" "$lines" '-O3 -DNDEBUG -ffp-contract=off'
}

# Files that are damaged: saved states, recordings, robots.
bench_damaged() {
  setup run
  build_stack all
  use_build
  with_progress 'bench damaged' "$LOGS/bench-damaged.log" python3 -B "$ROOT/test/benchmark/damaged.py" || failed="$failed damaged"
  keep_figures "$csv" "$LOGS/bench-damaged.log" '-O3 -DNDEBUG -ffp-contract=off'
}

# Bits and times of the two libraries, and of the last release that had one library per build. Its sources come from git.
DISPATCH_BEFORE=46c564e
bench_dispatch() {
  local released bag
  released=$BUILD/dispatch/before
  if [ ! -d "$released" ]; then
    mkdir -p "$BUILD/dispatch"
    git -c safe.directory='*' worktree prune
    git -c safe.directory='*' worktree add --force --detach "$released" "$DISPATCH_BEFORE" >"$LOGS/dispatch-before.log" 2>&1 ||
      fail "bench dispatch needs commit $DISPATCH_BEFORE to compare with: fetch the whole history (git fetch --unshallow)"
  fi
  configure_and_build dispatch-before "$released/src" "$BUILD/dispatch/before-v3" haptic_core -DHAPTIC_MARCH=x86-64-v3
  configure_and_build bench "$ROOT/src" "$BUILD/bench" 'scene_hashes bench_dispatch' -DHAPTIC_CORE_BENCHMARKS=ON
  bag=$BUILD/dispatch/touch_cube.bag
  rm -f "$bag"
  "$ROOT/run" demo --scene touch_cube --seconds 3 --record "$bag" >"$LOGS/dispatch-demo.log" 2>&1 ||
    fail "the recording for bench dispatch failed; see $LOGS/dispatch-demo.log"
  build_stack haptic_replay
  with_progress 'bench dispatch' "$LOGS/bench-dispatch.log" python3 -B test/benchmark/dispatch.py --build "$BUILD/bench" \
    --stack "$BUILD" --before "$released" --before-build "$BUILD/dispatch/before-v3" --bag "$bag" || failed="$failed dispatch"
}

# What a step costs from Python beyond the step itself.
bench_python() {
  setup run python
  build_stack haptic_python
  show_and_keep bench-python python3 -B "$ROOT/test/python/overhead.py"
}

# The peers in WebAssembly, if npm can fetch them. Who has set its folder keeps it.
find_wasm_peers() {
  [ -z "${HAPTIC_WASM_PEERS+set}" ] || return 0
  HAPTIC_WASM_PEERS=$(cd penalty_sim/session && python3 -B -c '
import sys, npm_modules
try:
    print(npm_modules.modules(sys.argv[1]))
except npm_modules.Unavailable as reason:
    print(f"bench: without the engines in WebAssembly: {reason}", file=sys.stderr)' "$ROOT/test/peers/wasm")
  export HAPTIC_WASM_PEERS
}

# Studies: fits, simulated subjects, sessions at their own pace on the twin, kills. It takes three quarters of an hour.
bench_experiment() {
  setup run pages python experiment
  build_stack 'haptic_bridge penalty_sim spidar_driver spidar_stop motor_guard session_table haptic_python
    haptic_msgs_generate_messages_cpp haptic_msgs_generate_messages_py haptic_bridge_gencfg'
  use_build
  with_progress 'bench experiment' "$LOGS/bench-experiment.log" python3 -B test/benchmark/experiment.py \
    --program "$BUILD/devel/lib/penalty_sim/session_table" || failed=experiment
  rm -f "$FIGURES/bench-experiment.csv"
  keep_figures bench-experiment "$LOGS/bench-experiment.log" '-O3 -DNDEBUG -ffp-contract=off'
  [ -z "$failed" ] || fail "bench experiment: failed; see $LOGS/bench-experiment.log"
}

# What people see, type and publish: frames, numbers, recordings that were cut, studies. It takes half an hour.
bench_workbench() {
  setup run pages python experiment test tools view docs
  build_stack 'all tests' ON
  use_build
  with_progress 'bench workbench' "$LOGS/bench-workbench.log" python3 -B test/benchmark/workbench.py --build "$BUILD" || failed=workbench
  rm -f "$FIGURES/bench-workbench.csv"
  keep_figures bench-workbench "$LOGS/bench-workbench.log" '-O3 -DNDEBUG -ffp-contract=off'
  [ -z "$failed" ] || fail "bench workbench: failed; see $LOGS/bench-workbench.log"
}

# What a user meets on a machine that has nothing: bare systems of both releases. It takes an hour and a half.
bench_first() {
  setup test
  with_progress 'bench first' "$LOGS/bench-first.log" python3 -B test/build/first.py || failed=first
  rm -f "$FIGURES/bench-first.csv"
  keep_figures bench-first "$LOGS/bench-first.log" none
  [ -z "$failed" ] || fail "bench first: failed; see $LOGS/bench-first.log"
}

# Coverage-guided, for five minutes. An input that goes wrong is left in build/fuzz.
bench_fuzz() {
  setup run fuzz
  with_progress 'bench fuzz' "$LOGS/bench-fuzz.log" test/fuzz/run.sh "$BUILD/fuzz" 300 || failed=fuzz
  rm -f "$FIGURES/bench-fuzz.csv"
  awk '
    /^stat::number_of_executed_units:/ { print "figure fuzz.executions", $2, "1" }
    / cov: / { for (i = 1; i < NF; ++i) if ($i == "cov:") edges = $(i + 1) }
    /^SUMMARY: / { ++violations }
    END { print "figure fuzz.edges", edges + 0, "1"; print "figure fuzz.violations", violations + 0, "1" }' \
    "$LOGS/bench-fuzz.log" >"$LOGS/bench-fuzz.figures"
  keep_figures bench-fuzz "$LOGS/bench-fuzz.figures" '-O2 -g -fsanitize=fuzzer,address,undefined'
  [ -z "$failed" ] || fail "bench fuzz: failed; see $LOGS/bench-fuzz.log"
}

# Sessions seen anywhere: the page in 3-D, an hour as MCAP, the gallery. It takes an hour and five minutes. Recording costs the loop what
# `bench loop` counts, whoever keeps the messages: the recorder is a process of its own.
bench_anywhere() {
  local each
  # shellcheck disable=SC2046 # one word per section
  setup $(package_sections)
  build_stack 'all pack_scenes'
  use_build
  configure_and_build bench "$ROOT/src" "$BUILD/bench" 'bench_loop scene_hashes' -DHAPTIC_CORE_BENCHMARKS=ON
  rm -f "$FIGURES/bench-anywhere.csv"
  touch_page "$BUILD/wasm/touch.html" >"$LOGS/bench-anywhere-touch.log" || failed="$failed touch"
  keep_figures bench-anywhere "$LOGS/bench-anywhere-touch.log" '-O3 -DNDEBUG -ffp-contract=off'
  for each in wasm page3d gallery mcap; do
    with_progress "bench anywhere $each" "$LOGS/bench-anywhere-$each.log" python3 -B "$ROOT/test/benchmark/anywhere.py" "$each" ||
      failed="$failed $each"
    keep_figures bench-anywhere "$LOGS/bench-anywhere-$each.log" '-O3 -DNDEBUG -ffp-contract=off'
  done
  with_progress 'bench anywhere cost' "$LOGS/bench-anywhere-cost.log" "$(find "$BUILD/bench" -name bench_loop -type f)" costs ||
    failed="$failed cost"
  sed -n 's/^figure record.loop_cost_pct /figure mcap.cost_pct /p' "$LOGS/bench-anywhere-cost.log" >"$LOGS/bench-anywhere-cost.figures"
  keep_figures bench-anywhere "$LOGS/bench-anywhere-cost.figures" '-O3 -DNDEBUG -ffp-contract=off'
  [ -z "$failed" ] || fail "bench anywhere: failed:$failed; see $LOGS/bench-anywhere-*.log"
}

# What builds and tests of a fresh checkout cost. It takes an hour, and wants a machine that does nothing else.
bench_build() {
  # shellcheck disable=SC2046 # one word per section
  setup $(package_sections)
  with_progress 'bench build' "$LOGS/bench-build.log" test/build/build_bench.sh "$BUILD/bench-build" || failed=build
  rm -f "$FIGURES/bench-build.csv"
  keep_figures bench-build "$LOGS/bench-build.log" '-O3 -DNDEBUG -ffp-contract=off'
  [ -z "$failed" ] || fail "bench build: failed; see $LOGS/bench-build.log"
}

judge bench before=folder -- "$@"
at_most 1 bench 'one name'
filter=$option_word_1 failed='' before=''
case $filter in *[!a-z0-9_]*) fail "bench: '$filter' is no name of a benchmark" ;; esac
if [ -n "$option_before" ]; then
  [ "$filter" = house ] || fail "bench: --before BUILD is for bench house"
  before=$(cd "$(absolute "$option_before")" && pwd -P) || fail "bench house --before '$option_before': no such folder"
fi
SETUP_BUILDS=bench
case $filter in
  python) bench_python; exit ;;
  anywhere) bench_anywhere; exit ;;
  build) bench_build; exit ;;
  first) bench_first; exit ;;
  fuzz) bench_fuzz; exit ;;
  experiment) bench_experiment; exit ;;
  workbench) bench_workbench; exit ;;
esac
names=$(for file in test/benchmark/*_bench.cpp; do basename "$file" _bench.cpp; done)
# NAME takes NAME_* with it: parts of one benchmark that are programs of their own.
chosen=$(echo "$names" | grep -x -e "$filter" -e "${filter}_.*" || echo "$names" | grep -F -e "$filter")
[ -n "$chosen" ] || fail "no benchmark matches '$filter'; there are: $(echo "$names" | tr '\n' ' ')anywhere build experiment first fuzz python workbench"
setup run bench
forget_other_workspaces
targets=$(echo "$chosen" | sed 's/^/bench_/' | tr '\n' ' ')
configure_and_build bench "$ROOT/src" "$BUILD/bench" "$targets" -DHAPTIC_CORE_BENCHMARKS=ON
case " $(echo "$chosen" | tr '\n' ' ')" in *' peers '*) find_wasm_peers ;; esac
csv=bench${filter:+-$filter}
rm -f "$FIGURES/$csv.csv"
for name in $chosen; do
  [ "$name" = dispatch ] || with_progress "bench $name" "$LOGS/bench-$name.log" \
    "$(find "$BUILD/bench" -name "bench_$name" -type f)" || failed="$failed $name"
done
case " $(echo "$chosen" | tr '\n' ' ')" in *' dispatch '*) bench_dispatch ;; esac
echo "bench: tables and notes in $LOGS/bench-*.log, figures in $FIGURES/$csv.csv"
for name in $chosen; do
  keep_figures "$csv" "$LOGS/bench-$name.log" '-O3 -DNDEBUG -ffp-contract=off'
done
case " $(echo "$chosen" | tr '\n' ' ')" in *' plan '*) bench_structure ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' house '*) bench_house ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' shapes '*) bench_kinds ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' loop '*) bench_reload ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' faults '*) bench_strangers ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' faults '*) bench_processes ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' faults '*) bench_set_clock ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' faults '*) bench_damaged ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' scenes '*) bench_scene_table ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' robots '*) bench_robots_table ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' robots '*) bench_texts ;; esac
[ -z "$failed" ] || fail "failed:$failed"
