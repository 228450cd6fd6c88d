#!/bin/sh
#: analyse SESSION... [--output PREFIX]
#:                   results of a study's sessions as one HTML page and CSV: psychometric functions with intervals, staircases,
#:                   response times, learning, what was presented, and what was left out and why
. "$(dirname "$0")/parts/start.sh"
judge analyse output=prefix -- "$@"
[ "$option_words" -ge 1 ] || fail "analyse needs the folders of sessions, sub-ID/ses-N"
n=0
while [ "$n" -lt "$option_words" ]; do
  n=$((n + 1))
  eval "is_session \"\$option_word_$n\" || fail \"analyse: '\$option_word_$n' is no session: give the folder sub-ID/ses-N of a study\""
done
setup experiment
show_and_keep analyse python3 -B "$ROOT/haptic_bridge/experiment/analyse.py" "$@"
