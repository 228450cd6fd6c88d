#!/bin/sh
#: report [SCENE...] [--quick] [--only stability] [--scheduler ADDRESS] [--results FILE]
#:                   error against run time of every method and peer, what to choose, stability, what scenes leave out: one
#:                   HTML page and a CSV below build/report. SCENE is a name or any URDF; resumes what was interrupted.
#:                   FILE: runs of another engine, a JSON line each (test/report/README.md)
#: report BAG [--output FILE]
#:                   a recording, bag or MCAP, as one HTML page: the scene in 3-D, poses, forces, tensions, contacts, energy, tick times, faults, with zoom
. "$(dirname "$0")/parts/start.sh"
judge report quick only=stability,scenes scheduler=address results=file+ output=text keep=text workers=count -- "$@"

# A recording as a page.
report_recording() {
  ensure_recording report "$option_word_1"
  at_most 1 'report of a recording' 'one recording'
  SETUP_BUILDS=stack
  setup run pages
  command -v npm >/dev/null || (setup npm) || echo 'report: npm is not here, so the page gets no 3-D view' >&2
  build_stack 'haptic_msgs_generate_messages_py session_table'
  use_build
  show_and_keep report-session python3 -B "$ROOT/penalty_sim/session/session_report.py" \
    --program "$BUILD/devel/lib/penalty_sim/session_table" "$option_word_1" ${option_output:+--output "$option_output"}
  exit
}

# A file, a shipped scene, or a scene of the report's own catalogue, whose kept results name it.
ensure_scene() {  # NAME_OR_PATH
  case $1 in
    */* | *.urdf | *.xacro | *.yaml) find_scene "$1" >/dev/null ;;
    *) [ -f "test/report/results/$1-total.png" ] || (find_scene "$1" >/dev/null 2>&1) ||
      fail "report: unknown scene '$1'; give a path, or one of: $(find test/report/results -name '*-total.png' |
        sed 's|.*/||; s/-total\.png$//' | sort | tr '\n' ' ')" ;;
  esac
}

n=0
while [ "$n" -lt "$option_words" ]; do
  n=$((n + 1))
  eval "word=\$option_word_$n"
  if is_recording "$word"; then report_recording; fi
  ensure_scene "$word"
done
SETUP_BUILDS=bench
case $option_only in stability) csv=report-stability ;; *) csv=report ;; esac
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
