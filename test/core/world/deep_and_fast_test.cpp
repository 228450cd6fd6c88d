// Nothing fast passes through anything thin, nothing that starts inside another body is shot out.
#include <gtest/gtest.h>

#include "../../scenes/extremes.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace deep_and_fast_test {

using namespace scenes;

class DeepAndFast : public testing::TestWithParam<Attempts> {
 protected:
  WorldSettings settings(double h) const {
    WorldSettings s;
    s.step = h;
    s.attempts = GetParam();
    return s;
  }
};

INSTANTIATE_TEST_SUITE_P(Methods, DeepAndFast,
                         testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll));

// What a plate of this stiffness can take: ½ m v² = ½ k A (t/2)² needs k A = 4 m v²/t².
TEST_P(DeepAndFast, ABulletIsStoppedByAThinPlate) {
  for (double thickness : {1e-3, 0.02}) {
    const double speed = 100, mass = 0.01, k_eff = 16 * mass * speed * speed / (thickness * thickness);
    for (double h : {1e-3, 1e-2}) {
      CubeParameters c = extreme::cubeOf(0.02, mass, k_eff);
      WorldDef def = cubeOnFloor(c, settings(h));
      def.articulations[0] = floorBox(1, thickness);
      def.articulations[1].X_WA.p.z() = 0.3333;
      def.articulations[1].V_WA.linear.z() = -speed;
      def.settings.default_material.dissipation = 1;
      World world(def);
      double lowest = 1;
      int parts = 0;
      for (int i = 0; i * h < 0.02; ++i) {
        world.step();
        ASSERT_EQ(world.report().flags & (kTooFast | kNotConverged), 0u);
        parts = std::max(parts, world.report().parts);
        lowest = std::min(lowest, world.linkPose(1).p.z());
      }
      EXPECT_GT(lowest, 0) << "thickness " << thickness << ", step " << h;
      if (speed * h > thickness) EXPECT_GT(parts, 1);
    }
  }
}

TEST_P(DeepAndFast, TwoBulletsDoNotPassThroughEachOther) {
  CubeParameters c = extreme::cubeOf(0.01, 0.01, 1e9);
  WorldDef def = cubeOnFloor(c, settings(1e-2));
  def.settings.gravity.setZero();
  def.articulations.clear();
  for (double side : {-1.0, 1.0}) {
    def.articulations.push_back(cube(side < 0 ? "left" : "right", c, Pose(Vector3(side, 1e-4 * side, 0)),
                                     {Vector3::Zero(), Vector3(-100 * side, 0, 0)}));
  }
  World world(def);
  for (int i = 0; i < 5; ++i) {
    world.step();
    const Vector3 way = world.linkPose(1).p - world.linkPose(0).p;
    // What met off its centre turns, and goes on sideways: then it is beside the other one, farther than both their diagonals.
    if (std::abs(way.y()) < c.size * std::sqrt(3.0)) EXPECT_GT(way.x(), 0.5 * c.size);
  }
}

// Speed and step take it through most of the floor's thickness, but not all: it is not the step that is cut, but the way of a pass.
TEST_P(DeepAndFast, ACubeLandsOnAThinPlateInOneStep) {
  if (GetParam() != Attempts::kImplicitEuler && GetParam() != Attempts::kSdirk2) GTEST_SKIP();
  const double thickness = 6e-3, speed = 5, h = 1e-3;
  for (int part = 0; part < 10; ++part) {
    const CubeParameters c = extreme::cubeOf(0.02, 0.1, 1e7);
    WorldDef def = cubeOnFloor(c, settings(h));
    def.articulations[0] = floorBox(1, thickness);
    def.articulations[1].X_WA.p.z() = 0.01 + (1 + 0.1 * part) * speed * h;  // touches within the second step
    def.articulations[1].V_WA.linear.z() = -speed;
    World world(def);
    for (int i = 0; i < 20; ++i) {
      world.step();
      EXPECT_EQ(world.report().parts, 1) << part;
      EXPECT_EQ(world.report().flags & kNotConverged, 0u) << part;
      EXPECT_GT(world.linkPose(1).p.z(), 0.01 - 0.25 * thickness) << part;
    }
  }
}

// Pushed out at the speed of a fall from half its own width, it rises by about as much.
TEST_P(DeepAndFast, AHalfBuriedCubeIsPushedOutWithoutLaunch) {
  for (PressureLaw law : {PressureLaw::kLinear, PressureLaw::kHuntCrossley}) {
    CubeParameters c;  // k_eff = 1e4 N/m: explicit steps of 1 ms hold it
    c.ratio = 0.2;
    WorldDef def = cubeOnFloor(c, settings(1e-3), -0.05);
    def.settings.pressure_law = law;
    World world(def);
    double highest = 0;
    for (int i = 0; i < 3000; ++i) {
      world.step();
      highest = std::max(highest, world.linkPose(1).p.z());
    }
    EXPECT_LE(highest, c.size / 2 + 0.6 * c.size);
    EXPECT_NEAR(world.linkPose(1).p.z(), c.size / 2, 0.05 * c.size);
  }
}

// What its springs held at the start is all that it can give: the books show no gain while it is pushed out, but what the step loses
// where the pressure's law changes over. Booked as turning normals, the gain was nearly all that the springs held.
TEST_P(DeepAndFast, ACubeThatIsPushedOutGainsNothing) {
  for (PressureLaw law : {PressureLaw::kLinear, PressureLaw::kHuntCrossley}) {
    CubeParameters c;
    c.ratio = 0.2;
    WorldDef def = cubeOnFloor(c, settings(1e-3), -0.05);
    def.settings.pressure_law = law;
    World world(def);
    double first = 0, most = 0;
    for (int i = 0; i < 3000; ++i) {
      world.step();
      const EnergyLedger& e = world.report().energy;
      const double books = e.total() + e.damping + e.friction - e.external;
      if (i == 0) first = books;
      most = std::max(most, books - first);
    }
    // ½ k A d² with k A = 1e4 N/m and d = 50 mm, of which the law of recovery has what 1 % of the size would have: 2 %.
    EXPECT_NEAR(first, 0.25, 0.01);
    EXPECT_LT(most, 0.05 * first);
  }
}

/// A plate on a floor so soft that its own weight presses it deeper than what counts as buried by its thickness alone: one that starts
/// at its rest depth, one deeper, both rest there.
TEST(Buried, APlateThatStartsDeepInASoftFloorComesToItsRestDepth) {
  constexpr double kMass = 0.3, kStiffness = 1e6, kArea = 0.01, kHeight = 0.02;
  const double rest = kMass * kGravity / (kStiffness * kArea);
  for (const Attempts attempts : {Attempts::kImplicitEuler, Attempts::kAll}) {
    for (const double start : {1.0, 1 + 1e-9, 1.5, 2.5, 5.0}) {
      WorldDef def;
      def.settings.attempts = attempts;
      ContactMaterial& m = def.settings.default_material;
      m.stiffness = kStiffness;
      m.damping = 2 * std::sqrt(kStiffness * kMass / kArea);
      def.settings.pressure_law = PressureLaw::kLinear;
      def.articulations.push_back(floorBox());
      def.articulations.push_back(freeBox("plate", Vector3(0.1, 0.1, kHeight), kMass, Pose(Vector3(0, 0, kHeight / 2 - start * rest))));
      World world(def);
      for (int i = 0; i < 3000; ++i) world.step();
      const double depth = kHeight / 2 - world.linkPose(1).p.z();
      // Critically damped at 183 rad/s: nothing is left of what it started with.
      EXPECT_NEAR(depth, rest, 1e-9 * rest) << static_cast<int>(attempts) << " " << start;
    }
  }
}

}  // namespace deep_and_fast_test
}  // namespace haptic
