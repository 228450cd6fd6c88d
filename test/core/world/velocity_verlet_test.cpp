// Velocity Verlet with located events against exact rigid motion and its own order.
#include <gtest/gtest.h>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/motions.h"
#include "haptic_core/base/error.h"

namespace haptic {
namespace velocity_verlet_test {

using namespace scenes;

WorldSettings verlet(double h) {
  WorldSettings s;
  s.step = h;
  s.comparator = comparators::velocityVerlet;
  return s;
}

// The block's elastic layer (5e-6 m of play a cycle) shifts each period by 3e-5 s, so 20 cycles by 0.6 ms at 0.085 m/s.
TEST(VelocityVerlet, StickSlipFollowsTheExactMotion) {
  CubeParameters c;
  c.mass = StickSlip::kMass;
  c.stiffness = StickSlip::kStiffness;
  World world(StickSlip::scene(verlet(1e-3)));
  double squares = 0;
  for (int i = 0; i < 10000; ++i) {
    StickSlip::step(world, c.size / 2 - c.restDepth());
    squares += std::pow(world.linkPose(1).p.x() - StickSlip::position(world.time()), 2);
  }
  EXPECT_LE(std::sqrt(squares / 10000), 5e-5);
}

double tiltAt(double h, double end) {
  World world(tiltedCube(verlet(h)));
  for (long i = 0; i < std::lround(end / h); ++i) world.step();
  return tiltOf(world.linkPose(1));
}

TEST(VelocityVerlet, TiltedCubeConvergesToSecondOrder) {
  const double reference = tiltAt(1.0 / 64000, 0.2);
  const double coarse = std::abs(tiltAt(1.0 / 1000, 0.2) - reference);
  const double fine = std::abs(tiltAt(1.0 / 4000, 0.2) - reference);
  EXPECT_GE(std::log(coarse / fine) / std::log(4), 1.8);
}

TEST(VelocityVerlet, NothingCreepsBelowTheLimit) {
  CubeParameters c;
  WorldDef def = cubeOnFloor(c, verlet(1e-3));
  const double angle = std::atan(0.9 * c.mu_static);
  def.settings.gravity = kGravity * Vector3(std::sin(angle), 0, -std::cos(angle));
  World world(def);
  for (int i = 0; i < 1000; ++i) world.step();
  const Vector3 start = world.linkPose(1).p;
  for (int i = 0; i < 5000; ++i) world.step();
  EXPECT_LE((world.linkPose(1).p - start).norm(), 5e-9);  // 1 nm/s
}

TEST(VelocityVerlet, RefusesSettingsByNameAndValue) {
  CubeParameters c;
  for (double step : {0.0, 1.0, -1e-3, std::nan("")}) EXPECT_THROW(World(cubeOnFloor(c, verlet(step))), SetupError);
  for (double k : {-1.0, 0.0}) {
    c = {};
    WorldDef def = cubeOnFloor(c, verlet(1e-3));
    def.settings.default_material.stiffness = k;
    EXPECT_THROW(World{def}, SetupError);
  }
  WorldDef def = cubeOnFloor(CubeParameters{}, verlet(1e-3));
  def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 11;
  EXPECT_THROW(World{def}, SetupError);
  def.settings.default_material.mu_static = 0.2;
  def.settings.default_material.mu_dynamic = 0.3;
  try {
    World world(def);
    FAIL() << "mu_dynamic above mu_static was accepted";
  } catch (const SetupError& e) {
    EXPECT_NE(std::string(e.what()).find("mu_dynamic"), std::string::npos) << e.what();
  }
}

}  // namespace velocity_verlet_test
}  // namespace haptic
