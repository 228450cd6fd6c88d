/// What a world refuses, and what it does when its numbers run away.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/blocks.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/step_history.h"

namespace haptic {
namespace world_faults_test {

using namespace scenes;

/// The message with which a spoiled scene of one cube on a floor is refused; empty when it is taken.
std::string refusal(const std::function<void(WorldDef&)>& spoil) {
  WorldDef def = cubeOnFloor(CubeParameters{}, WorldSettings{});
  spoil(def);
  try {
    World world(def);
  } catch (const SetupError& error) {
    return error.what();
  }
  return "";
}

void expectNamed(const std::string& message, std::initializer_list<const char*> parts) {
  EXPECT_FALSE(message.empty());
  for (const char* part : parts) EXPECT_NE(message.find(part), std::string::npos) << message;
}

TEST(WorldFaults, ASoundSceneIsTaken) {
  EXPECT_EQ(refusal([](WorldDef&) {}), "");
  EXPECT_EQ(refusal([](WorldDef& d) { d.settings.default_material.mu_static = 0.5; }), "");
}

TEST(WorldFaults, MaterialsAreRefusedByNameAndValue) {
  const auto material = [](auto field, double value) {
    return refusal([=](WorldDef& d) { d.articulations[1].links[0].collisions[0].material.*field = value; });
  };
  using M = ContactMaterial;
  expectNamed(material(&M::stiffness, -1e6), {"cube", "stiffness", "-1e+06"});
  expectNamed(material(&M::stiffness, 0), {"cube", "stiffness", "0"});
  expectNamed(material(&M::stiffness, -std::numeric_limits<double>::infinity()), {"cube", "stiffness", "-inf"});  // rigid: +
  expectNamed(material(&M::tangential_stiffness, -1), {"cube", "tangential_stiffness", "-1"});
  expectNamed(material(&M::damping, -2), {"cube", "damping", "-2"});
  expectNamed(material(&M::dissipation, -3), {"cube", "dissipation", "-3"});
  expectNamed(material(&M::mu_static, 11), {"cube", "mu", "11"});
  expectNamed(material(&M::mu_dynamic, -0.1), {"cube", "mu", "-0.1"});
  expectNamed(refusal([](WorldDef& d) {
                d.settings.default_material.mu_static = 0.3;
                d.settings.default_material.mu_dynamic = 0.4;
              }),
              {"mu_dynamic", "0.4", "mu_static"});
}

TEST(WorldFaults, StepsAreRefusedByValue) {
  const auto step = [](double h) { return refusal([h](WorldDef& d) { d.settings.step = h; }); };
  expectNamed(step(0), {"step is 0"});
  expectNamed(step(1), {"step is 1 s"});
  expectNamed(step(-1e-3), {"step is -0.001"});
  expectNamed(step(std::nan("")), {"step is nan"});
  expectNamed(refusal([](WorldDef& d) { d.settings.history_steps = -1; }), {"history_steps is -1"});
  expectNamed(refusal([](WorldDef& d) { d.settings.gravity.z() = std::nan(""); }), {"gravity"});
}

TEST(WorldFaults, BodiesThatCannotMoveAreRefusedByName) {
  const auto body = [](auto&& spoil) {
    return refusal([&](WorldDef& d) { spoil(d.articulations[1].links[0].inertia); });
  };
  expectNamed(body([](auto& i) { i.mass = 0; }), {"cube", "mass"});
  expectNamed(body([](auto& i) { i.mass = -1; }), {"cube", "mass"});
  expectNamed(body([](auto& i) { i.mass = std::nan(""); }), {"cube", "mass"});
  expectNamed(body([](auto& i) { i.I_C(1, 1) = -1e-4; }), {"cube", "inertia"});
}

/// A cube that falls on a floor too stiff for its mass: with velocity Verlet the contact force overflows in one step.
WorldDef runaway() {
  CubeParameters c;
  WorldDef def = cubeOnFloor(c, WorldSettings{});
  def.settings.history_steps = 20;
  def.settings.comparator = comparators::velocityVerlet;
  ArticulationDef falling = cube("bomb", c, Pose(Vector3(1, 0, 0.06)));
  falling.links[0].inertia.mass = 1e-6;
  falling.links[0].inertia.I_C = boxInertia(Vector3::Constant(c.size), 1e-6);
  falling.links[0].collisions[0].material.stiffness = 1e308;
  def.articulations.push_back(falling);
  PointerDef pointer;
  pointer.articulation = 1;
  pointer.link = 0;
  def.pointers.push_back(pointer);
  return def;
}

TEST(WorldFaults, StopsInTheStepThatRunsAwayAndKeepsTheLastOnes) {
  World world(runaway());
  const Pose pressed(Vector3(0, 0, 0.05 - 1e-4));
  double felt = 0;
  int steps = 0;
  for (; world.report().finite && steps < 200; ++steps) {
    felt = world.pointerWrench(0).force.z();
    world.setPointerTarget(0, pressed, Twist{});
    world.step();
  }
  ASSERT_FALSE(world.report().finite);
  EXPECT_EQ(world.linkName(world.report().culprit), "bomb");
  EXPECT_GT(felt, 0.1);  // up to the step before, the hand felt the floor
  EXPECT_EQ(world.pointerWrench(0).force, Vector3::Zero());
  EXPECT_EQ(world.pointerWrench(0).torque, Vector3::Zero());

  const StepHistory& history = world.history();
  ASSERT_EQ(history.size(), 20);
  for (int i = 0; i < 20; ++i) {
    const StepHistory::Record record = history.record(i);
    EXPECT_EQ(record.step, static_cast<std::uint64_t>(steps - 20 + i));
    for (int k = 0; k < 14; ++k) EXPECT_TRUE(std::isfinite(record.q[k]));
    EXPECT_NEAR(record.time, 1e-3 * record.step, 1e-12);
  }
  EXPECT_EQ(history.record(19).wrench[5], felt);
  EXPECT_LT(history.record(19).q[7 + 2], history.record(0).q[7 + 2]);  // the bomb fell

  const std::uint64_t stopped = world.hash();
  world.step();
  EXPECT_EQ(world.hash(), stopped);  // it stays stopped
}

TEST(WorldFaults, HistoryStartsAnewAfterRestore) {
  World world(cubeOnFloor(CubeParameters{}, WorldSettings{}));
  const std::vector<double> start = world.save();
  for (int i = 0; i < 5; ++i) world.step();
  EXPECT_EQ(world.history().size(), 5);
  world.restore(start);
  EXPECT_EQ(world.history().size(), 0);
  world.step();
  EXPECT_EQ(world.history().record(0).step, 1u);
}

}  // namespace world_faults_test
}  // namespace haptic
