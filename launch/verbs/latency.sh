#!/bin/sh
#: latency --device D [--port P] [--transport T] [--seconds N] [--emulate]
#:                   how fast this machine and this wire can close a loop; no current flows
. "$(dirname "$0")/parts/start.sh"
if [ "${1:-}" != --device ] || [ $# -lt 2 ]; then
  fail "latency needs --device D first; then --port, --transport, --seconds, --emulate"
fi
device_file=$(find_device "$2") || exit 1
shift 2
setup run
build_stack spidar_latency
echo 'latency: some seconds per rate; no current flows' >&2
show_and_keep latency "$BUILD/devel/lib/spidar_driver/spidar_latency" --device "$device_file" "$@"
