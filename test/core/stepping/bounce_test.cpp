/// Bodies leave a bounce with the speed that their equation of motion gives them.
#include <gtest/gtest.h>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/bounce.h"

namespace haptic {
namespace bounce_test {

using namespace scenes;

/// The boxes of cube and floor are apart again in the step in which the cube parts. Inside, velocity Verlet keeps
/// v² + ω² d² (1 - (hω)²/4), with d up to v h at both ends: (hω)⁴/8 of the speed. The location of touch and release adds
/// less than (hω)⁴/6 each. Without what the release changes of the impulse it would be (hω)²/8.
TEST(Bounce, UndampedKeepsItsSpeedToFourthOrder) {
  for (double k_eff : {1e3, 1e4}) {
    const Bounce bounce{PressureLaw::kLinear, 0, 0.1, k_eff};
    const double angle = kBounceStep * bounce.omega();
    EXPECT_LE(worstExit(bounce, Attempts::kAll, comparators::velocityVerlet), 0.5 * std::pow(angle, 4)) << k_eff;
  }
}

/// The wrench that is reported is the mean over the step, whatever parts it went in.
TEST(Bounce, ReportsTheMeanOverItsParts) {
  const Bounce bounce{PressureLaw::kHuntCrossley, 0.3, 0.1, 2e5};
  World world(bounce.make(0.01, Attempts::kAll));
  double v = 0, most = 0;
  int parts = 0;
  for (int i = 0; i < 200; ++i) {
    world.step();
    double impulse = -bounce.mass * kGravity * kBounceStep;
    for (int c = 0; c < world.contactCount(); ++c) impulse += kBounceStep * world.contact(c).F_BP_W.force.z();
    const double now = world.linkTwist(1).linear.z();
    most = std::max(most, std::abs(impulse));
    ASSERT_NEAR(bounce.mass * (now - v), impulse, 1e-13 * std::max(most, bounce.mass)) << i;
    v = now;
    parts = std::max(parts, world.report().parts);
  }
  EXPECT_GE(parts, 4);
}

}  // namespace bounce_test
}  // namespace haptic
