#!/bin/sh
#: bench [NAME]      measure the core, all of it or what NAME matches: for any x86-64 and for x86-64-v3; `python`: what a step
#:                   costs from Python; `fuzz`: a search for contacts that go wrong; `build`: what builds and tests of a
#:                   fresh checkout cost; `scenes` also writes the table of all shipped scenes, build/figures/scenes.md
. "$(dirname "$0")/parts/start.sh"

# What the sources are held to: sizes of functions, classes and of the core, files that an extension touches.
bench_structure() {
  with_progress 'bench structure' "$LOGS/bench-structure.log" python3 -B test/architecture/structure.py --list ||
    failed="$failed structure"
  keep_figures "$csv" "$LOGS/bench-structure.log" none
}

# Which sources ask a shape for its kind.
bench_kinds() {
  with_progress 'bench kinds' "$LOGS/bench-kinds.log" python3 -B test/architecture/shape_kinds_test.py --figures ||
    failed="$failed kinds"
  keep_figures "$csv" "$LOGS/bench-kinds.log" none
}

# The demo figures of all shipped scenes as one table in markdown.
bench_scene_table() {
  build=$1
  python3 -B test/benchmark/scenes_table.py "$LOGS/bench-scenes-$build.log" "$(machine), $(commit), build $build" \
    >"$FIGURES/scenes.md" || failed="$failed scenes_table"
  echo "bench: figures of every scene in $FIGURES/scenes.md"
}

# 100 rounds of loading and unloading each nodelet of a running loop: no crash, no thread, no memory left behind.
bench_reload() {
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

# STOP without a master, and what a run leaves when its parent is killed: processes of the whole stack.
bench_processes() {
  setup run test
  build_stack 'haptic_bridge penalty_sim spidar_driver spidar_driver_node spidar_stop spidar_board_emulator motor_guard
    haptic_msgs_generate_messages haptic_bridge_gencfg'
  use_build
  with_progress 'bench processes' "$LOGS/bench-processes.log" python3 -B "$ROOT/test/benchmark/processes.py" ||
    failed="$failed processes"
  keep_figures "$csv" "$LOGS/bench-processes.log" '-O3 -DNDEBUG -ffp-contract=off'
}

# What a step costs from Python beyond the step itself.
bench_python() {
  setup run python
  build_stack haptic_python
  show_and_keep bench-python python3 -B "$ROOT/test/python/overhead.py"
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

# What builds and tests of a fresh checkout cost. It takes an hour, and wants a machine that does nothing else.
bench_build() {
  # shellcheck disable=SC2046 # one word per section
  setup $(package_sections)
  with_progress 'bench build' "$LOGS/bench-build.log" test/build/build_bench.sh "$BUILD/bench-build" || failed=build
  rm -f "$FIGURES/bench-build.csv"
  keep_figures bench-build "$LOGS/bench-build.log" '-O3 -DNDEBUG -ffp-contract=off'
  [ -z "$failed" ] || fail "bench build: failed; see $LOGS/bench-build.log"
}

[ $# -le 1 ] || fail "bench takes at most one name"
filter=${1:-} failed=''
case $filter in
  python) bench_python; exit ;;
  build) bench_build; exit ;;
  fuzz) bench_fuzz; exit ;;
esac
names=$(for file in test/benchmark/*_bench.cpp; do basename "$file" _bench.cpp; done)
# NAME takes NAME_* with it: parts of one benchmark that are programs of their own.
chosen=$(echo "$names" | grep -x -e "$filter" -e "${filter}_.*" || echo "$names" | grep -F -e "$filter")
[ -n "$chosen" ] || fail "no benchmark matches '$filter'; there are: $(echo "$names" | tr '\n' ' ')build fuzz python"
setup run bench
forget_other_workspaces
targets=$(echo "$chosen" | sed 's/^/bench_/' | tr '\n' ' ')
builds='base v3'
if ! has_x86_64_v3; then
  echo 'bench: this machine has no AVX2: only the build for any x86-64 is measured, under the plain names' >&2
  builds=base
fi
for build in $builds; do
  march='' && [ "$build" = v3 ] && march=x86-64-v3
  configure_and_build "bench-$build" "$ROOT/src" "$BUILD/bench-$build" "$targets" \
    -DHAPTIC_CORE_BENCHMARKS=ON -DHAPTIC_MARCH="$march"
done
csv=bench${filter:+-$filter} failed=''
rm -f "$FIGURES/$csv.csv"
for name in $chosen; do
  for build in $builds; do
    suffix=_base && { [ "$build" = v3 ] || [ "$builds" = base ]; } && suffix=''
    with_progress "bench $name ($build)" "$LOGS/bench-$name-$build.log" env HAPTIC_FIGURE_SUFFIX=$suffix \
      "$(find "$BUILD/bench-$build" -name "bench_$name" -type f)" || failed="$failed $name"
  done
done
echo "bench: tables and notes in $LOGS/bench-*.log, figures in $FIGURES/$csv.csv"
for name in $chosen; do
  for build in $builds; do
    march='' && [ "$build" = v3 ] && march=' -march=x86-64-v3'
    keep_figures "$csv" "$LOGS/bench-$name-$build.log" "-O3 -DNDEBUG -ffp-contract=off$march"
  done
done
case " $(echo "$chosen" | tr '\n' ' ')" in *' plan '*) bench_structure ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' shapes '*) bench_kinds ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' loop '*) bench_reload ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' faults '*) bench_strangers ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' faults '*) bench_processes ;; esac
case " $(echo "$chosen" | tr '\n' ' ')" in *' scenes '*) bench_scene_table "${builds##* }" ;; esac
[ -z "$failed" ] || fail "failed:$failed"
