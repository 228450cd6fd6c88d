// Centre of pressure against the line of the resultant, slip against a known speed, outlines of patches against the reported area.
#include "haptic_core/world/contact_detail.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/blocks.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/world/work.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace contact_detail_test {

/// A cube whose mass lies off its middle stands under gravity that pulls aside: the floor's resultant passes through the centre of mass
/// along gravity, and friction keeps it from turning.
TEST(CentreOfPressure, LiesOnTheLineOfTheLoad) {
  for (const Attempts attempts : {Attempts::kAll, Attempts::kImplicitEuler}) {
    scenes::CubeParameters c;
    WorldSettings settings;
    settings.attempts = attempts;
    settings.gravity = Vector3(1.2, -0.7, -9.8);
    WorldDef def = scenes::cubeOnFloor(c, settings);
    def.articulations[1].links[0].inertia.p_LC = Vector3(-0.015, 0.02, -0.01);
    World world(def);
    for (int i = 0; i < 20000; ++i) world.step();
    ASSERT_EQ(world.contactCount(), 1);
    const ContactReport& contact = world.contact(0);
    ASSERT_TRUE(contact.sticking);
    const Vector3 along = settings.gravity.normalized();
    const Vector3 off = centreOfPressure(contact) - world.linkPose(1) * def.articulations[1].links[0].inertia.p_LC;
    EXPECT_LT((off - along.dot(off) * along).norm(), 1e-9);  // at rest to 1e-8 of the weight, levers of 0.1 m
    // In the plane of the patch.
    EXPECT_NEAR(contact.X_WP.R.col(2).dot(centreOfPressure(contact) - contact.X_WP.p), 0, 1e-16);
  }
}

/// Of a cube that rocks, whose dampers press as well: about Z the wrench turns about the normal alone.
TEST(CentreOfPressure, HasNoMomentAcross) {
  scenes::CubeParameters c;
  WorldDef def = scenes::cubeOnFloor(c, {});
  def.articulations[1].V_WA.angular = Vector3(0.3, -0.2, 0);
  World world(def);
  double farthest = 0;
  for (int i = 0; i < 30; ++i) {
    world.step();
    if (world.contactCount() != 1 || !(world.contact(0).normal_force > 0)) continue;
    const ContactReport& contact = world.contact(0);
    const Vector3 z = centreOfPressure(contact), n = contact.X_WP.R.col(2);
    const Wrench F = contact.F_BP_W.shifted(z - contact.X_WP.p);
    EXPECT_LT((F.torque - n.dot(F.torque) * n).norm(), 1e-15 * F.force.norm()) << i;
    farthest = std::max(farthest, (z - contact.X_WP.p).norm());
  }
  EXPECT_GT(farthest, 1e-5);
}

TEST(Slip, IsTheSpeedAlongTheFloor) {
  scenes::CubeParameters c;
  WorldDef def = scenes::cubeOnFloor(c, {});
  def.articulations[1].V_WA.linear = Vector3(0.8, 0.3, 0);
  World world(def);
  for (int i = 0; i < 20; ++i) {
    world.step();
    ASSERT_EQ(world.contactCount(), 1);
    const ContactReport& contact = world.contact(0);
    EXPECT_FALSE(contact.sticking);
    const Vector3 slip = slipOf(world.model(), contact, world.work().placement.link.data());
    // B is the cube: against the friction on it, and as fast as the cube at the floor.
    const Twist V = world.linkTwist(1);
    const Vector3 v = V.shifted(centreOfPressure(contact) - world.linkPose(1).p).linear;
    const Vector3 n = contact.X_WP.R.col(2);
    EXPECT_LT((slip - (v - n.dot(v) * n)).norm(), 1e-15);
    EXPECT_GT(slip.head<2>().normalized().dot(Vector2(0.8, 0.3).normalized()), 0.999);
    EXPECT_LT(slip.dot(contact.F_BP_W.force), 0);
  }
}

/// A cube rides a belt without a slip, and slips at the belt's speed while it is held.
TEST(Slip, IsToldOfBelts) {
  WorldDef def = scenes::cubeOnFloor({}, {});
  def.articulations[0].links[0].collisions[0].belt.V_L.linear = Vector3(0.1, 0, 0);
  World world(def);
  for (int i = 0; i < 1000; ++i) world.step();
  const auto slip = [&] { return slipOf(world.model(), world.contact(0), world.work().placement.link.data()); };
  ASSERT_EQ(world.contactCount(), 1);
  EXPECT_NEAR(world.linkTwist(1).linear.x(), 0.1, 1e-6);
  EXPECT_LT(slip().norm(), 1e-6);
  world.setBodyPose(1, world.linkPose(1), {});
  world.step();
  ASSERT_EQ(world.contactCount(), 1);
  const Vector3 lever = centreOfPressure(world.contact(0)) - world.linkPose(1).p;
  EXPECT_LT((slip() - (world.linkTwist(1).shifted(lever).linear - Vector3(0.1, 0, 0))).head<2>().norm(), 1e-12);
  EXPECT_LT(slip().x(), -0.05);
}

double areaOf(const std::vector<Vector3>& corners, const Vector3& n) {
  double area = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) area += 0.5 * n.dot(corners[i].cross(corners[(i + 1) % corners.size()]));
  return area;
}

/// Polygons have the reported area, also on a half-space and of round shapes.
TEST(PatchOutline, HasTheAreaOfTheReport) {
  scenes::CubeParameters c;
  for (const bool half_space : {false, true}) {
    for (const bool ball : {false, true}) {
      WorldSettings settings;
      settings.comparator = comparators::velocityVerlet;  // which reports contacts at the poses that it ends with
      WorldDef def = scenes::cubeOnFloor(c, settings);
      if (half_space) def.articulations[0].links[0].collisions[0].shape = std::make_shared<HalfSpace>();
      if (half_space) def.articulations[0].X_WA = Pose();
      if (ball) def.articulations[1].links[0].collisions[0].shape = std::make_shared<Ball>(0.05);
      def.articulations[1].X_WA.R = rotationAbout(Vector3(1, 2, 0).normalized(), 0.3);
      def.articulations[1].V_WA.angular = Vector3(0.5, 1, 3);
      World world(def);
      PatchOutline outline(world.model());
      int seen = 0;
      for (int i = 0; i < 300; ++i) {
        world.step();
        for (int k = 0; k < world.contactCount(); ++k) {
          const ContactReport& contact = world.contact(k);
          if (contact.area == 0 || contact.event < 1) continue;  // it parted within the step
          const auto& corners = outline.of(contact, world.linkPose(contact.link_a), world.linkPose(contact.link_b));
          ++seen;
          EXPECT_NEAR(areaOf(corners, contact.X_WP.R.col(2)), contact.area, 1e-9 * contact.area + 1e-18) << half_space << ball << i;
          EXPECT_EQ(corners.size() == PatchOutline::kRoundCorners, ball);
        }
      }
      EXPECT_GT(seen, 20);
    }
  }
}

}  // namespace contact_detail_test
}  // namespace haptic
