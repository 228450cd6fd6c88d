#include "haptic_core/geometry/shapes/half_space.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../../scenes/balls.h"
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/rod.h"

namespace haptic {
namespace half_space_test {

using scenes::kGravity;

constexpr double kFoundation = 1e7, kMass = 1;  // [N/m³], [kg]

WorldDef onGround(Attempts attempts, const std::shared_ptr<const ConvexShape>& shape, const Pose& X, double mu = 0.5,
                  const Pose& X_ground = Pose()) {
  WorldDef def;
  def.settings.attempts = attempts;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = kFoundation;
  m.dissipation = 10;
  m.mu_static = m.mu_dynamic = mu;
  def.articulations.push_back(scenes::groundPlane(X_ground));
  const MassProperties p = shape->massProperties(kMass / shape->volume());
  def.articulations.push_back(scenes::freeBody("body", shape, kMass, p.I_com, X));
  return def;
}

class OnHalfSpace : public testing::TestWithParam<Attempts> {};

/// k A d = m g, d small; a hundred kilometres from its frame as beside it.
TEST_P(OnHalfSpace, FlatSidesRestAtTheirDepth) {
  const double R = 0.1, length = 0.3;
  const Vector3 size(0.1, 0.2, 0.3);
  const struct {
    std::shared_ptr<const ConvexShape> shape;
    double area, height;
  } bodies[] = {{scenes::box(size), size.x() * size.y(), 0.5 * size.z()},
                {std::make_shared<Rod>(R, length, Rod::Ends::kFlat), M_PI * R * R, 0.5 * length}};
  for (const auto& body : bodies) {
    for (const double x : {0.0, 1e5}) {
      const double depth = kMass * kGravity / (kFoundation * body.area);
      World world(onGround(GetParam(), body.shape, Pose(Vector3(x, 0, body.height - depth))));
      for (int i = 0; i < 500; ++i) world.step();
      EXPECT_NEAR(world.linkPose(1).p.z(), body.height - depth, 1e-3 * depth);
      EXPECT_NEAR(world.linkPose(1).p.x(), x, 1e-9 + 1e-14 * x);
      EXPECT_NEAR((world.linkPose(1).R - Matrix3::Identity()).norm(), 0, 1e-6);
      EXPECT_EQ(world.report().flags & kNotConverged, 0u);
    }
  }
}

/// Below tan = μ it stays, above it slides with g (sin - μ cos).
TEST_P(OnHalfSpace, BoxesStickToASlopeAndSlideDownIt) {
  const Vector3 size(0.2, 0.2, 0.1);
  const double angle = 0.3, depth = kMass * kGravity * std::cos(angle) / (kFoundation * 0.04);
  const Matrix3 R = Eigen::AngleAxisd(angle, Vector3::UnitY()).toRotationMatrix();
  for (const double mu : {0.4, 0.2}) {
    World world(onGround(GetParam(), scenes::box(size), Pose(R, R * Vector3(0, 0, 0.05 - depth)), mu, Pose(R, Vector3::Zero())));
    for (int i = 0; i < 400; ++i) world.step();
    const double along = world.linkTwist(1).linear.dot(R.col(0));
    const double exact = mu > std::tan(angle) ? 0 : 0.4 * kGravity * (std::sin(angle) - mu * std::cos(angle));
    EXPECT_NEAR(along, exact, 1e-3) << mu;  // the friction springs' way before they slip, and a step
  }
}

/// There is no far side to leave by, and no way so deep that another one is shorter.
TEST_P(OnHalfSpace, WhatIsBuriedComesUp) {
  for (const bool ball : {true, false}) {
    const std::shared_ptr<const ConvexShape> shape =
        ball ? std::shared_ptr<const ConvexShape>(std::make_shared<Ball>(0.1)) : scenes::box(Vector3::Constant(0.2));
    World world(onGround(GetParam(), shape, Pose(Vector3(0, 0, -0.3))));
    for (int i = 0; i < 8000 && world.linkPose(1).p.z() < 0.09; ++i) {
      world.step();
      ASSERT_GT(world.linkPose(1).p.z(), -0.301);
    }
    EXPECT_GT(world.linkPose(1).p.z(), 0.09);
    EXPECT_NEAR(world.linkPose(1).p.head<2>().norm(), 0, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(All, OnHalfSpace,
                         testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2,
                                         Attempts::kAll));

TEST(HalfSpaceWorld, BelongsOnLinksThatDoNotMove) {
  WorldDef def;
  def.articulations.push_back(scenes::freeBody("sky", std::make_shared<HalfSpace>(), 1, Matrix3::Identity(), Pose()));
  try {
    World world(def);
    FAIL();
  } catch (const SetupError& error) {
    EXPECT_NE(std::string(error.what()).find("sky"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("half-space"), std::string::npos);
  }
}

/// The sweep over the boxes finds the same pairs as a list of all.
TEST(HalfSpaceWorld, CarriesManyBodies) {
  scenes::BallGrid grid;
  grid.side = 4;
  grid.layers = 1;
  grid.stiffness = 1e7;
  WorldSettings settings;
  World world(grid.make(settings, std::make_shared<Ball>(scenes::kBallRadius)));
  for (int i = 0; i < 500; ++i) world.step();
  // k π d² (R - d/3) = m g.
  const double depth = scenes::ballRestDepth(10, 1e7);
  for (int i = 0; i < grid.count(); ++i) {
    EXPECT_NEAR(world.linkPose(1 + i).p.z(), scenes::kBallRadius - depth, 0.1 * depth) << i;
  }
}

}  // namespace half_space_test
}  // namespace haptic
