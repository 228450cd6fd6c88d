/// The lowest clamp on the way to the motors: whatever is commanded, a string pulls between zero and its
/// maximum.
#pragma once
#include <algorithm>
#include <cmath>

#include "haptic_core/spidar/transport.h"

namespace haptic {

/// True when every value for the device's strings is finite; one that is not makes the whole command
/// unusable, since the other strings alone would pull the grip away.
inline bool finiteDrive(const DeviceDef& device, const DriveCommand& command) {
  for (std::size_t i = 0; i < device.strings.size(); ++i)
    if (!std::isfinite(command.voltage[i])) return false;
  return true;
}

/// The voltage [V] that is let through for one string; `clamped` is set when it is not the one asked for. The
/// tolerance admits the rounding of tension · volt_per_newton / volt_per_newton.
inline double allowedVoltage(const StringDef& string, double voltage, bool& clamped) {
  const double tension = voltage / string.volt_per_newton;
  if (tension >= 0 && tension <= string.max_tension * (1 + 1e-9)) return voltage;
  clamped = true;
  return std::clamp(tension, 0.0, string.max_tension) * string.volt_per_newton;
}

}  // namespace haptic
