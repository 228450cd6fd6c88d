// The stiffness that a hand meets against closed forms, and the verdict against the loop itself.
#include "haptic_core/analysis/hand_certificate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../../scenes/touch.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/spidar/wall_bound.h"

namespace haptic {
namespace hand_certificate_test {

constexpr double kPeriod = 1e-3, kPress = 2, kRadius = 0.005, kSide = 0.01;  // [s], [N], [m], [m]

DeviceDef device() { return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml"); }

/// A pointer over a fixed wall whose face is z = 0, its home 10 mm above.
WorldDef overWall(const ConvexPolyhedron& shape, double stiffness) {
  return scenes::pointerOverWall(shape, 0.015, stiffness, kPeriod);
}

TEST(HandCertificate, AFlatFaceIsAsStiffAsItsAreaWhateverTheForce) {
  const WorldDef world = overWall(makeBox(Vector3::Constant(kSide)), 5e7);
  for (const double press : {0.5, 2.0, 5.0}) {
    const HandCertificate c = certifyHand(world, 0, {}, device(), press);
    EXPECT_EQ(c.pointer, "pointer");
    EXPECT_EQ(c.against, "wall");
    EXPECT_NEAR(c.stiffness, 5e7 * kSide * kSide, 1e-9 * c.stiffness);
    EXPECT_NEAR(certifyHand(world, 0, {2, 0.5}, device(), press).stiffness, c.stiffness, 1e-9 * c.stiffness);
    EXPECT_NEAR(certifyHand(world, 0, {2, 1}, device(), press).stiffness, 2 * c.stiffness, 1e-9 * c.stiffness);
  }
}

// V = π R δ² and A0 = 2π R δ of a shallow cap. The tessellation's facets are flat: the error of K falls with their size.
TEST(HandCertificate, ABallStiffensWithTheRootOfTheForce) {
  double last_error = INFINITY;
  for (const int subdivision : {2, 3, 4}) {
    const WorldDef world = overWall(makeSphere(kRadius, subdivision, RoundFit::kInscribed), 1e8);
    double error = 0;
    for (const double press : {0.5, 1.0, 2.0}) {
      const double k = 1e8, depth = std::sqrt(press / (M_PI * k * kRadius));
      // The cap's next term: V = π δ² (R - δ/3), A0 = π δ (2R - δ).
      double d = depth;
      for (int i = 0; i < 20; ++i) d = std::sqrt(press / (M_PI * k * (kRadius - d / 3)));
      const double exact = k * M_PI * d * (2 * kRadius - d);
      error = std::max(error, std::fabs(certifyHand(world, 0, {}, device(), press).stiffness / exact - 1));
    }
    EXPECT_LT(error, 0.5 * last_error) << "subdivision " << subdivision;
    last_error = error;
  }
  EXPECT_LT(last_error, 0.01);
}

TEST(HandCertificate, TheBearableFoundationIsAtTheBound) {
  const ConvexPolyhedron ball = makeSphere(kRadius);
  const HandCertificate stiff = certifyHand(overWall(ball, 1e9), 0, {}, device(), kPress);
  ASSERT_FALSE(stiff.holds());
  EXPECT_GT(stiff.held, stiff.alone);
  EXPECT_NE(stiff.text().find("WEAKENED"), std::string::npos);
  const HandCertificate gentle = certifyHand(overWall(ball, stiff.bearable), 0, {}, device(), kPress);
  // What a hand bears does not depend on what it touches now. Two bisections, each to rounding.
  EXPECT_NEAR(gentle.bearable / stiff.bearable, 1, 1e-9);
  EXPECT_TRUE(gentle.holds());
  EXPECT_NEAR(gentle.stiffness, stiff.held, 1e-9 * stiff.held);
  EXPECT_NE(gentle.text().find("PASS"), std::string::npos);
}

TEST(HandCertificate, AVirtualCouplingIsInSeries) {
  WorldDef world = overWall(makeBox(Vector3::Constant(kSide)), 5e7);
  world.pointers[0].coupling.mode = PointerCoupling::Mode::kVirtual;
  world.pointers[0].coupling.stiffness = 1000;
  const double wall = 5e7 * kSide * kSide;
  EXPECT_NEAR(certifyHand(world, 0, {}, device(), kPress).stiffness, wall * 1000 / (wall + 1000), 1e-6);
}

TEST(HandCertificate, APointerThatTouchesNothingIsFree) {
  WorldDef world = overWall(makeSphere(kRadius), 1e9);
  world.filters.push_back({0, 0, 1, 0});
  const HandCertificate c = certifyHand(world, 0, {}, device(), kPress);
  EXPECT_TRUE(c.against.empty());
  EXPECT_TRUE(c.holds());
}

/// Travel of the grip in the last quarter of two seconds in which a relaxed hand presses with kPress [m].
double restlessness(double stiffness) {
  const DeviceDef def = device();
  TwinSettings settings;
  settings.period = kPeriod;
  const double goal = 0.010 + kPress / settings.hand_stiffness;  // and as much deeper as the ball sinks
  DeviceTwin twin(def, settings);
  Spidar spidar(def);
  World world(overWall(makeSphere(kRadius), stiffness));
  HapticLoop loop(world);
  HandSettings hand;
  hand.workspace.X_WB.p = Vector3(0, 0, 0.015);
  hand.passivity.mode = PassivityMode::kOff;
  loop.attach(spidar, 0, hand);
  spidar.calibrateAtHome();
  spidar.setForceEnabled(true);
  HandTarget target;
  target.active = true;
  target.pose.X_BG.p = Vector3(0, 0, -goal - std::sqrt(kPress / (M_PI * stiffness * kRadius)));
  twin.setHandTarget(target);
  double low = INFINITY, high = -INFINITY;
  for (int i = 0; i < 2000; ++i) {
    const DeviceSample sample = twin.exchange(loop.drive(0));
    loop.tick(&sample, kPeriod);
    if (i < 1500) continue;
    low = std::min(low, twin.pose().X_BG.p.z());
    high = std::max(high, twin.pose().X_BG.p.z());
  }
  return high - low;
}

// Passive is sufficient for stable: below the bound nothing rings; three times beyond it, without any damper in the
// contact, everything does. The twin's wire has no delay of its own, which moves the bound by a sixth.
TEST(HandCertificate, TheLoopRestsBelowTheBoundAndRingsFarBeyond) {
  const HandCertificate c = certifyHand(overWall(makeSphere(kRadius), 1e9), 0, {}, device(), kPress);
  const double quantum = std::fabs(device().strings[0].length_per_count);
  EXPECT_LT(restlessness(0.6 * c.bearable), 10 * quantum);
  EXPECT_GT(restlessness(9 * c.bearable), 100 * quantum);  // K grows with the root of k
}

}  // namespace hand_certificate_test
}  // namespace haptic
