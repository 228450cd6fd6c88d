// The whole path once, against what it must give: counts → pose → world → wrench → tensions.
#include "haptic_core/loop/haptic_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../../scenes/touch.h"
#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {
namespace haptic_loop_test {

constexpr double kPeriod = 1e-3;  // [s]

/// A 20 mm box as pointer over a fixed wall whose face is the plane z = 0; k·Area = 2000 N/m where it touches.
WorldDef wall() { return scenes::pointerOverWall(makeBox({0.02, 0.02, 0.02}), 0.02, 2000 / (0.02 * 0.02), kPeriod); }

struct Bench {
  DeviceDef def = loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml");
  TwinSettings twin_settings;
  std::unique_ptr<DeviceTwin> twin;
  Spidar device{def};
  World world{wall()};
  HapticLoop loop{world};

  Bench() {
    twin_settings.period = kPeriod;
    twin = std::make_unique<DeviceTwin>(def, twin_settings);
    HandSettings settings;
    settings.workspace.X_WB.p = Vector3(0, 0, 0.02);  // the home pose is 10 mm above touch
    settings.soft_start_s = 0;
    loop.attach(device, 0, settings);
    device.calibrateAtHome();
    device.setForceEnabled(true);
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const DeviceSample sample = twin->exchange(loop.drive(0));
      loop.tick(&sample, kPeriod);
    }
  }
};

TEST(HapticLoop, AWallPushesBackAsItsStiffnessSays) {
  Bench bench;
  bench.run(1000);  // the device's ramp is over
  EXPECT_EQ(bench.loop.report().hand[0].F_asked_B.force.norm(), 0);
  HandTarget target;
  target.active = true;
  target.pose.X_BG.p = Vector3(0, 0, -0.012);
  bench.twin->setHandTarget(target);
  bench.run(2000);
  const HandReport& hand = bench.loop.report().hand[0];
  // The wall is told the steady reading of the counts; theirs is the pose that is reported.
  const double depth = 0.01 - hand.X_WP.p.z(), count = std::fabs(bench.def.strings[0].length_per_count);
  EXPECT_NEAR(hand.X_WP.p.z() - 0.02, hand.X_BG.p.z(), count);
  ASSERT_GT(depth, 1e-4);
  EXPECT_NEAR(hand.F_asked_B.force.z(), 2000 * depth, 0.01 * 2000 * depth);  // tilt of the grip: cos(0.1) = 0.5 %
  // What the strings give is what was asked, within λ's share and 5 %.
  EXPECT_NEAR(hand.F_achieved_B.force.z(), hand.F_asked_B.force.z(), 0.05 * hand.F_asked_B.force.z());
  // Balance on the grip: the hand's spring holds what the strings push, on the mean of the counts that the wall is told in, and the
  // grip rests within one of them.
  double unbalanced = 0, low = INFINITY, high = -INFINITY;
  constexpr int kTicks = 400;
  for (int i = 0; i < kTicks; ++i) {
    bench.run(1);
    unbalanced += (bench.twin->handWrench().force.z() + bench.twin->stringWrench().force.z()) / kTicks;
    low = std::min(low, bench.twin->pose().X_BG.p.z()), high = std::max(high, bench.twin->pose().X_BG.p.z());
  }
  EXPECT_NEAR(unbalanced, 0, 0.005);
  EXPECT_LE(high - low, count);
}

TEST(HapticLoop, SameSamplesGiveTheSameBits) {
  std::uint64_t hash[2];
  for (std::uint64_t& h : hash) {
    Bench bench;
    HandTarget target;
    target.active = true;
    target.pose.X_BG.p = Vector3(0.003, 0.001, -0.014);
    bench.twin->setHandTarget(target);
    bench.run(1500);
    h = bench.world.hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(HapticLoop, GivesNoForceBeforeCalibration) {
  Bench bench;
  Spidar fresh(bench.def);
  World world(wall());
  HapticLoop loop(world);
  loop.attach(fresh, 0, {});
  DeviceSample sample;
  for (int i = 0; i < 10; ++i) loop.tick(&sample, kPeriod);
  EXPECT_FALSE(loop.report().hand[0].valid);
  EXPECT_EQ(loop.report().hand[0].F_asked_B.force.norm(), 0);
}

// Minimum jerk over T: the greatest speed is 15/8 d/T, and at T the pointer is where the moved base has the grip.
TEST(HapticLoop, ABaseThatMovesTakesThePointerAlongWithoutAJump) {
  Bench bench;
  bench.run(1000);
  HandSettings settings = bench.loop.hand(0).settings();
  settings.soft_start_s = 0.2;
  settings.workspace.X_WB.p += Vector3(0.03, 0, 0.04);
  const double greatest = 15.0 / 8 * 0.05 / 0.2 * kPeriod;
  Pose last = bench.world.linkPose(1);
  bench.loop.hand(0).setSettings(settings);
  double fastest = 0;
  for (int i = 0; i < 210; ++i) {
    bench.run(1);
    const Pose now = bench.world.linkPose(1);
    fastest = std::max(fastest, (now.p - last.p).norm());
    last = now;
    ASSERT_EQ(bench.loop.report().hand[0].fade, 1) << "the force is not interrupted";
  }
  const double held_still = 1e-5;  // [m] the twin's hand within a tick, and the pose's resolution
  EXPECT_NEAR(fastest, greatest, held_still);
  const Vector3 expected = settings.workspace.X_WB * bench.loop.report().hand[0].X_BG.p;
  EXPECT_NEAR((last.p - expected).norm(), 0, 1e-12);
}

// A rigid rest of the grip, so that the force follows the fade alone: kFadeRate to the last newton, then nothing, then the soft start.
TEST(HapticLoop, ASilentHandIsLedOutOfItsForce) {
  Bench bench;
  bench.run(1000);
  GripPose pressed;  // comes to 2 mm into 2000 N/m, as fast as a hand
  const auto run = [&](int ticks) {
    double jump = 0, last = bench.loop.report().hand[0].F_asked_B.force.norm();
    for (int i = 0; i < ticks; ++i) {
      pressed.X_BG.p.z() = std::max(-0.012, pressed.X_BG.p.z() - 6e-5);
      pressed.X_BG.p.x() = 1e-4 * std::sin(0.06 * i);  // along the wall: counters that stand still under force are a fault
      bench.twin->place(pressed);
      bench.run(1);
      const double now = bench.loop.report().hand[0].F_asked_B.force.norm();
      jump = std::max(jump, std::fabs(now - last)), last = now;
    }
    return jump;
  };
  run(300);
  const double whole = bench.loop.report().hand[0].F_asked_B.force.norm();
  ASSERT_NEAR(whole, 4, 0.2);
  HandSettings settings = bench.loop.hand(0).settings();
  settings.soft_start_s = 0.2;
  settings.silent = true;
  bench.loop.take({ChangeHand{settings}});
  const double count = 2000 * std::fabs(bench.def.strings[0].length_per_count);  // [N] that the pose may change the force by meanwhile
  const int out = static_cast<int>(whole / (kFadeRate * kPeriod));
  EXPECT_LE(run(out / 2), (1 + 1e-9) * kFadeRate * kPeriod) << "whatever the counts do";
  EXPECT_NEAR(bench.loop.report().hand[0].F_asked_B.force.norm(), whole / 2, 0.02 * whole + count);
  run(out / 2 + 20);
  EXPECT_EQ(bench.loop.report().hand[0].F_asked_B.force.norm(), 0);
  bench.loop.take({RestoreWorld{bench.world.save()}});
  run(300);
  EXPECT_EQ(bench.loop.report().hand[0].F_asked_B.force.norm(), 0) << "whatever is loaded";
  settings.silent = false;
  bench.loop.take({ChangeHand{settings}});
  run(210);
  EXPECT_NEAR(bench.loop.report().hand[0].F_asked_B.force.norm(), whole, 0.02 * whole + count);
}

// Twelve lost ticks: neither the gain nor the force knows of them. More than 20 ms are an interruption, and a ramp leads back.
TEST(HapticLoop, ALateTickLeavesTheForceWhereItWas) {
  Bench bench;
  bench.run(1000);
  HandTarget target;
  target.active = true;
  target.pose.X_BG.p = Vector3(0, 0, -0.012);
  bench.twin->setHandTarget(target);
  bench.run(2000);
  const auto late = [&bench](int periods) {
    TickInput input;
    input.lost_periods = periods;
    input.hands = 1;
    input.sample[0] = bench.twin->exchange(bench.loop.drive(0));
    bench.loop.tick(input, kPeriod);
    return bench.loop.report().hand[0];
  };
  const double before = bench.loop.report().hand[0].F_asked_B.force.z();
  ASSERT_GT(before, 0.5);
  for (const int periods : {1, 3, 12}) {
    const HandReport after = late(periods);
    EXPECT_EQ(after.fade, 1) << periods;
    EXPECT_NEAR(after.F_asked_B.force.z(), before, 0.02 * before) << periods;
  }
  EXPECT_LT(late(30).fade, 2 * kPeriod / bench.device.settings().enable_ramp_s);
}

TEST(HapticLoop, RefusesAPointerThatTheSceneDoesNotHave) {
  Bench bench;
  EXPECT_THROW(bench.loop.attach(bench.device, 7, {}), SetupError);
}

}  // namespace haptic_loop_test
}  // namespace haptic
