/// Asks something of a device and waits until a tick has done it, so that a service answers with what
/// happened.
#pragma once
#include <string>

#include "haptic_core/loop/ports.h"

namespace haptic {

struct DeviceAnswer {
  bool done = false;    ///< a tick did what was asked; false: it was withdrawn and will not happen later
  std::string message;  ///< when done, the state after that tick and what to do now; else why not
  DeviceCopy after;     ///< the device after that tick
};

/// Waits up to a second: a calibration needs fresh counts of every board, and is asked again until they come.
DeviceAnswer askDevice(DevicePort& port, PortOffer& offer, const DeviceRequests& requests);

}  // namespace haptic
