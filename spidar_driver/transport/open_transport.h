/// Opens the wire that a device description names.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/transport.h"

namespace haptic {

struct TransportSettings {
  std::string port;         ///< uart: serial port; empty: the first of /dev/ttyUSB*, /dev/ttyACM* with boards
  double rate_hz = 1000;    ///< at which exchange will be called
  int baud = 2000000;       ///< uart
  double reply_wait_s = 0;  ///< uart: longest wait for answers [s]; 0: 80 % of the period
  double max_string_speed = 20;  ///< a count that needs more is refused [m/s]
  bool guard = true;             ///< uart: zero currents by a second process when this one dies or stalls
  int usb_unit = -1;             ///< usb: rotary switch of the amplifier, 0–15; -1: any
  TwinSettings twin;             ///< twin: `period` is set from `rate_hz`
};

/// `device.transport` is one of twin, uart, usb_sh4, usb_simple. Motors are off when it returns. Throws
/// SetupError with a remedy: unknown transport, no port or permission, no or too few boards, a rate the wire
/// cannot carry. May take half a second (a scan of the bus). Transports with a wire also implement
/// LinkReporter.
std::unique_ptr<Transport> openTransport(const DeviceDef& device, const TransportSettings& settings);

/// The names that `DeviceDef::transport` may have.
std::vector<std::string> transportNames();

}  // namespace haptic
