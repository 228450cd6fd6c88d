#!/bin/sh
#: stop [DEVICE]     STOP: the motors of all devices of this user on this machine off, or of one; needs neither master nor build
. "$(dirname "$0")/parts/start.sh"
judge stop -- "$@"
at_most 1 stop 'the name of one device'
stop=$BUILD/devel/lib/spidar_driver/spidar_stop
[ -x "$stop" ] || stop=/usr/lib/spidar_driver/spidar_stop
[ -x "$stop" ] || fail "stop: spidar_stop is not built: no device of this folder runs; if motors pull, cut their power"
"$stop" "$@"
