/// What motors do when nobody sends any more: both programs have ended, or the host has.
#pragma once
#include <string>

#include "haptic_core/spidar/device_def.h"

namespace haptic {

struct LastCommand {
  bool ends = false;  ///< the currents end by themselves
  std::string text;   ///< a line per kind of board, for people
};

/// Of the device's boards or amplifier, as far as their protocols tell.
LastCommand lastCommand(const DeviceDef& device);

}  // namespace haptic
