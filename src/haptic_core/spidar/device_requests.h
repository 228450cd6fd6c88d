/// What other threads may ask of a device; taken up at the start of a tick.
#pragma once
#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {

/// What other threads have asked of a device since the last tick.
struct DeviceRequests {
  bool calibrate = false;  ///< the grip is at `jig` now
  bool recover = false;    ///< leave FAULT or REDUCED, with the force off
  int enable = -1;         ///< 0: force off, 1: on, -1: not asked
  GripPose jig;            ///< only read with `calibrate`

  bool any() const { return calibrate || recover || enable >= 0; }  ///< something was asked

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.calibrate), visit(s.recover), visit(s.enable), visit(s.jig);
  }
};

}  // namespace haptic
