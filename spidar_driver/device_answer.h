/// Asks something of a device and waits until a tick has done it, so that a service answers with what
/// happened.
#pragma once
#include <functional>
#include <string>

#include "haptic_core/loop/ports.h"

namespace haptic {

struct DeviceAnswer {
  bool done = false;    ///< a tick took the request up; false: it was withdrawn and will not happen later
  std::string message;  ///< when done, the state after that tick and what to do now; else why not
  DeviceRecord after;   ///< the device after that tick
};

/// `request` calls one of Spidar's requests. Waits up to a second: a calibration waits for fresh counts of
/// every board.
DeviceAnswer askDevice(Spidar& device, PortOffer& offer, const std::function<void(Spidar&)>& request);

}  // namespace haptic
