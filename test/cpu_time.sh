#!/bin/sh
# Runs a test and keeps the CPU seconds of all its processes: cpu_time.sh FILE COMMAND...
file=$1
shift
"$@"
code=$?
times >"$file"  # its second line: user and system time of the children
exit "$code"
