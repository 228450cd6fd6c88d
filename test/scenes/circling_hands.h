/// Hands on small circles about where they start, 5 mm wide, so that contacts come and go.
#pragma once
#include <vector>

#include "haptic_core/base/elementary.h"
#include "haptic_core/world/world.h"

namespace haptic::scenes {

/// All hands of a world, from where it is when this is made.
class CirclingHands {
 public:
  explicit CirclingHands(const World& world) {
    for (int i = 0; i < world.pointerCount(); ++i) start_.push_back(world.linkPose(world.pointerLink(i)));
  }
  /// Gives the targets of the next step.
  void move(World& world) const {
    constexpr double kRadius = 5e-3, kRate = 6;  // [m], [rad/s]
    const double a = kRate * (world.time() + world.settings().step);
    for (std::size_t i = 0; i < start_.size(); ++i) {
      Pose X = start_[i];
      X.p += kRadius * Vector3(elementary::sin(a), elementary::sin(2 * a), elementary::cos(a) - 1);
      Twist V;
      V.linear = kRadius * kRate * Vector3(elementary::cos(a), 2 * elementary::cos(2 * a), -elementary::sin(a));
      world.setPointerTarget(static_cast<int>(i), X, V);
    }
  }

 private:
  std::vector<Pose> start_;
};

}  // namespace haptic::scenes
