/// A hand presses a light cube on a floor and slides over it: the load makes the contacts' dampers far
/// stronger than at rest, and two contacts damp one body. Explicit steps must neither launch it nor gain
/// energy.
#include <gtest/gtest.h>

#include "../../scenes/blocks.h"

namespace haptic {
namespace pressed_cube_test {

using namespace scenes;

constexpr double kSize = 0.03, kHandRadius = 0.005;

WorldDef pressedCube(Attempts attempts, double dissipation) {
  WorldDef def;
  def.name = "pressed cube";
  def.settings.attempts = attempts;
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = 1e7;
  m.dissipation = dissipation;
  m.mu_static = 0.6;
  m.mu_dynamic = 0.5;
  def.articulations.push_back(floorBox(0.3, 0.02));
  const double sink = 0.1 * kGravity / (m.stiffness * kSize * kSize);
  def.articulations.push_back(
      freeBox("cube", Vector3::Constant(kSize), 0.1, Pose(Vector3(0, 0, kSize / 2 - sink))));
  const auto tip = std::make_shared<ConvexPolyhedron>(makeSphere(kHandRadius, 2));
  def.articulations.push_back(
      freeBody("hand", tip, 0.05, 5e-7 * Matrix3::Identity(), Pose(Vector3(0, 0, kSize + 2 * kHandRadius))));
  def.articulations[2].links[0].collisions[0].material.stiffness = 1e9;
  PointerDef pointer;
  pointer.articulation = 2;
  pointer.link = 0;
  def.pointers.push_back(pointer);
  return def;
}

/// Down to 4 mm within the cube in 0.4 s, then 8 mm to and fro.
Vector3 handAt(double t) {
  const double u = std::min(1.0, t / 0.4), down = u * u * (3 - 2 * u);
  const double aside = t < 0.5 ? 0 : 0.008 * std::sin(5 * (t - 0.5));
  return Vector3(aside, 0, kSize + 2 * kHandRadius - 0.009 * down);
}

class PressedCube : public testing::TestWithParam<std::tuple<Attempts, double>> {};

INSTANTIATE_TEST_SUITE_P(Steps, PressedCube,
                         testing::Combine(testing::Values(Attempts::kImplicitEuler),
                                          testing::Values(0.0, 1.0, 10.0, 30.0)));

TEST_P(PressedCube, IsNeitherLaunchedNorGivenEnergy) {
  World world(pressedCube(std::get<0>(GetParam()), std::get<1>(GetParam())));
  const double h = world.settings().step;
  double gain = 0, exchanged = 0, start = 0, strongest = 0, highest = 0;
  for (int i = 0; i < 2000; ++i) {
    const double t = (i + 1) * h;
    Twist V;
    V.linear = (handAt(t + 1e-6) - handAt(t - 1e-6)) / 2e-6;
    world.setPointerTarget(0, Pose(handAt(t)), V);
    world.step();
    const EnergyLedger& e = world.report().energy;
    if (i == 0) start = e.balance();
    gain = std::max(gain, e.balance() - start);
    exchanged = std::max({exchanged, e.kinetic, e.elastic, std::abs(e.external)});
    strongest = std::max(strongest, world.pointerWrench(0).force.norm());
    highest = std::max(highest, world.linkPose(1).p.z());
  }
  // Tip and floor are springs in series, 4 mm together: the force stays below what the floor's alone would take.
  const double floor_alone = 1e7 * kSize * kSize * 0.004;
  EXPECT_GT(strongest, 0.3 * floor_alone);
  EXPECT_LT(strongest, floor_alone);
  EXPECT_LT(highest, 0.6 * kSize);
  // The scheme's own error in the energy of an oscillator: hω/2 to first order; ω of the loaded cube.
  // Of that, 1.2 mm are the tip's: π k δ² (R - δ/3) = 23 N.
  const double omega = std::sqrt((1e9 * 2 * M_PI * kHandRadius * 1.2e-3 + 1e7 * kSize * kSize) / 0.1);
  EXPECT_LT(gain, h * omega / 2 * exchanged);
}

}  // namespace pressed_cube_test
}  // namespace haptic
