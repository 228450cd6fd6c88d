/// Links that hands lead in an implicit step: friction and force elements that act on them are told the way that they go over the step.
#pragma once
#include <vector>

#include "haptic_core/dynamics/kinematics.h"

namespace haptic::stepping {

/// Links that hands lead within a step.
struct HeldLinks {
  std::vector<int> by;         ///< by link: its lead, or -1
  const Twist* way = nullptr;  ///< by lead: motion of the held link over the step, about its frame's origin [rad, m]
  double step = 0;             ///< its length [s]
  double left = 0;             ///< how far from the step's end they are placed [s]
};

/// (in realtime) Way over the step of a point of a link that a hand leads [rad, m]; zero where none does. `links`: by link, where they are.
inline Twist ledWay(const HeldLinks& held, const LinkWork* links, int link, const Vector3& p_W) noexcept {
  const int lead = link >= 0 ? held.by[link] : -1;
  return lead < 0 ? Twist{} : held.way[lead].shifted(p_W - links[link].X_WL.p);
}

}  // namespace haptic::stepping
