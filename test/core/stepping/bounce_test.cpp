/// Bodies leave a bounce with the speed that their equation of motion gives them.
#include <gtest/gtest.h>

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
    EXPECT_LE(worstExit(bounce, Attempts::kVerlet), 0.5 * std::pow(angle, 4)) << k_eff;
  }
}

/// In parts where a swing is short, the rule of before errs by 1 % at most: second order with 25 parts in a swing's radian.
TEST(Bounce, OfEveryKindKeepsItsSpeedByVerletFirst) {
  for (const auto& [law, damping] : {std::pair{PressureLaw::kLinear, 0.0}, {PressureLaw::kLinear, 0.3},
                                     {PressureLaw::kLinear, 0.6}, {PressureLaw::kHuntCrossley, 0.3},
                                     {PressureLaw::kHuntCrossley, 2.0}}) {
    for (double k_eff : {1e4, 5e4, 2e5}) {
      EXPECT_LE(worstExit({law, damping, 0.1, k_eff}, Attempts::kVerletFirst), 0.01) << kindOf(law).name << ' ' << damping << ' ' << k_eff;
    }
  }
}

/// Parts are for what moves: at rest a step is one.
TEST(Bounce, RestsInOnePart) {
  World world(Bounce{PressureLaw::kLinear, 0.3, 0.1, 1e5}.make(0.002, Attempts::kVerletFirst));
  int most = 0;
  for (int i = 0; i < 3000; ++i) {
    world.step();
    most = std::max(most, world.report().substeps);
  }
  EXPECT_GE(most, 2);
  EXPECT_EQ(world.report().substeps, 1);
  EXPECT_LT(world.linkTwist(1).linear.norm(), 1e-9);
}

/// Parts cost every touching pair again: more than eight of them are stepped implicitly, once.
TEST(Bounce, IsCutOnlyWhileLittleTouches) {
  for (const int cubes : {8, 9}) {
    WorldDef def = Bounce{PressureLaw::kLinear, 0.3, 0.1, 1e5}.make(0.01, Attempts::kVerletFirst);
    while (static_cast<int>(def.articulations.size()) <= cubes) {
      def.articulations.push_back(def.articulations[1]);
      def.articulations.back().X_WA.p.x() += 2 * kBounceEdge * static_cast<double>(def.articulations.size() - 2);
    }
    World world(def);
    int cut = 0;
    for (int i = 0; i < 200; ++i) {
      const bool touching = world.report().contacts > 0;
      world.step();
      cut += touching && world.report().substeps > 1;
    }
    if (cubes == 8) {
      EXPECT_GE(cut, 3);
    } else {
      EXPECT_EQ(cut, 0);
    }
  }
}

/// The wrench that is reported is the mean over the step, whatever parts it went in.
TEST(Bounce, ReportsTheMeanOverItsParts) {
  const Bounce bounce{PressureLaw::kHuntCrossley, 0.3, 0.1, 2e5};
  World world(bounce.make(0.01, Attempts::kVerletFirst));
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
    parts = std::max(parts, world.report().substeps);
  }
  EXPECT_GE(parts, 4);
}

}  // namespace bounce_test
}  // namespace haptic
