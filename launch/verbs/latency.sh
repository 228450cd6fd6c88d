#!/bin/sh
#: latency --device D [--port P] [--transport T] [--seconds N] [--emulate]
#:                   how fast this machine and this wire can close a loop; no current flows
. "$(dirname "$0")/parts/start.sh"
judge latency device=device port=port transport=twin,uart,usb_sh4,usb_simple seconds=number emulate -- "$@"
at_most 0 latency 'options alone'
[ -n "$option_device" ] || fail "latency needs --device D"
SETUP_BUILDS=spidar_latency
setup run
build_stack spidar_latency
echo 'latency: some seconds per rate; no current flows' >&2
show_and_keep latency "$BUILD/devel/lib/spidar_driver/spidar_latency" --device "$option_device_file" \
  ${option_port:+--port "$option_port"} ${option_transport:+--transport "$option_transport"} \
  ${option_seconds:+--seconds "$option_seconds"} ${option_emulate:+--emulate}
