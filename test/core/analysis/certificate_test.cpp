// Oracles: closed forms, and the explicit step itself just below and above the limit that is predicted.
#include "haptic_core/analysis/certificate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/blocks.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace certificate_test {

using scenes::CubeParameters;

WorldSettings explicitSettings(double h) {
  WorldSettings s;
  s.comparator = comparators::velocityVerlet;
  s.pressure_law = PressureLaw::kLinear;
  s.step = h;
  return s;
}

TEST(Certificate, AFrictionlessCubeIsLimitedByItsHeave) {
  for (double ratio : {0.0, 0.1, 1.0}) {
    CubeParameters c;
    c.ratio = ratio;
    c.mu_static = c.mu_dynamic = 0;
    const Certificate certificate = certify(scenes::cubeOnFloor(c, explicitSettings(1e-3)));
    ASSERT_EQ(certificate.islands.size(), 1u);
    const double k = c.stiffness * c.area(), b = 2 * ratio * std::sqrt(k * c.mass);
    const double heave = 2 * std::sqrt(c.mass / k);  // k h² = 4 m: there the damper is none, or strong
    EXPECT_TRUE(b == 0 || b * heave > 0.15 * c.mass);
    EXPECT_NEAR(certificate.islands[0].limit, heave, 2e-3 * heave);
    EXPECT_NEAR(certificate.pairs[0].heave_limit, heave, 1e-9 * heave);
    EXPECT_EQ(certificate.islands[0].growth, 0);
  }
}

/// The law that runs is the one that is certified: one floor, or two of half its size side by side.
TEST(Certificate, AFloorOfTwoTilesIsOneFloor) {
  CubeParameters c;
  c.ratio = 0.1;
  const WorldDef one = scenes::cubeOnFloor(c, explicitSettings(1e-3));
  WorldDef two = one;
  two.articulations[0] = scenes::staticBox("left", Vector3(1, 2, 0.1), Pose(Vector3(-0.5 + 0.01, 0, -0.05)));
  two.articulations.push_back(scenes::staticBox("right", Vector3(1, 2, 0.1), Pose(Vector3(0.5 + 0.01, 0, -0.05))));
  // The dampers that an explicit step takes depend on how many contacts share the mass; masses and springs do not.
  const double frequency = certify(one).islands[0].frequency;
  const Certificate tiled = certify(two);
  EXPECT_EQ(tiled.pairs.size(), 2u);
  EXPECT_NEAR(tiled.islands[0].frequency, frequency, 1e-3 * frequency);  // finite differences at a thousandth of the depth
}

/// A belt that runs below a cube rubs at it and changes nothing of what holds it up.
TEST(Certificate, ABeltIsAFloor) {
  WorldDef def = scenes::cubeOnFloor({}, {});
  const Certificate still = certify(def, 0.2);
  def.articulations[0].links[0].collisions[0].belt.V_L.linear = Vector3(0.05, 0, 0);
  const Certificate runs = certify(def, 0.2);
  ASSERT_EQ(runs.islands.size(), 1u);
  EXPECT_EQ(runs.verdict, Verdict::kPass);
  EXPECT_EQ(runs.islands[0].growth, 0);
  EXPECT_NEAR(runs.islands[0].limit, still.islands[0].limit, 1e-3 * still.islands[0].limit);  // it has gone a way meanwhile
}

TEST(Certificate, FrictionSpringsLowerTheLimitOfTheWholeScene) {
  CubeParameters c;
  c.tangential = 2;
  const Certificate certificate = certify(scenes::stack(3, c, explicitSettings(1e-3)));
  EXPECT_LT(certificate.islands[0].limit, 0.9 * certificate.pairs[0].heave_limit);
}

/// Boxes of the cube's mass and height on one another, each a tenth narrower than the one below (cubes whose sides
/// are flush have a kink in the lateral force, at which growing modes stop at 0.1 mm/s), with a push and a turn of 1
/// µm.
WorldDef column(int boxes, const CubeParameters& c, double h, double push) {
  WorldDef def = scenes::cubeOnFloor(c, explicitSettings(h));
  def.articulations.resize(1);
  double z = 0;
  for (int i = 0; i < boxes; ++i) {
    const double width = c.size * (1 - 0.1 * i);
    z -= (boxes - i) * c.mass * scenes::kGravity / (c.stiffness * width * width);
    const Pose X_WL(Matrix3(Eigen::AngleAxisd(push / c.size, Vector3(1, 2, 3).normalized())),
                    Vector3(0, 0, z + c.size / 2) + push * Vector3(0.3, 0.5, -0.8));
    def.articulations.push_back(
        scenes::freeBox("box" + std::to_string(i), Vector3(width, width, c.size), c.mass, X_WL));
    z += c.size;
  }
  return def;
}

/// Rms speed of the top box in the last of 5 s.
double restlessness(int boxes, const CubeParameters& c, double h) {
  World world(column(boxes, c, h, 1e-6));
  double squares = 0;
  int samples = 0;
  for (double t = 0; t < 5 && world.report().finite; t += h) {
    world.step();
    if (t < 4) continue;
    squares += world.linkTwist(boxes).linear.squaredNorm();
    ++samples;
  }
  return world.report().finite ? std::sqrt(squares / samples) : 1e300;
}

TEST(Certificate, TheExplicitStepIsStableBelowTheLimitAndNotAbove) {
  for (int boxes : {1, 3}) {
    for (double ratio : {0.1, 1.0}) {
      CubeParameters c;
      c.ratio = c.tangential_ratio = ratio;
      const double limit = certify(column(boxes, c, 1e-3, 0)).islands[0].limit;
      // The push is 1 µm, 0.3 mm/s at the stiffest mode: after 4 s less than a third of it is left, or more, until friction yields.
      constexpr double kThird = 1e-4;
      const double below = restlessness(boxes, c, 0.98 * limit), above = restlessness(boxes, c, 1.03 * limit);
      EXPECT_LT(below, kThird) << boxes << " boxes, ratio " << ratio;
      EXPECT_GT(above, kThird) << boxes << " boxes, ratio " << ratio;
    }
  }
}

// A column of n cubes on springs falls over below k_eff = 5.1e4 N/m (continuum) or 5.6e4 N/m (discrete joints).
TEST(Certificate, KnowsThatASoftStackBuckles) {
  const auto growth = [](double k_eff) {
    CubeParameters c;
    c.stiffness = k_eff / c.area();
    return certify(scenes::stack(15, c, explicitSettings(1e-4)), 0.0).islands[0].growth;
  };
  EXPECT_GT(growth(4.5e4), 0);
  EXPECT_EQ(growth(6.5e4), 0);
}

}  // namespace certificate_test
}  // namespace haptic
