// Bodies on ground of many pieces. Oracles: the plane that the pieces make up, statics, and the general pipeline.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/ground.h"
#include "../../scenes/offsets.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace terrain_test {

using namespace scenes;

std::vector<LedBody> ledBodies() {
  return {{std::make_shared<Ball>(0.05), 0.05 - 1e-3},
          {std::make_shared<Rod>(0.05, 0.02, Rod::Ends::kFlat), 0.01 - 1e-4},
          {box(Vector3::Constant(0.1)), 0.05 - 1e-4}};
}

std::vector<ArticulationDef> halfSpace() {
  return {staticPieces("plane", {std::make_shared<HalfSpace>()})};
}

/// A ball, a puck and a cube that slide over inner edges, level and tilted: the wrench, friction included, is that of one plane, but
/// for roundings of the corners' coordinates, 4e-16 m over a depth of 1e-4 m, some of them for each piece.
TEST(Terrain, InnerEdgesOfAPlaneAreNotFelt) {
  const Matrix3 tilted = rotationAbout(Vector3(1, 0.5, 0).normalized(), 0.2);
  const LedMotion way{Vector3(-0.1, -0.04, 0), Vector3(0.3, 0.12, 0), 0.4};
  const std::vector<ArticulationDef> prisms{staticPieces("field", flatPrisms(10, 1.5))},
      rough{staticPieces("field", groundOf(plateau(20, 2)))};
  for (const auto& ground : {prisms, rough, tiles(10, 1.5)}) {
    for (const LedBody& body : ledBodies()) {
      EXPECT_LT(edgeJump(ground, halfSpace(), body, way, 500), 1e-9) << body.shape->name();
      EXPECT_LT(edgeJump(ground, halfSpace(), body, way, 500, tilted), 1e-9) << body.shape->name();
    }
  }
}

/// A level field of triangles whose corners are off by up to `amplitude`, as those of a file in single precision are.
GroundShapes noisyField(double amplitude) {
  Offsets offsets;
  return groundOf(heightGrid(10, 1.5, [&](double, double) { return amplitude * offsets.next(); }));
}

/// However small the noise is, it never decides whether a body is carried: the wrench is that of the plane, but for the noise's own depth
/// and slope.
TEST(Terrain, NoiseOfAFileIsNotFelt) {
  const LedMotion way{Vector3(-0.1, -0.04, 0), Vector3(0.3, 0.12, 0), 0.4};
  for (const LedBody& body : ledBodies()) {
    const double depth = body.shape->ball() ? 1e-3 : 1e-4;
    for (const double amplitude : {1e-9, 1e-8, 3e-8, 5e-8, 1e-7, 3e-7, 1e-6}) {
      const double jump = edgeJump({staticPieces("field", noisyField(amplitude))}, halfSpace(), body, way, 500);
      EXPECT_LT(jump, 1e-9 + 4 * amplitude / depth) << body.shape->name() << " " << amplitude;
    }
  }
}

/// Tiles with gaps, or laps, that are small beside the depth are one floor.
TEST(Terrain, GapsSmallBesideTheDepthAreNotFelt) {
  const LedMotion way{Vector3(-0.1, -0.04, 0), Vector3(0.3, 0.12, 0), 0.4};
  for (const LedBody& body : ledBodies()) {
    for (const double gap : {-1e-5, -2e-6, -1e-9, 1e-9, 2e-6, 1e-5}) {
      std::vector<ArticulationDef> floor;
      for (int i = 0; i < 100; ++i) {
        const Vector3 middle(0.15 * (i % 10 - 4.5), 0.15 * (i / 10 - 4.5), -0.1);
        floor.push_back(staticBox("tile" + std::to_string(i), Vector3(0.15 - gap, 0.15 - gap, 0.2), Pose(middle)));
      }
      // Each of up to two gaps across the body takes the share gap/width of the load, on either side.
      EXPECT_LT(edgeJump(floor, halfSpace(), body, way, 500), 1e-9 + 8 * std::abs(gap) / 0.02) << body.shape->name() << " " << gap;
    }
  }
}

/// The largest change of the wrench between two steps of a body that is led over a fold.
double largestChange(double speed, double fold, const LedBody& body) {
  const HeightGrid grid = heightGrid(4, 0.8, [&](double x, double) { return fold * std::abs(x); });
  LedBody led = body;
  led.height += fold < 0 ? 0.0 : 5e-3;
  WorldDef def = ledOver({staticPieces("fold", groundOf(grid))}, led);
  def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 0;
  def.settings.default_material.dissipation = 0;
  World world(def);
  const LedMotion way{Vector3(-0.06, 0.013, 0), Vector3(speed, 0, 0), 0.3};
  double most = 0;
  Wrench before;
  for (int k = 0; k * 1e-3 * speed < 0.12; ++k) {
    world.setPointerTarget(0, way.at(k * 1e-3, led.height), way.twist());
    world.step();
    const Wrench now = world.pointerWrench(0), change = now - before;
    if (k > kEntered) most = std::max(most, std::max(change.force.norm(), change.torque.norm() / 0.05));
    before = now;
  }
  return most;
}

/// Over ridge and valley the wrench follows the pose without a jump: at half the speed it changes by half from step to step.
TEST(Terrain, BentEdgesAreFeltWithoutAJump) {
  for (const double fold : {-0.1, 0.1}) {
    for (const LedBody& body : ledBodies()) {
      const double fast = largestChange(0.08, fold, body), slow = largestChange(0.02, fold, body);
      EXPECT_GT(fast, 0) << body.shape->name();
      EXPECT_LT(slow, 0.3 * fast) << body.shape->name() << " " << fold;
    }
  }
}

/// A cube on a slope of prisms, held by friction or sliding down from the start: as on one inclined plane, and as the closed form says.
TEST(Terrain, ASlopeIsAnInclinedPlane) {
  const Vector3 start(0.013, 0.02, 0.05);
  const auto slope = [&](const std::vector<ArticulationDef>& ground, double angle, double mu, double speed) {
    WorldDef def;
    CubeParameters c;
    c.mass = 0.5;
    c.mu_static = c.mu_dynamic = mu;
    def.settings.default_material = c.material();
    def.settings.gravity = Vector3(0, 0, -kGravity);
    def.settings.comparator = comparators::velocityVerlet;
    const Matrix3 R = rotationAbout(Vector3::UnitY(), angle);
    for (ArticulationDef each : ground) {
      each.X_WA = Pose(R, Vector3::Zero()) * each.X_WA;
      def.articulations.push_back(std::move(each));
    }
    const double depth = c.mass * kGravity * elementary::cos(angle) / (c.stiffness * c.area());
    def.articulations.push_back(cube("cube", c, Pose(R, R * (start - Vector3(0, 0, depth))), {Vector3::Zero(), R * Vector3(speed, 0, 0)}));
    World world(def);
    for (int i = 0; i < 500; ++i) world.step();
    return Vector3(R.transpose() * world.linkPose(world.linkIndex("cube")).p);
  };
  const std::vector<ArticulationDef> prisms{staticPieces("field", flatPrisms(10, 1.5))};
  // So flat that no side of the cube lifts while it comes to rest: what touched stays in touch.
  const Vector3 held = slope(prisms, 0.1, 2, 0);
  EXPECT_LT((held - slope(halfSpace(), 0.1, 2, 0)).norm(), 1e-7);  // slip is measured to second order in the tilt
  EXPECT_LT((held - start).head<2>().norm(), 3e-4);  // the springs of friction give way
  const double angle = 0.35, mu = 0.2, t = 0.5, speed = 0.3;
  const Vector3 slid = slope(prisms, angle, mu, speed);
  // Each piece of ground that it comes upon holds it for a part of a step, 1e-4 m of its way, with the share of its weight that is there.
  EXPECT_LT((slid - slope(halfSpace(), angle, mu, speed)).norm(), 1e-5);
  const double a = kGravity * (elementary::sin(angle) - mu * elementary::cos(angle));
  EXPECT_NEAR(slid.x() - start.x(), speed * t + 0.5 * a * t * t, 5e-4);
}

/// A bowl of triangles with a ball of .5 kg and 5 cm in it.
WorldDef bowl(Attempts attempts, const Vector3& start) {
  WorldDef def;
  CubeParameters c;
  c.mass = 0.5;
  def.settings.default_material = c.material();
  def.settings.gravity = Vector3(0, 0, -kGravity);
  def.settings.attempts = attempts;
  def.articulations.push_back(staticPieces("bowl", groundOf(heightGrid(9, 0.9, [](double x, double y) { return x * x + y * y; }))));
  const auto ball = std::make_shared<Ball>(0.05);
  def.articulations.push_back(freeBody("ball", ball, 0.5, ball->massProperties(0.5 / ball->volume()).I_com, Pose(start)));
  return def;
}

/// A body that rolls over triangles is located once a step: the step before says well where it goes. The points that stand in for a patch
/// err by more than a tenth of its force on edges; where a first pass leaves that out, as it does after a jump, each step takes two.
TEST(Terrain, WhatRollsIsLocatedOnceAStep) {
  WorldDef def = bowl(Attempts::kAll, Vector3(0.11, 0.06, 0.0661));
  def.settings.step = 1e-4;
  World world(def);
  int steps = 0, twice = 0;
  for (int i = 0; i < 4000; ++i) {
    world.step();
    if (i < 1000 || world.contactCount() == 0) continue;
    ++steps;
    twice += world.report().evaluations > 1;
  }
  EXPECT_GT(steps, 2000);
  EXPECT_LT(twice, 0.2 * steps);
}

/// A ball that falls on the level cell in a bowl's middle comes to rest there, and its contacts carry its weight.
TEST(Terrain, ABallComesToRestInABowl) {
  for (const Attempts attempts : {Attempts::kAll}) {
    World world(bowl(attempts, Vector3(0.02, -0.01, 0.08)));
    for (int i = 0; i < 8000; ++i) {
      world.step();
      ASSERT_FALSE(world.report().flags & (kPairsDropped | kContactsIncomplete));
    }
    EXPECT_LT(world.linkTwist(1).linear.norm(), 1e-4);
    Vector3 force = Vector3::Zero();
    for (int i = 0; i < world.contactCount(); ++i) force += (world.contact(i).link_b == 1 ? 1 : -1) * world.contact(i).F_BP_W.force;
    EXPECT_NEAR((force - Vector3(0, 0, 0.5 * kGravity)).norm(), 0, 0.01);
  }
}

/// Beside the middle it rolls from side to side over edges and corners of the triangles, and none of them gives it energy.
TEST(Terrain, ABallRollsInABowlAndGainsNothing) {
  for (const Attempts attempts : {Attempts::kAll}) {
    World world(bowl(attempts, Vector3(0.11, 0.06, 0.08)));
    const auto height = [&] {  // energy over m g [m]; I = 2/5 m r²
      const Twist V = world.linkTwist(1);
      return world.linkPose(1).p.z() + (0.5 * V.linear.squaredNorm() + 0.2 * 0.05 * 0.05 * V.angular.squaredNorm()) / kGravity;
    };
    const double start = height();
    double widest = 0;
    for (int i = 0; i < 8000; ++i) {
      world.step();
      ASSERT_LT(height(), start + 1e-9);  // it begins in free fall
      if (i > 4000) widest = std::max(widest, world.linkPose(1).p.head<2>().norm());
    }
    EXPECT_GT(widest, 0.03);  // it still rolls
  }
}

/// Hills of 800 triangles: a step that visits what is near gives the bits of one that visits everything, and again the same.
TEST(Terrain, WhatIsFarCostsNothingAndChangesNoBit) {
  WorldDef def;
  CubeParameters c;
  def.settings.default_material = c.material();
  def.settings.gravity = Vector3(0, 0, -kGravity);
  const HeightGrid grid = heightGrid(20, 3, [](double x, double y) { return 0.1 * elementary::sin(3 * x) * elementary::cos(2 * y); });
  const GroundShapes pieces = groundOf(grid);
  EXPECT_GT(pieces.size(), 700u);
  def.articulations.push_back(staticPieces("hills", pieces));
  for (int i = 0; i < 3; ++i) {
    def.articulations.push_back(cube("cube" + std::to_string(i), c, Pose(Vector3(0.4 * i - 0.5, 0.3 * i, 0.2))));
  }
  WorldDef general = def;
  general.settings.leave_out = false;
  World world(def), everything(general), again(def);
  EXPECT_TRUE(world.model().listed_pairs.empty());
  EXPECT_LT(world.model().pair_capacity, 3 * 400);
  int most = 0;
  for (int i = 0; i < 350; ++i) {
    for (World* each : {&world, &everything, &again}) each->step();
    ASSERT_EQ(world.hash(), everything.hash()) << i;
    ASSERT_EQ(world.hash(), again.hash()) << i;
    ASSERT_FALSE(world.report().flags & kPairsDropped) << i;
    most = std::max(most, world.contactCount());
  }
  EXPECT_GT(most, 3);  // they have come down, over edges
  const std::vector<double> saved = world.save();
  again.restore(saved);
  for (int i = 0; i < 50; ++i) world.step(), again.step();
  EXPECT_EQ(world.hash(), again.hash());
}

}  // namespace terrain_test
}  // namespace haptic
