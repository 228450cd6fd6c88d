/// What turns behind the emulated boards: currents in, shaft positions out.
#pragma once
#include <cstdint>

namespace haptic {

/// Channels are numbered over all boards, in order of their ids, as the driver numbers them.
class MotorPlant {
 public:
  virtual ~MotorPlant() = default;
  virtual void advance(std::int64_t now_ns) = 0;            ///< moves on to that instant of the line's clock
  virtual void drive(int channel, std::int16_t digit) = 0;  ///< current reference, as the wire carries it
  virtual std::int32_t position(int channel) const = 0;     ///< multi-turn count of the shaft's sensor
};

}  // namespace haptic
