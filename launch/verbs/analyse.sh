#!/bin/sh
#: analyse SESSION... [--output PREFIX]
#:                   results of a study's sessions as one HTML page and CSV: psychometric functions with intervals, staircases,
#:                   response times, learning, what was presented, and what was left out and why
. "$(dirname "$0")/parts/start.sh"
[ $# -ge 1 ] || fail "analyse needs the folders of sessions, sub-ID/ses-N"
setup experiment
show_and_keep analyse python3 -B "$ROOT/haptic_bridge/experiment/analyse.py" "$@"
