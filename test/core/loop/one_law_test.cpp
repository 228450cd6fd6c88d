// One law for every force: whatever changes beside a pressed contact, neither the wrench that is asked of the strings nor their tensions
// change faster than the law; and it goes on from where it was, so that a hand is neither let go nor struck.
#include <gtest/gtest.h>

#include "../../scenes/pressed_hand.h"
#include "haptic_core/world/hand_bound.h"

namespace haptic {
namespace one_law_test {

constexpr double kMost = kForceRate * scenes::kPressPeriod * (1 + 1e-9);  // [N] in a tick, beyond K |Δx|
/// What the strings add [N]: λ loses up to 3 % of a change, and the pose at which they act has moved on.
constexpr double kStrings = 0.1;

class OneLaw : public ::testing::TestWithParam<int> {};

TEST_P(OneLaw, NothingElseChangesAForceFaster) {
  const scenes::HandEvent event = scenes::handEvents()[static_cast<std::size_t>(GetParam())];
  for (const bool jig : {true, false}) {
    scenes::PressedHand rig(GetParam() % 2 == 1, jig);
    ASSERT_GT(rig.force(), 0.8 * scenes::kPressed);
    rig.jump = rig.asked_jump = 0;
    event.happen(rig);
    rig.run(400);
    if (event.at_once) {
      EXPECT_GT(rig.jump, 3) << event.name << ": it ends a force at once";
    } else {
      EXPECT_LE(rig.asked_jump, kMost) << event.name << (jig ? ", jig" : ", hand");
      EXPECT_LE(rig.jump, kMost + kStrings) << event.name << (jig ? ", jig" : ", hand");
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Events, OneLaw, ::testing::Range(0, static_cast<int>(scenes::handEvents().size())),
                         [](const auto& info) { return std::string(scenes::handEvents()[static_cast<std::size_t>(info.param)].name); });

/// A force that is released while the hand moves along it gives at most what the stiffest wall would have given back, and the observer
/// counts it: it is presented, and what is presented is what is summed.
TEST(OneLaw, WhatAReleaseGivesIsCounted) {
  scenes::PressedHand rig(false, true);
  const double K = rig.device.stableStiffness(), F = rig.force(), before = rig.loop->report().hand[0].port_energy;
  rig.loop->take({PauseWorld{true}});
  rig.depth = 0;  // back at 40 mm/s, along the force
  rig.run(1000);
  const double given = before - rig.loop->report().hand[0].port_energy;
  const double slope = K + kForceRate / 0.04;
  EXPECT_LT(rig.loop->report().hand[0].F_asked_B.force.norm(), 1e-9);
  // The least tensions, 0.3 N a string, are balanced: what they do on the way back is within 5 % of the work.
  EXPECT_NEAR(given, F * F / (2 * slope), 0.05 * F * F / (2 * slope) + 1e-3);
  EXPECT_LT(given, F * F / (2 * K) + 1e-3);
}

}  // namespace one_law_test
}  // namespace haptic
