#!/bin/sh
#: report [SCENE...] [--quick] [--only stability] [--scheduler ADDRESS] [--results FILE]
#:                   error against run time of every method and peer, what to choose, stability, what scenes leave out: one
#:                   HTML page and a CSV below build/report. SCENE is a name or any URDF; resumes what was interrupted.
#:                   FILE: runs of another engine, a JSON line each (test/report/README.md)
#: report BAG [--output FILE]
#:                   a recording, bag or MCAP, as one HTML page: the scene in 3-D, poses, forces, tensions, contacts, energy, tick times, faults, with zoom
. "$(dirname "$0")/parts/start.sh"
for word; do
  case $word in -*) continue ;; esac
  is_recording "$word" || continue
  setup run pages
  command -v npm >/dev/null || (setup npm) || echo 'report: npm is not here, so the page gets no 3-D view' >&2
  build_stack 'haptic_msgs_generate_messages_py session_table'
  use_build
  show_and_keep report-session python3 -B "$ROOT/penalty_sim/session/session_report.py" \
    --program "$BUILD/devel/lib/penalty_sim/session_table" "$@"
  exit
done
case " $* " in *' --only stability '*) csv=report-stability ;; *) csv=report ;; esac
setup run bench report
forget_other_workspaces
flags='-O3 -DNDEBUG -ffp-contract=off'
configure_and_build bench "$ROOT/src" "$BUILD/bench" report_programs -DHAPTIC_CORE_BENCHMARKS=ON
mkdir -p "$FIGURES"
rm -f "$FIGURES/$csv.csv"
(cd "$CALLER" && exec python3 -B "$ROOT/test/report/report.py" --programs "$BUILD/bench" \
  --output "$BUILD/report" --flags "$flags" "$@") >"$LOGS/$csv.log"
code=$?
grep -v '^figure ' "$LOGS/$csv.log"
keep_figures "$csv" "$LOGS/$csv.log" "$flags"
exit "$code"
