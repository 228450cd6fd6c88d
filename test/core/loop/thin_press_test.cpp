// Presses through thin bodies: no ring, no energy to the hand, no tool that hangs in a plate.
#include "../../scenes/thin_presses.h"

#include <gtest/gtest.h>

#include <cmath>

namespace haptic {
namespace thin_press_test {

DeviceDef device(const std::string& name) { return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml"); }

/// Presses of the bench `hand`, of every kind of tool and body; those with a virtual coupling, half of them.
constexpr int kPresses = 24;

TEST(ThinPress, NoCouplingRingsOrGivesEnergy) {
  for (int i = 0; i < kPresses; ++i) {
    const scenes::ThinPress p = scenes::ThinPresses(static_cast<unsigned>(i)).press();
    if (!p.isVirtual()) continue;
    const TrialResult result = tryHand(p.world, 0, p.settings, device(p.device), p.way);
    EXPECT_TRUE(result.steady()) << i << " " << p.text;
    EXPECT_LE(result.jump, kQuietJump) << i << " " << p.text;
    EXPECT_LE(result.energy_given, 0.01) << i << " " << p.text;
  }
}

/// The ball over its plate, a relaxed hand's goal 30 mm below.
TrialResult pressBall(const WorldDef& world, double period) {
  WorldDef scene = world;
  scene.settings.step = period;
  HandSettings settings;
  settings.workspace.X_WB.p = scene.articulations[1].X_WA.p;
  TrialWay way;
  way.depth = 0.03;
  way.rest = 1;
  way.rests = {0.3, 1};
  way.jig = false;
  return tryHand(scene, 0, settings, device("spidar_g6x3r"), way);
}

// Ten newtons to and fro at 50 Hz where a row followed the depth of the contact with the slope of the whole plate.
TEST(ThinPress, ABallOnAPlateThinnerThanItselfIsFeltAsAWall) {
  for (const double period : {1e-3, 2e-4}) {
    for (const double mass : {0.005, 0.05, 0.5}) {
      const WorldDef scene = scenes::ballOverThinPlate(mass);
      const TrialResult pulled = pressBall(scene, period);
      EXPECT_FALSE(pulled.rings) << mass << " kg, " << period << " s";
      WorldDef held = scene;
      held.pointers[0].coupling.mode = PointerCoupling::Mode::kDirect;
      const TrialResult direct = pressBall(held, period);
      ASSERT_FALSE(direct.rings);
      EXPECT_GE(pulled.strongest, 0.8 * direct.strongest) << mass << " kg, " << period << " s";
    }
  }
}

// One count of 17 µm was 0.24 N of the stiffest wall at 10 kHz: what a tremor takes over a few counts hummed under a hand at rest.
TEST(ThinPress, CountsAreNotFeltAtFastRates) {
  for (const unsigned press : {107u, 197u, 223u, 614u}) {
    const scenes::ThinPress p = scenes::ThinPresses(press).press();
    ASSERT_FALSE(p.isVirtual());
    EXPECT_FALSE(tryHand(p.world, 0, p.settings, device(p.device), p.way).rings) << p.text;
  }
}

}  // namespace thin_press_test
}  // namespace haptic
