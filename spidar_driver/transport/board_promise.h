/// How long a board may do other things than it is told before somebody sees it: for the check of a device.
#pragma once
#include <string>

#include "haptic_core/spidar/device_def.h"

namespace haptic {

/// For how long a fault of a device's boards may act unseen.
struct BoardPromise {
  std::string text;           ///< a line for each kind of board; empty: the device has no boards
  double table_s = 0;         ///< longest time for which a spoilt length table may keep a board from its currents [s]
  bool tells_currents = true; ///< every board measures its currents: one that ignores them is seen
};

BoardPromise boardPromise(const DeviceDef& device);  ///< at 1 kHz

}  // namespace haptic
