/// What the real-time thread tells telemetry about one tick.
#pragma once
#include <array>
#include <cstdint>

#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {

/// One hand in one tick.
struct HandSample {
  Pose X_BG;                           ///< measured grip, in the device's base
  unsigned flags = 0;                  ///< see DeviceFlag
  DeviceState state = DeviceState::kUncalibrated;
  Wrench F_asked_B, F_achieved_B;      ///< on the hand at G's origin, in B, after the device's limits
  double pointer_force = 0;            ///< |force of the world on the pointer| [N]
  double opening = 0;                  ///< of a 7-DOF grip [m]
  bool calibrated = false;             ///< X_BG means something
  bool simulated = false;              ///< X_BG_true is known
  Pose X_BG_true;                      ///< of the twin's grip at the instant of the counts
  bool strings_known = false;          ///< F_strings_B is known: of a twin
  Wrench F_strings_B;                  ///< what its strings did, mean over the last period, at G's origin: as told a tick before
  bool over_clamp = false;             ///< a tension or the wrench left the device's bounds: must not happen
};

struct TickSample {
  std::uint64_t tick = 0;              ///< index since the start
  std::int64_t start_ns = 0;           ///< steady clock
  std::int64_t tick_ns = 0;            ///< HapticLoop::tick, and the twin where there is one
  std::int64_t io_ns = 0;              ///< the exchange with the devices
  std::int64_t lateness_ns = 0;        ///< start after the deadline
  int lost_periods = 0;                ///< > 0: the tick counts as missed
  bool paused = false;
  double simulated_time = 0;           ///< [s]
  int hands = 0;
  std::array<HandSample, kMaxHands> hand;
  StepReport step;
};

}  // namespace haptic
