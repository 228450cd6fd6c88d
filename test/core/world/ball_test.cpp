#include "haptic_core/geometry/shapes/ball.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../../scenes/blocks.h"

namespace haptic {
namespace ball_test {

using scenes::kGravity;

constexpr double kRadius = 0.1, kMass = 1, kFoundation = 1e8;  // [m], [kg], [N/m³]

/// Depth at which a ball carries `force` on a face: k π d² (R - d/3) = F.
double restDepth(double force) {
  double depth = 0;
  for (int i = 0; i < 60; ++i) depth = std::sqrt(force / (kFoundation * M_PI * (kRadius - depth / 3)));
  return depth;
}

/// Distance of the patch from the ball's centre, at V's centroid: where friction pulls.
double arm(double depth) {
  return kRadius - depth * (2 * kRadius / 3 - depth / 4) / (kRadius - depth / 3);
}

/// On a floor that is tilted by `slope` [rad] about y, at rest depth.
WorldDef ballOnFloor(Attempts attempts, double h, double slope, double mu, double speed = 0) {
  WorldDef def;
  def.settings.attempts = attempts;
  def.settings.step = h;
  def.settings.gravity = kGravity * Vector3(std::sin(slope), 0, -std::cos(slope));
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = kFoundation;
  m.dissipation = 0;  // else what presses more in front of the ball brakes it
  m.mu_static = m.mu_dynamic = mu;
  def.articulations.push_back(scenes::floorBox(10));
  const double depth = restDepth(kMass * kGravity * std::cos(slope));
  def.articulations.push_back(scenes::freeBody(
      "ball", std::make_shared<Ball>(kRadius), kMass, 0.4 * kMass * kRadius * kRadius * Matrix3::Identity(),
      Pose(Vector3(0, 0, kRadius - depth)), {Vector3::Zero(), Vector3(speed, 0, 0)}));
  return def;
}

/// Boxes of balls side by side across the axes overlap; the balls are 1.2 cm apart, and 20 µm is what a step may close.
TEST(Ball, OnesApartAreNoPairThoughTheirBoxesOverlap) {
  for (const double gap : {0.012, -1e-4}) {
    WorldDef def;
    def.settings.attempts = Attempts::kImplicitEuler;
    const double side = (2 * kRadius + gap) * M_SQRT1_2;
    for (const double at : {0.0, side}) {
      def.articulations.push_back(scenes::freeBody("ball" + std::to_string(at), std::make_shared<Ball>(kRadius), kMass,
                                                   0.4 * kMass * kRadius * kRadius * Matrix3::Identity(), Pose(Vector3(at, at, 0))));
    }
    World world(def);
    world.step();
    EXPECT_EQ(world.report().pairs, gap > 0 ? 0 : 1) << gap;
  }
}

class Balls : public testing::TestWithParam<Attempts> {};

/// Rolls with a = g sin α/(1 + I/(m r²)), r the arm of the patch, whatever turns it has made: a ball has no
/// corners.
TEST_P(Balls, RollDownASlope) {
  const double slope = 0.1, h = 1e-3;
  World world(ballOnFloor(GetParam(), h, slope, 0.5));
  const double r = arm(restDepth(kMass * kGravity * std::cos(slope)));
  const double exact = kGravity * std::sin(slope) / (1 + 0.4 * kRadius * kRadius / (r * r));
  for (int i = 0; i < 200; ++i) world.step();  // the layer is strained at once, and swings
  const double before = world.linkTwist(1).linear.x();
  double largest = 0, last = before;
  for (int i = 0; i < 500; ++i) {
    world.step();
    const double now = world.linkTwist(1).linear.x();
    if (i > 0) largest = std::max(largest, std::abs((now - last) / h - exact));
    last = now;
  }
  // The first-order step lets the layer follow its turning ball by h ω² a/2 late: 1e-4; the others by its
  // square.
  const double tolerance = GetParam() == Attempts::kImplicitEuler ? 3e-4 : 2e-5;
  EXPECT_NEAR((last - before) / (500 * h), exact, tolerance * exact);
  EXPECT_EQ(world.linkTwist(1).linear.y(), 0);
  EXPECT_EQ(world.linkTwist(1).angular.z(), 0);
}

/// The same to nine digits, where the step itself costs nothing: the way of a patch over a ball is the arc that it rolls, seen from
/// the floor or from the ball. The arc's chord would be a twelfth of the square of a millirad short, 8e-8.
TEST(Ball, RollsByItsArc) {
  for (const bool ball_first : {false, true}) {
    const double slope = 0.1, h = 1e-3;
    WorldDef def = ballOnFloor(Attempts::kAll, h, slope, 0.5);
    if (ball_first) std::swap(def.articulations[0], def.articulations[1]);
    World world(def);
    const int ball = ball_first ? 0 : 1;
    const double r = arm(restDepth(kMass * kGravity * std::cos(slope)));
    const double exact = kGravity * std::sin(slope) / (1 + 0.4 * kRadius * kRadius / (r * r));
    for (int i = 0; i < 200; ++i) world.step();
    const double before = world.linkTwist(ball).linear.x();
    for (int i = 0; i < 500; ++i) world.step();
    EXPECT_NEAR((world.linkTwist(ball).linear.x() - before) / (500 * h), exact, 1e-9 * exact);
  }
}

/// Slides with μ g until the patch stands: v ends at v0 (m r²/I)/(1 + m r²/I).
TEST_P(Balls, SlideUntilTheyRoll) {
  const double v0 = 2, mu = 0.2;
  World world(ballOnFloor(GetParam(), 1e-3, 0, mu, v0));
  for (int i = 0; i < 500; ++i) world.step();
  const double r = arm(restDepth(kMass * kGravity)), share = r * r / (0.4 * kRadius * kRadius);
  EXPECT_NEAR(world.linkTwist(1).linear.x(), v0 * share / (1 + share), 3e-4 * v0);
}

TEST_P(Balls, RestAtTheirDepth) {
  WorldDef def = ballOnFloor(GetParam(), 1e-3, 0, 0.5);
  World world(def);
  for (int i = 0; i < 300; ++i) world.step();
  EXPECT_NEAR(world.linkPose(1).p.z(), kRadius - restDepth(kMass * kGravity), 1e-10);
  EXPECT_NEAR(world.linkTwist(1).linear.norm(), 0, 1e-8);
}

INSTANTIATE_TEST_SUITE_P(ByIntegrator, Balls,
                         testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2,
                                         Attempts::kAll));

/// A ball on two floor tiles that continue one another is on one floor: no bump at the seam.
TEST(Ball, RollsOverASeam) {
  WorldDef def = ballOnFloor(Attempts::kAll, 1e-3, 0, 0.5);
  def.articulations[0] = scenes::staticBox("left", Vector3(2, 2, 0.5), Pose(Vector3(-1, 0, -0.25)));
  def.articulations.push_back(scenes::staticBox("right", Vector3(2, 2, 0.5), Pose(Vector3(1, 0, -0.25))));
  const double r = arm(restDepth(kMass * kGravity));
  def.articulations[1].X_WA.p.x() = -0.05;
  def.articulations[1].V_WA = {Vector3(0, 0.5 / r, 0), Vector3(0.5, 0, 0)};
  World world(def);
  double highest = 0;
  for (int i = 0; i < 200; ++i) {
    world.step();
    highest = std::max(highest, std::abs(world.linkPose(1).p.z() - (kRadius - restDepth(kMass * kGravity))));
  }
  EXPECT_GT(world.linkPose(1).p.x(), 0.04);
  EXPECT_LT(highest, 2e-8);
  EXPECT_NEAR(world.linkTwist(1).linear.x(), 0.5, 1e-5);
}

/// A ball falls into the opening between four bars and hangs on their edges.
TEST(Ball, HangsInAnOpening) {
  WorldDef def = ballOnFloor(Attempts::kSdirk2, 1e-3, 0, 0.3);
  def.settings.default_material.dissipation = 1;
  def.settings.default_material.stiffness = 1e10;
  def.articulations[0] = scenes::staticBox("bar0", Vector3(1, 0.1, 0.1), Pose(Vector3(0, 0.14, -0.3)));
  def.articulations.push_back(scenes::staticBox("bar1", Vector3(1, 0.1, 0.1), Pose(Vector3(0, -0.14, -0.3))));
  def.articulations.push_back(
      scenes::staticBox("bar2", Vector3(0.1, 0.18, 0.1), Pose(Vector3(0.14, 0, -0.3))));
  def.articulations.push_back(
      scenes::staticBox("bar3", Vector3(0.1, 0.18, 0.1), Pose(Vector3(-0.14, 0, -0.3))));
  World world(def);
  for (int i = 0; i < 1500; ++i) world.step();
  // The edges are 0.09 m from the axis: its centre √(R² - 0.09²) over them, less the 0.8 mm that carry it.
  EXPECT_NEAR(world.linkPose(1).p.z(), -0.25 + std::sqrt(kRadius * kRadius - 0.09 * 0.09), 2e-3);
  EXPECT_NEAR(world.linkPose(1).p.head<2>().norm(), 0, 1e-6);
  EXPECT_LT(world.linkTwist(1).linear.norm(), 1e-3);
}

}  // namespace ball_test
}  // namespace haptic
