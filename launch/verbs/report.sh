#!/bin/sh
#: report [SCENE...] [--quick] [--only stability] [--scheduler ADDRESS]
#:                   error against run time of every method and peer, what to choose, stability, what scenes leave out: one
#:                   HTML page and a CSV below build/report. SCENE is a name or any URDF; resumes what was interrupted
#: report BAG [--output FILE]
#:                   a recording as one HTML page: poses, forces, tensions, contacts, energy, tick times, faults, with zoom
. "$(dirname "$0")/parts/start.sh"
for word; do
  case $word in -*) continue ;; esac
  is_bag "$word" || continue
  setup run pages
  build_stack 'haptic_msgs_generate_messages_py session_table'
  use_build
  show_and_keep report-session python3 -B "$ROOT/penalty_sim/session/session_report.py" \
    --program "$BUILD/devel/lib/penalty_sim/session_table" "$@"
  exit
done
case " $* " in *' --only stability '*) csv=report-stability ;; *) csv=report ;; esac
setup run bench report
forget_other_workspaces
# Our programs for this processor and, beside them, for any x86-64: the peers are Debian's, which are built for any.
build=base flags='-O3 -DNDEBUG -ffp-contract=off'
if has_x86_64_v3; then build=v3 flags="$flags -march=x86-64-v3"; fi
for each in base $build; do
  march='' && [ "$each" = v3 ] && march=x86-64-v3
  targets=report_programs && [ "$each" != "$build" ] && targets=report_run
  [ "$each" = "${done:-}" ] || configure_and_build "bench-$each" "$ROOT/src" "$BUILD/bench-$each" "$targets" \
    -DHAPTIC_CORE_BENCHMARKS=ON -DHAPTIC_MARCH="$march"
  done=$each
done
mkdir -p "$FIGURES"
rm -f "$FIGURES/$csv.csv"
(cd "$CALLER" && exec python3 -B "$ROOT/test/report/report.py" --programs "$BUILD/bench-$build" \
  --base-programs "$BUILD/bench-base" \
  --output "$BUILD/report" --flags "$flags" "$@") >"$LOGS/$csv.log"
code=$?
grep -v '^figure ' "$LOGS/$csv.log"
keep_figures "$csv" "$LOGS/$csv.log" "$flags"
exit "$code"
