#include "haptic_core/geometry/shapes/ellipsoid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "../../scenes/blocks.h"
#include "../../scenes/spinning_ellipsoid.h"
#include "haptic_core/geometry/shapes/cone.h"

namespace haptic {
namespace ellipsoid_test {

using scenes::kGravity;

/// Its energy is that of the exact motion of the elastic model, all of which is kept: half the step, and what velocity Verlet is off
/// falls by four.
TEST(Ellipsoids, SpinOnAFloorAndKeepTheirEnergy) {
  const double coarse = scenes::SpinningEllipsoid().energyError(2e-4, 0.5), fine = scenes::SpinningEllipsoid().energyError(1e-4, 0.5);
  EXPECT_LT(fine, 1e-6);
  EXPECT_GT(coarse / fine, 3);
}

/// k V = m g, with V of the cap π abc t² (1 - t/3), on each of its axes.
TEST(Ellipsoids, LieAtTheirDepth) {
  const Vector3 radii(0.06, 0.05, 0.03);
  const double k = 1e7, mass = 0.5;
  double low = 0, high = 1;
  for (int i = 0; i < 100; ++i) {
    const double t = 0.5 * (low + high);
    (k * M_PI * radii.prod() * t * t * (1 - t / 3) < mass * kGravity ? low : high) = t;
  }
  WorldDef def;
  def.settings.step = 1e-3;
  def.settings.gravity = Vector3(0, 0, -kGravity);
  def.settings.default_material.stiffness = k;
  def.articulations.push_back(scenes::floorBox());
  const auto shape = std::make_shared<Ellipsoid>(radii);
  const double height = radii.z() * (1 - low);
  def.articulations.push_back(
      scenes::freeBody("body", shape, mass, shape->massProperties(mass / shape->volume()).I_com, Pose(Vector3(0, 0, height))));
  World world(def);
  for (int i = 0; i < 1000; ++i) world.step();
  EXPECT_NEAR(world.linkPose(1).p.z(), height, 1e-9);
  EXPECT_NEAR((world.linkPose(1).R - Matrix3::Identity()).norm(), 0, 1e-9);
}

/// k A d = m g: a frustum stands on its bottom's true area, and stays upright.
TEST(Cones, StandAtTheirDepth) {
  const double k = 1e8, mass = 0.5, r = 0.05;
  WorldDef def;
  def.settings.step = 1e-3;
  def.settings.gravity = Vector3(0, 0, -kGravity);
  def.settings.default_material.stiffness = k;
  def.articulations.push_back(scenes::floorBox());
  const auto shape = std::make_shared<Cone>(r, 0.02, 0.08);
  const double depth = mass * kGravity / (k * M_PI * r * r);
  const MassProperties solid = shape->massProperties(mass / shape->volume());
  ArticulationDef body = scenes::freeBody("body", shape, mass, solid.I_com, Pose(Vector3(0, 0, 0.04 - depth)));
  body.links[0].inertia.p_LC = solid.com;
  def.articulations.push_back(body);
  World world(def);
  for (int i = 0; i < 1000; ++i) world.step();
  EXPECT_NEAR(world.linkPose(1).p.z(), 0.04 - depth, 1e-3 * depth);
  EXPECT_NEAR((world.linkPose(1).R - Matrix3::Identity()).norm(), 0, 1e-6);
}

}  // namespace ellipsoid_test
}  // namespace haptic
