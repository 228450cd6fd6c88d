// A hand that presses and rests feels rest: no hum of the counts, whatever corner of the workspace it is in.
#include "haptic_core/loop/hand_trial.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../../scenes/touch.h"
#include "haptic_core/geometry/shapes/half_space.h"

namespace haptic {
namespace hand_trial_test {

DeviceDef device(const char* name) { return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml"); }

/// A cube on a spring of K_max over stiff ground, 1 mm above it.
WorldDef overGround(double side = 3e-3) {
  WorldDef world = scenes::pointerOverWall(makeBox(Vector3::Constant(side)), side / 2 + 1e-3, 1e8, 1e-3);
  world.settings.default_material.mu_static = world.settings.default_material.mu_dynamic = 0.5;
  world.articulations[0].links[0].collisions[0].shape = std::make_shared<HalfSpace>();
  world.articulations[0].X_WA = Pose();
  world.pointers[0].coupling.mode = PointerCoupling::Mode::kVirtual;
  world.pointers[0].device = "spidar";
  return world;
}

// Where few strings carry the grip aside a count is more than its own way: read as rounded, 10 of these 32 presses hummed by more than
// 0.3 N (steady_lengths.h).
TEST(HandTrial, AStiffWallDoesNotHumByCounts) {
  const DeviceDef spidar = device("spidar_4");
  HandSettings settings;
  settings.workspace.X_WB.p = Vector3(0, 0, 2.5e-3);
  settings.workspace.scale = 5;
  int rings = 0;
  for (int i = 0; i < 32; ++i) {
    const double tilt = 0.5 + 0.1 * (i % 4), around = 0.7 * i;
    TrialWay way;
    way.direction = Vector3(std::sin(tilt) * std::cos(around), std::sin(tilt) * std::sin(around), -std::cos(tilt));
    way.speed = 0.2;
    way.depth = (0.3 + 0.15 * (i / 8)) * workspaceEnd(spidar, way.direction);
    way.jig = false;
    const TrialResult result = tryHand(overGround(), 0, settings, spidar, way);
    rings += result.rings;
    EXPECT_GT(result.touching, 200) << i;
  }
  EXPECT_EQ(rings, 0);
}

// Without bounds a wall hums where it is touched lightly, and is quiet where the device gives all it has: only a way that rests there too
// hears it. A rest is 0.3 s, and the way goes on from it.
TEST(HandTrial, AWayRestsWhereItIsAskedTo) {
  WorldDef world = overGround(0.01);  // 10 N/mm
  world.pointers[0].coupling.mode = PointerCoupling::Mode::kDirect;
  HandSettings settings;
  settings.workspace.X_WB.p = Vector3(0, 0, 6e-3);
  settings.passivity.mode = PassivityMode::kOff;
  const DeviceDef spidar = device("spidar_g6x3r");
  TrialWay way;
  way.depth = 0.03;
  way.jig = false;
  way.rests = {1};
  const TrialResult deep = tryHand(world, 0, settings, spidar, way);
  EXPECT_GE(deep.strongest, spidar.max_force);
  EXPECT_FALSE(deep.rings);
  way.rests = {0.1, 1};
  const TrialResult both = tryHand(world, 0, settings, spidar, way);
  EXPECT_TRUE(both.rings);
  EXPECT_NEAR(both.ticks - deep.ticks, 300, 1);
  way.rests = {0.02, 1};  // 0.6 mm: in the air
  EXPECT_FALSE(tryHand(world, 0, settings, spidar, way).rings);
  for (const TrialWay& pressing : pressingWays(world, 0, settings, spidar)) EXPECT_EQ(pressing.rests, (std::vector<double>{0.1, 0.25, 1}));
}

}  // namespace hand_trial_test
}  // namespace haptic
