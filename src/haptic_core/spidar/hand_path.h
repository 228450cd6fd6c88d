/// Scripted motion of the hand that holds the twin's grip: a few keyframes, smoothly joined.
#pragma once
#include <string>
#include <vector>

#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {

/// A keyframe of a HandPath.
struct HandKey {
  double time;       ///< [s]
  Vector3 p_BG;      ///< [m]
  Vector3 rotation;  ///< rotation vector of R_BG [rad]
  double opening;    ///< [m]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.time), visit(s.p_BG), visit(s.rotation), visit(s.opening);
  }
};

/// A scripted motion of the hand: keyframes, smoothly joined.
/// Rest at the first key until its time and at the last one after its own; between two keys a quintic with
/// zero velocity and acceleration at both (minimum jerk), so that the hand's force has no steps.
struct HandPath {
  std::vector<HandKey> keys;                ///< by rising time
  GripPose at(double time) const noexcept;  ///< (in realtime)
  double duration() const { return keys.empty() ? 0 : keys.back().time; }  ///< until the last key [s]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.keys);
  }
};

/// `rest`, `press` (down onto a cube below and left), `touch_cube` (press, slide along, push; repeats every
/// 10 s for a minute) or `wave` (all six degrees of freedom, for calibration). Throws SetupError for another
/// name.
HandPath handPath(const std::string& name);

}  // namespace haptic
