/// The reference scenes, each against what is known of it exactly. Their twins are in urdf/scenes.
#include <gtest/gtest.h>

#include "../../scenes/motions.h"
#include "../../comparators/velocity_verlet.h"
#include "../dynamics/free_rotation_reference.h"

namespace haptic {
namespace scenes_test {

using namespace scenes;

WorldSettings verlet(double h = 1e-3) {
  WorldSettings s;
  s.step = h;
  s.comparator = comparators::velocityVerlet;
  return s;
}

TEST(Scenes, EccentricBoxTiltsByTheLinearPressure) {
  CubeParameters c;
  const double e = 0.01;  // of the centre of mass
  WorldDef def = cubeOnFloor(c, verlet());
  def.articulations[1].links[0].inertia.p_LC = Vector3(e, 0, 0);
  World world(def);
  for (int i = 0; i < 4000; ++i) world.step();
  // k I θ = m g (e + θ s/2): the tilt moves the centre of mass, half an edge up, aside.
  const double weight = c.mass * kGravity, I = std::pow(c.size, 4) / 12;
  const double expected = weight * e / (c.stiffness * I - weight * c.size / 2);
  const Matrix3 R = world.linkPose(1).R;
  EXPECT_NEAR(std::atan2(-R(2, 0), R(0, 0)), expected, 1e-5 * expected);  // terms in θ² left out: 1.4e-6
  EXPECT_NEAR(world.contact(0).normal_force, weight, 1e-9 * weight);
  // The pressure's centre stands under the centre of mass.
  EXPECT_NEAR(world.contact(0).X_WP.p.x(), (world.linkPose(1) * Vector3(e, 0, 0)).x(), 1e-8);
}

TEST(Scenes, TorqueFreeBodyFlipsLikeTheReference) {
  World world(tumblingBody(verlet()));
  for (int i = 0; i < 10000; ++i) world.step();
  const Quaternion exact = test::freeRotation(Vector3(1, 2, 2.5), Vector3(0.01, 5, 0.01), 10);
  EXPECT_LT(vectorFromRotation(Quaternion(world.linkPose(0).R) * exact.conjugate()).norm(), 1e-8);
  const double energy = 0.5 * (1e-4 + 2 * 25 + 2.5e-4);
  EXPECT_NEAR(world.report().energy.kinetic, energy, 1e-11 * energy);
}

TEST(Scenes, SlopeHoldsUpToItsStaticFriction) {
  CubeParameters c;
  c.mu_dynamic = 0.35;
  World world(Slope::scene(c, verlet()));
  double slid_at = 1;
  for (double tangent = 0.2; tangent < 0.6 && slid_at == 1; tangent += 1e-4) {
    Slope::step(world, c, tangent, tangent < 0.2 + 1e-3 ? 0 : 0.1);
    const Vector3 arm = world.linkPose(1).p - world.linkPose(0).p;
    const Vector3 slip = world.linkTwist(1).linear - world.linkTwist(0).shifted(arm).linear;
    if (tangent > 0.3 && slip.norm() > 1e-3) slid_at = tangent;
  }
  EXPECT_NEAR(slid_at, 0.5, 0.002);
}

/// A thin plate that slides and spins stops both at once. Reference: planar motion under uniform pressure,
/// friction summed over a grid. Friction acts half the plate's height below its centre of mass and shifts the
/// pressure by μ/2 of that height, 0.5 % of the plate's reach.
TEST(Scenes, SpinningBoxThatSlidesFollowsThePlanarMotion) {
  const double size = 0.1, height = 1e-3, mass = 0.1, mu = 0.5;
  WorldDef def;
  def.settings = verlet();
  def.settings.default_material = CubeParameters{}.material();
  def.articulations.push_back(floorBox());
  Twist V;
  V.linear.x() = 0.4;
  V.angular.z() = 9;
  const double rest = mass * kGravity / (1e6 * size * size);
  def.articulations.push_back(
      freeBox("plate", Vector3(size, size, height), mass, Pose(Vector3(0, 0, height / 2 - rest)), V));
  World world(def);
  const int cells = 24;
  const double inertia = mass * size * size / 6, h = 1e-5;
  Vector2 v(0.4, 0);
  double w = 9, angle = 0;
  const auto advance = [&] {  // 1 ms
    for (int i = 0; i < 100; ++i) {
      Vector2 force = Vector2::Zero();
      double torque = 0;
      for (int x = 0; x < cells; ++x)
        for (int y = 0; y < cells; ++y) {
          const Vector2 r = Eigen::Rotation2Dd(angle) *
                            Vector2(size * ((x + 0.5) / cells - 0.5), size * ((y + 0.5) / cells - 0.5));
          const Vector2 f = -(v + w * Vector2(-r.y(), r.x())).normalized();
          force += f;
          torque += r.x() * f.y() - r.y() * f.x();
        }
      const double scale = mu * mass * kGravity / (cells * cells);
      v += h * scale / mass * force;
      w += h * scale / inertia * torque;
      angle += h * w;
    }
  };
  for (int i = 0; i < 60; ++i) {
    world.step();
    advance();
  }
  // After 60 ms about half of both is left.
  EXPECT_NEAR((world.linkTwist(1).linear.head<2>() - v).norm(), 0, 0.01 * 0.4);
  EXPECT_NEAR(world.linkTwist(1).angular.z(), w, 0.01 * 9);
  double stopped_sliding = 0, stopped_spinning = 0;
  for (int i = 60; i < 400; ++i) {
    world.step();
    if (world.linkTwist(1).linear.norm() > 0.02 * 0.4) stopped_sliding = world.time();
    if (std::abs(world.linkTwist(1).angular.z()) > 0.02 * 9) stopped_spinning = world.time();
  }
  EXPECT_GT(stopped_sliding, 0.08);
  EXPECT_LT(stopped_sliding, 0.35);
  EXPECT_NEAR(stopped_sliding, stopped_spinning, 0.05 * stopped_sliding);
}

TEST(Scenes, FifteenStackedCubesStandAtTheirDepths) {
  CubeParameters c;
  c.stiffness = 1e7;
  c.ratio = c.tangential_ratio = 0.1;
  WorldSettings settings = verlet(0.25e-3);
  settings.pressure_law = PressureLaw::kLinear;
  World world(stack(15, c, settings));
  for (int i = 0; i < 2000; ++i) world.step();
  ASSERT_EQ(world.contactCount(), 15);
  for (int i = 0; i < 15; ++i) {
    const ContactReport& contact = world.contact(i);
    const double expected = (15 - std::min(contact.link_a, contact.link_b)) * c.restDepth();
    EXPECT_NEAR(contact.volume / contact.area, expected, 1e-6 * expected);
  }
}

/// A cube slides over the joint of two floor boxes: the force changes from step to step by the weight times depth over
/// length, twice at most.
TEST(Scenes, SeamIsNotFelt) {
  CubeParameters c;
  WorldDef def = cubeOnFloor(c, verlet());
  def.articulations[0] = staticBox("left", Vector3(2, 4, 0.5), Pose(Vector3(-1, 0, -0.25)));
  def.articulations.push_back(staticBox("right", Vector3(2, 4, 0.5), Pose(Vector3(1, 0, -0.25))));
  def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 0;
  def.articulations[1].X_WA.p.x() = -0.1 + 1e-5;
  def.articulations[1].V_WA.linear.x() = 0.1;
  World world(def);
  Vector3 last(0, 0, c.mass * kGravity);
  double largest = 0;
  int together = 0;
  for (int i = 0; i < 2000; ++i) {
    world.step();
    Vector3 sum = Vector3::Zero();
    for (int j = 0; j < world.contactCount(); ++j) {
      const ContactReport& contact = world.contact(j);
      sum += contact.link_b == 1 ? contact.F_BP_W.force : Vector3(-contact.F_BP_W.force);
    }
    together += world.contactCount() == 2;
    largest = std::max(largest, (sum - last).norm());
    last = sum;
  }
  EXPECT_GT(together, 900);
  const double unit = c.mass * kGravity * c.restDepth() / c.size;  // weight × depth over length
  EXPECT_LT(largest, 2 * unit);  // what a contact of one floor box alone would jump by is seven and more
  EXPECT_NEAR(world.linkTwist(1).linear.x(), 0.1, 1e-9);
}

/// A tumbler rocks with the period of a ball that rolls, its mass low: T = 2π sqrt((I + m (R - h)²)/(m g h)).
TEST(Scenes, TumblerRocksWithItsPeriod) {
  const double radius = 0.05, low = 0.02, mass = 0.2, inertia = 1.5e-4;
  WorldDef def;
  def.settings = verlet();
  def.settings.default_material.stiffness = 1e8;
  def.settings.default_material.dissipation = 1;
  def.articulations.push_back(floorBox());
  const auto ball = std::make_shared<ConvexPolyhedron>(makeSphere(radius, 4, RoundFit::kEqualVolume));
  const double tilt = 0.15, sink = std::sqrt(mass * kGravity / (1e8 * M_PI * radius));
  def.articulations.push_back(freeBody("tumbler", ball, mass, inertia * Matrix3::Identity(),
                                       Pose(rotationY(tilt), Vector3(0, 0, radius - sink))));
  def.articulations[1].links[0].inertia.p_LC = Vector3(0, 0, -low);
  World world(def);
  std::vector<double> crossings;
  double before = tilt;
  for (int i = 0; i < 2000; ++i) {
    world.step();
    const double now = std::atan2(world.linkPose(1).R(0, 2), world.linkPose(1).R(2, 2));
    if ((now > 0) != (before > 0)) crossings.push_back(world.time());
    before = now;
  }
  ASSERT_GE(crossings.size(), 5u);
  const double expected =
      2 * M_PI * std::sqrt((inertia + mass * std::pow(radius - low, 2)) / (mass * kGravity * low));
  // Amplitude of 0.15 rad: 0.2 %; facets of 3 mm under a patch of 6 mm: some per cent of the restoring
  // torque.
  EXPECT_NEAR((crossings[4] - crossings[0]) / 2, expected, 0.03 * expected);
}

}  // namespace scenes_test
}  // namespace haptic
