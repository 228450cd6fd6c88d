// The invariant: force is on only while fresh, plausible counts of every board arrive. Random samples against a model that
// keeps the one number that matters, the instant of the last good counts.
#include "haptic_core/spidar/freshness.h"

#include <gtest/gtest.h>

#include <random>

#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {
namespace freshness_test {

constexpr double kStep = 1e-3, kLimit = 0.02;

DeviceDef g6x3r() {
  return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml");
}

struct Rig {
  DeviceTwin twin{g6x3r()};
  Spidar device{g6x3r()};
  Rig() {
    device.calibrateAtHome();
    device.setForceEnabled(true);
  }
  void tick(const DeviceSample& sample) {
    device.sense(sample, kStep);
    Wrench F;
    F.force.x() = 3;
    device.actuate(F, 0, kStep);
  }
  DeviceSample good() { return twin.exchange(device.drive()); }
  /// At rest the tensions of least wrench lie up to 0.02 N above their minimum.
  bool pulls() const {
    for (int i = 0; i < device.kinematics().strings(); ++i)
      if (device.toldTension()[i] > device.def().strings[i].min_tension + 0.05) return true;
    return false;
  }
};

/// Lost, late, silent, jumping and good samples in random runs.
TEST(Freshness, ForceEndsBeforeTheCountsAreTooOldWhateverArrives) {
  std::mt19937 random(7);
  long pulled = 0, cut = 0;
  for (int run = 0; run < 60; ++run) {
    Rig rig;
    for (int k = 0; k < 700; ++k) rig.tick(rig.good());
    ASSERT_TRUE(rig.pulls());
    double age = 0;  // of the newest good counts at the end of this exchange [s]
    const int kind = static_cast<int>(random() % 5), burst = 1 + static_cast<int>(random() % 30);
    for (int k = 0; k < 400; ++k) {
      DeviceSample s = rig.good();
      const bool bad = k % (burst + 2) < burst;
      double arrived = 0;
      if (bad && kind == 0) s.status = LinkStatus::kStale;
      if (bad && kind == 1) s.status = LinkStatus::kStale, s.lost = 1;
      if (bad && kind == 2) s.status = LinkStatus::kSilent;
      if (bad && kind == 3) s.counts[k % 8] += 40000;
      if (kind == 4) arrived = 1e-3 * static_cast<double>(random() % 30), s.age_us = static_cast<std::uint32_t>(1e6 * arrived);
      const bool good = s.status == LinkStatus::kOk && !(bad && kind == 3);
      age = good ? arrived : std::max(age + kStep, arrived);
      rig.tick(s);
      // What was computed here acts from the next exchange until the one after it.
      if (rig.pulls()) {
        ++pulled;
        ASSERT_LE(age + 2 * kStep, kLimit) << "run " << run << " kind " << kind << " tick " << k;
      } else {
        ++cut;
      }
      // Without good counts there is a new pose only where one string was replaced by what the others say.
      if (rig.device.poseIsNew() && !good) {
        ASSERT_TRUE(rig.device.flags() & kCountRefused) << "run " << run << " kind " << kind << " tick " << k;
        ASSERT_LT((rig.device.pose().p - rig.twin.latchedPose().X_BG.p).norm(), 1e-3) << "run " << run << " kind " << kind;
      }
      if (rig.device.poseValid()) { ASSERT_LE(rig.device.freshness().age(), kLimit); }
    }
  }
  EXPECT_GT(pulled, 1000);
  EXPECT_GT(cut, 1000);
}

/// A board that answers one question in five: counts are never old, and yet it obeys nobody.
TEST(Freshness, LostAnswersReduceTheForceAndThenEndIt) {
  Rig rig;
  for (int k = 0; k < 700; ++k) rig.tick(rig.good());
  int reduced = 0, ended = 0;
  for (int k = 1; k < 400 && !ended; ++k) {
    DeviceSample s = rig.good();
    if (k % 5) s.status = LinkStatus::kStale, s.lost = 1;
    rig.tick(s);
    if (!reduced && rig.device.state() == DeviceState::kReduced) reduced = k;
    if (!ended && rig.device.state() == DeviceState::kFault) ended = k;
  }
  // The share follows 0.8 (1 - exp(-t / 50 ms)): 0.1 at 6.7 ms, 0.5 at 49 ms; the run of losses moves it by four ticks.
  EXPECT_NEAR(reduced, 7, 4);
  EXPECT_NEAR(ended, 49, 5);
  EXPECT_TRUE(rig.device.causeFlags() & kAnswersLost);
  EXPECT_FALSE(rig.pulls());
}

/// K = 8 N·s/m / (T/2 + T + τ): below 1 N/mm from τ = 6.5 ms on.
TEST(Freshness, AWireThatIsTooSlowForAWallGetsNoForce) {
  for (const double delay : {0.0, 6.3e-3, 6.7e-3, 12e-3}) {
    Rig rig;
    for (int k = 0; k < 1200; ++k) {
      DeviceSample s = rig.good();
      s.age_us = static_cast<std::uint32_t>(1e6 * delay);
      rig.tick(s);
    }
    const double K = kRelaxedHandDamping / (1.5 * kStep + std::max(delay, rig.device.def().delay_s));
    EXPECT_NEAR(rig.device.stableStiffness(), K, 1e-3 * K);
    EXPECT_EQ(rig.device.state() == DeviceState::kEnabled, K > 1000) << delay;
    EXPECT_EQ((rig.device.flags() & kDelayTooLong) != 0, K < 1000) << delay;
    EXPECT_TRUE(rig.device.poseValid());
  }
}

TEST(Freshness, EveryWayIntoForceIsARamp) {
  Rig rig;
  for (int k = 0; k < 700; ++k) rig.tick(rig.good());
  const auto steepest = [&](const auto& disturb) {
    disturb();
    double most = 0, before = rig.device.achievedWrench().force.norm();
    for (int k = 0; k < 1000; ++k) {
      rig.tick(rig.good());
      const double now = rig.device.achievedWrench().force.norm();
      most = std::max(most, now - before);
      before = now;
    }
    EXPECT_GT(before, 2.8) << toString(rig.device.state()) << " flags " << rig.device.flags() << " cause " << rig.device.causeFlags();
    return most;
  };
  const double ramp = 3.0 * kStep / 0.5 * 1.5;  // 3 N in 0.5 s, and what λ takes away more of a small force
  EXPECT_LT(steepest([&] { rig.device.setForceEnabled(false), rig.tick(rig.good()), rig.device.setForceEnabled(true); }), ramp);
  EXPECT_LT(steepest([&] { rig.device.calibrateAt(rig.twin.pose()); }), ramp);
  const auto silence = [&] {
    DeviceSample s = rig.good();
    s.status = LinkStatus::kSilent;
    rig.tick(s);
    EXPECT_EQ(rig.device.toldTension().norm(), 0);
    rig.device.recover();
    rig.device.setForceEnabled(true);
  };
  EXPECT_LT(steepest(silence), ramp);
}


/// A board that repeats its counts looks like a grip at rest, until the force changes and nothing gives way.
/// Counts come again after 30 ms in which nobody ticked: no string may pull at once as it did before.
TEST(Freshness, ALoopThatStoodStillComesBackByARamp) {
  Rig rig;
  std::int64_t now_ns = 1000000000;
  const auto tick = [&](std::int64_t later_ns) {
    DeviceSample s = rig.good();
    s.stamp_ns = now_ns += later_ns;
    rig.tick(s);
  };
  for (int k = 0; k < 700; ++k) tick(1000000);
  ASSERT_GT(rig.device.achievedWrench().force.norm(), 2.8);
  tick(19000000);  // late, and not too late
  EXPECT_GT(rig.device.achievedWrench().force.norm(), 2.8);
  tick(30000000);
  EXPECT_LT(rig.device.achievedWrench().force.norm(), 0.1);
  EXPECT_EQ(rig.device.state(), DeviceState::kEnabled);
  for (int k = 0; k < 700; ++k) tick(1000000);
  EXPECT_GT(rig.device.achievedWrench().force.norm(), 2.8);
}

TEST(StillCounters, EndTheForceOnceItChanges) {
  Rig rig;
  const auto push = [&rig](const DeviceSample& sample, double newton) {
    rig.device.sense(sample, kStep);
    Wrench F;
    F.force.x() = newton;
    rig.device.actuate(F, 0, kStep);
  };
  for (int k = 0; k < 1000; ++k) push(rig.good(), k / 50 % 2 ? 1 : 3);
  ASSERT_EQ(rig.device.state(), DeviceState::kEnabled);
  for (int k = 0; k < 300; ++k) push(rig.good(), 1);  // at rest: a grip that stops while it moves tells by that alone
  DeviceSample stuck = rig.good();
  for (int k = 0; k < 1000; ++k) push(stuck, 1);
  EXPECT_EQ(rig.device.state(), DeviceState::kEnabled);  // nothing says that it is no hand at rest
  for (int k = 0; k < 100; ++k) push(stuck, 3);
  EXPECT_EQ(rig.device.state(), DeviceState::kFault);
  EXPECT_TRUE(rig.device.causeFlags() & kCountersStill);
  EXPECT_FALSE(rig.device.calibrated());
}
}  // namespace freshness_test
}  // namespace haptic
