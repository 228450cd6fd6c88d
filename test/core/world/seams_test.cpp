// Where pieces of a body meet: inner corners, flush seams, steps. Oracles: statics, and the undivided body.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>

#include "../../scenes/inner_corner.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace seams_test {

using namespace scenes;

constexpr double kMass = 0.5;  // [kg]

enum class Bodies { kTwo, kOne };

WorldDef corner(const Matrix3& R, Attempts attempts, double k, double mu, Bodies bodies, bool cube_first) {
  CornerParameters p;
  p.R = R;
  p.mass = kMass;
  p.stiffness = k;
  p.mu = mu;
  p.one_body = bodies == Bodies::kOne;
  p.cube_first = cube_first;
  WorldSettings settings;
  settings.attempts = attempts;
  settings.step = std::min(1e-3, 0.3 * std::sqrt(kMass / (k * 0.01)));
  return innerCorner(p, settings);
}

double staticsError(const World& world, const Matrix3& R) {
  CornerParameters p;
  p.R = R;
  p.mass = kMass;
  return cornerForceError(world, p);
}

void expectStatics(const Matrix3& R, Attempts attempts, double k, Bodies bodies, bool cube_first) {
  World world(corner(R, attempts, k, 0, bodies, cube_first));
  for (double t = 0; t < 0.25; t += world.settings().step) world.step();
  double error = 0, speed = 0;
  for (int i = 0; i < 20; ++i) {
    world.step();
    error = std::max(error, staticsError(world, R));
    speed = std::max(speed, world.linkTwist(world.linkIndex("cube")).linear.norm());
  }
  // What the start's motion has left after some thirty of its time constants, and rounding of the depth.
  EXPECT_LT(error, 1e-6 * kMass * 9.8) << static_cast<int>(attempts) << " " << k << " " << cube_first;
  EXPECT_LT(speed, 1e-6);
}

TEST(Seams, ACubeInAnInnerCornerFeelsFloorAndWall) {
  for (const Matrix3& R : quarterTurns()) {
    expectStatics(R, Attempts::kAll, 1e6, Bodies::kTwo, false);
    expectStatics(R, Attempts::kAll, 1e6, Bodies::kOne, true);
  }
}

TEST(Seams, InnerCornersHoldForAllIntegratorsAndStiffnesses) {
  for (double k : {1e6, 1e8}) {
    for (const Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2, Attempts::kAll}) {
      expectStatics(Matrix3::Identity(), attempts, k, Bodies::kTwo, false);
      expectStatics(Matrix3::Identity(), attempts, k, Bodies::kOne, true);
    }
  }
}

/// A wall that stands on a floor's rim: its outer side and the floor's are one surface, its inner side meets the floor
/// in a corner all the same.
TEST(Seams, AFlushOuterSideDoesNotJoinAnInnerCorner) {
  WorldDef def = corner(Matrix3::Identity(), Attempts::kAll, 1e6, 0, Bodies::kTwo, false);
  def.articulations[0] = staticBox("floor", Vector3(0.6, 1, 0.1), Pose(Vector3(-0.1, 0, -0.05)));
  World world(def);
  for (int i = 0; i < 400; ++i) world.step();
  EXPECT_LT(staticsError(world, Matrix3::Identity()), 1e-6 * kMass * 9.8);
}

/// A cube on the lower tread of a high step, its side against the riser: two boxes of different heights that share the lower
/// part of a side, so that one face is covered in part and surface in part.
TEST(Seams, AStepsRiserPushesAlongItsOwnNormal) {
  WorldDef def = corner(Matrix3::Identity(), Attempts::kAll, 1e6, 0, Bodies::kTwo, false);
  def.articulations[1] = staticBox("upper", Vector3(0.3, 1, 0.3), Pose(Vector3(0.25, 0, 0.05)));
  def.articulations[0] = staticBox("lower", Vector3(0.6, 1, 0.1), Pose(Vector3(-0.2, 0, -0.05)));
  World world(def);
  for (int i = 0; i < 5; ++i) world.step();
  const int cube_link = world.linkIndex("cube");
  for (int i = 0; i < world.contactCount(); ++i) {
    const ContactReport& c = world.contact(i);
    const int other = c.link_a == cube_link ? c.link_b : c.link_a;
    const Vector3 n = c.X_WP.R.col(2);
    const int axis = world.linkName(other) == "upper" ? 0 : 2;
    EXPECT_NEAR(std::abs(n[axis]), 1, 1e-12) << world.linkName(other);
  }
  EXPECT_EQ(world.contactCount(), 2);
}

/// Twelve cubes slide over one seam: more volumes on it than are kept (seams.cpp). Each moves as the first does.
TEST(Seams, ManyBodiesOnASeamMoveAsOneDoes) {
  WorldDef def;
  def.settings.attempts = Attempts::kAll;
  CubeParameters c;
  c.mass = kMass;
  c.mu_static = c.mu_dynamic = 0.2;
  def.settings.default_material = c.material();
  def.articulations.push_back(staticBox("before", Vector3(1, 16, 0.1), Pose(Vector3(-0.5, 0, -0.05))));
  def.articulations.push_back(staticBox("after", Vector3(1, 16, 0.1), Pose(Vector3(0.5, 0, -0.05))));
  constexpr int kCubes = 12;
  const auto place = [](int i) { return 0.5 * (i - kCubes / 2); };  // along the seam [m]
  for (int i = 0; i < kCubes; ++i) {
    def.articulations.push_back(cube("cube" + std::to_string(i), c, Pose(Vector3(-0.1, place(i), 0.05)),
                                     Twist{Vector3::Zero(), Vector3(0.9, 0, 0)}));
  }
  World world(def);
  for (int n = 0; n < 500; ++n) {
    world.step();
    ASSERT_FALSE(world.report().flags & kContactsIncomplete);
    const Pose first = world.linkPose(world.linkIndex("cube0"));
    for (int i = 1; i < kCubes; ++i) {
      const Pose each = world.linkPose(world.linkIndex("cube" + std::to_string(i)));
      // Places along the seam are rounded to 4e-16 m; friction over 500 steps does not magnify that.
      ASSERT_LT((each.p - first.p - Vector3(0, place(i) - place(0), 0)).norm(), 1e-12) << i << " " << n;
      ASSERT_LT((each.R - first.R).norm(), 1e-11) << i << " " << n;
    }
  }
  EXPECT_GT(world.linkPose(world.linkIndex("cube0")).p.x(), 0.05);  // it has crossed
}

/// Of a contact in two parts each says that pieces meet there, also where the body has moved since the parts were found.
TEST(Seams, PartsOfOneContactSayThatTheyLieOnASeam) {
  WorldDef def;
  CubeParameters c;
  c.mass = kMass;
  def.settings.default_material = c.material();
  def.articulations.push_back(staticBox("before", Vector3(1, 1, 0.1), Pose(Vector3(-0.5, 0, -0.05))));
  def.articulations.push_back(staticBox("after", Vector3(1, 1, 0.1), Pose(Vector3(0.5, 0, -0.05))));
  def.articulations.push_back(cube("cube", c, Pose(Vector3(-0.06, 0, 0.05)), Twist{Vector3::Zero(), Vector3(0.9, 0, 0)}));
  int parts = 0;
  World world(def);
  for (int n = 0; n < 60; ++n) {
    world.step();
    if (world.contactCount() != 2) continue;
    for (int i = 0; i < 2; ++i, ++parts) ASSERT_TRUE(world.contact(i).flags & ContactVolume::kOnSeam) << n;
  }
  EXPECT_GT(parts, 40);
}

/// A roller with backspin that comes to a stop on a seam of two tiles stands there as on an undivided floor. The parts of its patch lie at
/// different depths; if each had its friction there, what braked it would stay in them as a couple of opposite forces, and make it creep
/// for half a minute.
TEST(Seams, WhatRollsOntoOneStands) {
  const Matrix3 lying = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitX()).toRotationMatrix(),
                oblique = Eigen::AngleAxisd(0.3, Vector3::UnitZ()) * lying;
  const std::shared_ptr<const ConvexShape> ball = std::make_shared<Ball>(0.05),
                                           rod = std::make_shared<Rod>(0.05, 0.3, Rod::Ends::kFlat);
  // Friction takes m v and I ω in the same time: both end together, after v²/(2 μ g).
  constexpr double kSpeed = 0.05;
  const auto rolled = [=](const std::shared_ptr<const ConvexShape>& shape, const Matrix3& R, Attempts attempts, int tiles) {
    WorldDef def;
    def.settings.attempts = attempts;
    CubeParameters c;
    c.mass = kMass;
    def.settings.default_material = c.material();
    for (int i = 0; i < tiles; ++i) {
      def.articulations.push_back(staticBox("tile" + std::to_string(i), Vector3(2.0 / tiles, 2, 0.1),
                                            Pose(Vector3((2 * i + 1.0) / tiles - 1, 0, -0.05))));
    }
    const Matrix3 I_com = shape->massProperties(kMass / shape->volume()).I_com;
    const double backspin = kSpeed * kMass * 0.05 / I_com(2, 2), way = kSpeed * kSpeed / (2 * c.mu_dynamic * kGravity);
    const Vector3 across = R * Vector3::UnitZ();  // a rod's axis
    const Vector3 ahead = shape->rounding() > 0 ? Vector3::UnitX() : Vector3(Vector3::UnitZ().cross(across));
    def.articulations.push_back(freeBody("roller", shape, kMass, I_com, Pose(R, Vector3(0, 0, 0.05) - way * ahead),
                                         Twist{-backspin * Vector3::UnitZ().cross(ahead), kSpeed * ahead}));
    World world(def);
    for (int n = 0; n < 6000; ++n) world.step();
    EXPECT_EQ(world.contactCount(), tiles);  // of two: it has stopped over the seam
    return world.linkTwist(world.linkIndex("roller")).linear.norm();
  };
  for (const Attempts attempts : {Attempts::kAll}) {
    for (const auto& [shape, R] : {std::pair(ball, Matrix3(Matrix3::Identity())), std::pair(rod, lying), std::pair(rod, oblique)}) {
      const double two = rolled(shape, R, attempts, 2), one = rolled(shape, R, attempts, 1);
      EXPECT_LT(two, 3 * one + 1e-12) << static_cast<int>(attempts);
    }
  }
}

}  // namespace seams_test
}  // namespace haptic
