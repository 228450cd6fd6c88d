// Oracle: the same start in 64 steps. What a step says of its own error has to be of the size of the true one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "../../scenes/blocks.h"
#include "haptic_core/world/state.h"

namespace haptic {
namespace step_error_test {

constexpr int kFine = 64;
constexpr double kStep = 1e-3;

/// A cube whose floor holds it at k [N/m³]; it starts above where it rests by half of its depth, and slides at `speed` [m/s].
WorldDef heavingCube(double k, double speed, double step) {
  scenes::CubeParameters c;
  c.stiffness = k;
  c.ratio = 0.02;
  WorldSettings settings;
  settings.step = step;
  WorldDef def = scenes::cubeOnFloor(c, settings);
  def.articulations[1].X_WA.p.z() += 0.5 * c.restDepth();
  def.articulations[1].V_WA = Twist{Vector3::Zero(), Vector3(speed, 0, 0)};
  return def;
}

/// A cube at rest in its floor that sticks to it by hardly more than a damper of rate γ [1/s].
WorldDef draggedCube(double rate, double step) {
  scenes::CubeParameters c;
  c.stiffness = 6.25e5;
  c.tangential = 1e-3;
  c.tangential_ratio = 0.5 * rate / std::sqrt(c.tangential * c.stiffness * c.area() / c.mass);
  WorldSettings settings;
  settings.step = step;
  WorldDef def = scenes::cubeOnFloor(c, settings);
  def.articulations[1].V_WA = Twist{Vector3::Zero(), Vector3(1e-4, 0, 0)};
  return def;
}

/// True error of each step over the one that it foresees, in ascending order. `make`: the scene with a step [s].
template <class Make>
std::vector<double> ratios(int steps, Make&& make) {
  World world(make(kStep)), fine(make(kStep / kFine));
  std::vector<double> out;
  for (int i = 0; i < steps; ++i) {
    fine.restore(world.save());
    world.step();
    for (int j = 0; j < kFine; ++j) fine.step();
    const double truth = (world.linkPose(1).p - fine.linkPose(1).p).norm();
    if (truth > 1e-12) out.push_back(truth / world.report().position_error);
  }
  std::sort(out.begin(), out.end());
  return out;
}

TEST(StepError, AnImplicitStepForeseesItsErrorToItsSize) {
  const std::vector<double> all = ratios(300, [](double step) { return heavingCube(1e8, 1, step); });
  ASSERT_GT(all.size(), 50u);
  EXPECT_GT(all[all.size() / 2], 0.1);
  EXPECT_LT(all[all.size() / 2], 3);
}

/// A ball in a hand that is pressed into a wall at 0.1 m/s: the mean of the force over a step is that of its middle, what the hand gets
/// that of its end.
TEST(StepError, TheForceOnAHandSaysItsError) {
  constexpr double kSpeed = 0.1;
  const auto scene = [](double step) {
    WorldDef def;
    def.settings.step = step;
    def.settings.default_material.stiffness = 1e7;
    def.articulations.push_back(scenes::floorBox());
    def.articulations.push_back(scenes::freeBox("tool", Vector3::Constant(0.02), 0.1, Pose(Vector3(0, 0, 0.0105))));
    PointerDef hand;
    hand.articulation = 1;
    hand.link = 0;
    def.pointers.push_back(hand);
    return def;
  };
  const auto aim = [](World& world) {
    const double t = world.time() + world.settings().step;
    world.setPointerTarget(0, Pose(Vector3(0, 0, 0.0105 - kSpeed * t)), Twist{Vector3::Zero(), Vector3(0, 0, -kSpeed)});
  };
  World world(scene(kStep)), fine(scene(kStep / kFine));
  for (int i = 0; i < 20; ++i) {
    State state = world.state();
    state.step *= kFine;
    fine.restore(state.pack());
    aim(world);
    world.step();
    Vector3 mean = Vector3::Zero();
    for (int j = 0; j < kFine; ++j) {
      aim(fine);
      fine.step();
      mean += fine.pointerWrench(0).force / kFine;
    }
    const double truth = (world.pointerWrench(0).force - mean).norm();
    EXPECT_LE(truth, 1.5 * world.pointerForceError(0) + 1e-9) << i;
    if (truth > 1e-9) {
      EXPECT_GE(truth, 0.5 * world.pointerForceError(0)) << i;
    }
  }
}

}  // namespace step_error_test
}  // namespace haptic
