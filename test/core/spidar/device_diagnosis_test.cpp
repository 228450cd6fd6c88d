// Which cause is named, and what becomes of the force: the table alone, and devices on their twin with a clock that stalls.
#include "haptic_core/spidar/device_diagnosis.h"

#include <gtest/gtest.h>

#include <set>

#include "haptic_core/spidar/device_record.h"
#include "haptic_core/spidar/device_twin.h"

namespace haptic {
namespace device_diagnosis_test {

constexpr double kStep = 1e-3;

DeviceDef load(const char* name) {
  return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml");
}

/// A device on its twin, on a clock that the test moves: every tick has a stamp.
struct Rig {
  explicit Rig(const char* name = "spidar_g6x5r", const char* path = "rest") : device(load(name)), twin(load(name), settings(path)) {
    device.calibrateAtHome();
    device.setForceEnabled(true);
  }
  static TwinSettings settings(const char* path) {
    TwinSettings s;
    s.path = handPath(path);
    return s;
  }
  DeviceSample good() {
    DeviceSample s = twin.exchange(device.drive());
    s.stamp_ns = now_ns;
    return s;
  }
  void take(DeviceSample s, const Wrench& F = {}) {
    if (s.status != LinkStatus::kOk) {
      s.stamp_ns = last_ok_ns;
      s.age_us = static_cast<std::uint32_t>((now_ns - last_ok_ns) / 1000);
    }
    last_ok_ns = s.status == LinkStatus::kOk ? now_ns : last_ok_ns;
    device.sense(s, kStep);
    device.actuate(F, 0, kStep);
    now_ns += 1000000;
  }
  void tick(const Wrench& F = {}) { take(good(), F); }
  void run(int ticks, const Wrench& F = {}) {
    for (int k = 0; k < ticks; ++k) tick(F);
  }
  void silent(int ticks, LinkStatus status = LinkStatus::kStale) {
    for (int k = 0; k < ticks; ++k) {
      DeviceSample s = good();
      s.status = status;
      take(s);
    }
  }
  std::string said() const { return advice(recordOf(device, 0, 0, {}), "device"); }
  bool noCurrent() const { return device.toldTension().norm() == 0; }
  /// Of the tensions that were told, on the true pose [N].
  double netForce() const {
    return (device.kinematics().structure(twin.pose()).leftCols(3).transpose() * device.toldTension()).norm();
  }
  Spidar device;
  DeviceTwin twin;
  std::int64_t now_ns = 1000000000, last_ok_ns = 0;
};

Wrench along(double x, double y, double z) {
  Wrench F;
  F.force = Vector3(x, y, z);
  return F;
}

TEST(Diagnosis, EveryRowCanBeReachedAndEveryCauseHasWords) {
  std::set<DeviceCause> seen;
  const WireFinding last = WireFinding::kCountsWild;
  for (int status = 0; status <= static_cast<int>(LinkStatus::kRestarted); ++status)
    for (int finding = 0; finding <= static_cast<int>(last); ++finding)
      for (int a = 0; a < 40; ++a)
        for (int b = 0; b < 40; ++b)
          seen.insert(diagnose(1ull << a | 1ull << b, static_cast<LinkStatus>(status), static_cast<WireFinding>(finding)).cause);
  for (int c = 0; c < static_cast<int>(DeviceCause::kCauses); ++c) {
    const auto cause = static_cast<DeviceCause>(c);
    EXPECT_TRUE(seen.count(cause)) << toString(cause);
    EXPECT_EQ(whatHappened(cause, 2, 0.067).empty(), cause == DeviceCause::kNone);
    EXPECT_EQ(whatHappened(cause, 2, 0.067).find('%'), std::string::npos);
  }
}

/// Whatever is old when this program was late, it accuses no part of the device; silence that lasts does.
TEST(Diagnosis, BeingLateIsNeverABrokenDevice) {
  EXPECT_EQ(diagnose(kLinkLost | kLoopLate, LinkStatus::kStale, WireFinding::kNone).cause, DeviceCause::kLoopLate);
  EXPECT_EQ(diagnose(kAnswersLost | kLoopLate, LinkStatus::kOk, WireFinding::kNone).cause, DeviceCause::kLoopLate);
  EXPECT_EQ(diagnose(kLinkLost, LinkStatus::kStale, WireFinding::kNone).cause, DeviceCause::kBoardSilent);
  // A motor whose string broke runs away: its board answers all the while.
  EXPECT_EQ(diagnose(kLinkLost, LinkStatus::kStale, WireFinding::kCountsWild).cause, DeviceCause::kCounterJumped);
  EXPECT_EQ(diagnose(kLinkLost | kLoopLate | kSilenceLasts, LinkStatus::kStale, WireFinding::kNone).presenting, Consequence::kStop);
  for (const WireFinding finding : {WireFinding::kPowerLost, WireFinding::kTableSpoilt, WireFinding::kWrongMode})
    EXPECT_EQ(diagnose(kLinkLost | kLoopLate, LinkStatus::kSilent, finding).cause, causeOf(finding));
}

/// The grip moves on while the computer stands still: the lengths stay, the way back is a ramp, and the machine is named.
TEST(Diagnosis, AStallKeepsTheLengthsAndNamesTheMachine) {
  for (const int stall_ms : {25, 67, 200}) {
    Rig rig("spidar_g6x5r", "wave");
    rig.run(2200, along(1, 0, 0));
    ASSERT_EQ(rig.device.state(), DeviceState::kEnabled);
    const Vector3 before = rig.twin.pose().X_BG.p;
    for (int k = 0; k < stall_ms; ++k) rig.twin.exchange({}), rig.now_ns += 1000000;
    EXPECT_GT((rig.twin.pose().X_BG.p - before).norm(), 1e-4);
    rig.tick(along(1, 0, 0));
    EXPECT_EQ(rig.device.cause(), DeviceCause::kLoopLate) << stall_ms << rig.said();
    EXPECT_NE(rig.said().find("stood still"), std::string::npos) << rig.said();
    EXPECT_LT(rig.device.askedWrench().force.norm(), 0.05);
    for (int k = 0; k < 700; ++k) {
      rig.tick(along(1, 0, 0));
      ASSERT_NE(rig.device.state(), DeviceState::kFault) << stall_ms << ' ' << k << rig.said();
      ASSERT_LT((rig.device.pose().p - rig.twin.latchedPose().X_BG.p).norm(), 1e-4);
    }
    EXPECT_EQ(rig.device.state(), DeviceState::kEnabled);
    EXPECT_GT(rig.device.askedWrench().force.norm(), 0.9);
  }
}

/// Without an answer for a while, at the start or later: no current, no pose, and no fault before it lasts.
TEST(Diagnosis, AnInterruptionIsNoFault) {
  Rig rig;
  rig.silent(80);
  EXPECT_NE(rig.device.state(), DeviceState::kFault) << rig.said();
  EXPECT_TRUE(rig.noCurrent());
  rig.run(800, along(0, 1, 0));
  ASSERT_EQ(rig.device.state(), DeviceState::kEnabled) << rig.said();
  rig.silent(60);
  EXPECT_EQ(rig.device.state(), DeviceState::kReady);
  EXPECT_TRUE(rig.noCurrent());
  EXPECT_FALSE(rig.device.poseValid());
  EXPECT_EQ(rig.device.cause(), DeviceCause::kBoardSilent);
  double before = 0;
  for (int k = 0; k < 700; ++k) {
    rig.tick(along(0, 1, 0));
    ASSERT_LT(rig.device.askedWrench().force.norm() - before, 0.005);  // a ramp of half a second to 1 N, and rounding
    before = rig.device.askedWrench().force.norm();
  }
  EXPECT_EQ(rig.device.state(), DeviceState::kEnabled);
  rig.silent(600);
  EXPECT_EQ(rig.device.state(), DeviceState::kFault);
  EXPECT_EQ(rig.device.cause(), DeviceCause::kBoardSilent);
}

/// Boards that come and go for a moment: one state, not two in turns.
TEST(Diagnosis, ALinkThatComesAndGoesDoesNotFlicker) {
  Rig rig;
  rig.run(700);
  rig.silent(700);
  int changes = 0;
  bool before = rig.device.linkLost();
  for (int k = 0; k < 40; ++k) {
    rig.run(30);
    changes += rig.device.linkLost() != before, before = rig.device.linkLost();
    rig.silent(30, LinkStatus::kSilent);
    changes += rig.device.linkLost() != before, before = rig.device.linkLost();
  }
  EXPECT_EQ(changes, 0);
  EXPECT_EQ(rig.device.state(), DeviceState::kFault);
}

/// A slip of a few millimetres within a tick: its string is named and corrected, whatever its size up to 25 mm.
TEST(Diagnosis, ASlipIsAStringsBusiness) {
  for (const double slip : {1e-3, 4.5e-3, -20e-3}) {
    Rig rig("spidar_g6x5r", "wave");
    rig.run(2200);
    const auto counts = std::llround(slip / rig.device.def().strings[4].length_per_count);
    for (int k = 0; k < 200; ++k) {
      DeviceSample s = rig.good();
      s.counts[4] += counts;
      if (k < 2) s.status = LinkStatus::kStale;  // the wire refuses two readings before it follows
      rig.take(s);
      ASSERT_NE(rig.device.state(), DeviceState::kFault) << slip << rig.said();
    }
    EXPECT_TRUE(rig.device.flags() & kStringCorrected) << slip;
    EXPECT_EQ(rig.device.suspectString(), 4);
    EXPECT_LT((rig.device.pose().p - rig.twin.latchedPose().X_BG.p).norm(), 1e-3);
  }
}

/// 8 ms: 842 N/m at 1 kHz. The state says what the sentence says.
TEST(Diagnosis, ASlowWireIsNeverEnabledAndRefusedAtOnce) {
  Rig rig;
  rig.run(700);
  ASSERT_EQ(rig.device.state(), DeviceState::kEnabled);
  for (int k = 0; k < 3000; ++k) {
    DeviceSample s = rig.good();
    s.stamp_ns -= 8000000;
    s.age_us = 8000;
    rig.take(s, along(3, 0, 0));
    const bool refused = rig.said().find("refused") != std::string::npos;
    ASSERT_FALSE(refused && rig.device.state() == DeviceState::kEnabled) << k << rig.said();
  }
  EXPECT_EQ(rig.device.state(), DeviceState::kReduced);
  EXPECT_EQ(rig.device.cause(), DeviceCause::kWireSlow);
  EXPECT_LE(rig.device.askedWrench().force.norm(), 1 + 1e-9);
}

/// Away from home, with the force on: refused with a reason; who means it asks again.
TEST(Diagnosis, ACalibrationAwayFromHomeIsRefused) {
  Rig rig;
  for (int k = 0; k < 1500; ++k) {
    HandTarget aside{{}, true};
    aside.pose.X_BG.p = std::min(1.0, 1e-3 * k) * Vector3(0.02, 0.01, 0);
    rig.twin.setHandTarget(aside);
    rig.tick();
  }
  ASSERT_EQ(rig.device.state(), DeviceState::kEnabled) << rig.said();
  const StringVector lengths = rig.device.zeroLengths();
  rig.device.calibrateAtHome();
  rig.tick();
  EXPECT_EQ(rig.device.zeroLengths(), lengths);
  EXPECT_TRUE(rig.device.flags() & kCalibrationRefused);
  EXPECT_NE(rig.said().find("not calibrated"), std::string::npos);
  rig.device.calibrateAtHome();
  rig.tick();
  EXPECT_NE(rig.device.zeroLengths(), lengths);
  EXPECT_FALSE(rig.device.flags() & kCalibrationRefused);
}

/// A pose that is 20 mm wrong: in FAULT the strings leave the hand alone, where it is.
TEST(Diagnosis, AFaultPullsNowhere) {
  for (const double wrong : {0.0, 5e-3, 20e-3}) {
    Rig rig;
    rig.run(700, along(0, 0, 3));
    GripPose believed;
    believed.X_BG.p = Vector3(wrong, -wrong, wrong) / std::sqrt(3.0);
    rig.device.calibrateAt(believed);
    rig.tick();
    rig.device.calibrateAt(believed);  // it is meant
    rig.run(700, along(0, 0, 3));
    // One string tells lies: more than the screen corrects, or for longer than doubt lasts.
    bool fault = false;
    for (int k = 0; k < 2000 && !fault; ++k) {
      DeviceSample s = rig.good();
      s.counts[2] += std::min<std::int64_t>(20 * k, 1500);
      rig.take(s, along(0, 0, 3));
      fault = rig.device.state() == DeviceState::kFault;
    }
    ASSERT_TRUE(fault);
    for (int k = 0; k < 1000; ++k) {
      DeviceSample s = rig.good();
      s.counts[2] += 1500;
      rig.take(s, along(0, 0, 3));
      ASSERT_LE(rig.netForce(), 0.1) << wrong << ' ' << k << rig.said();
    }
  }
}

/// All counters of a moving grip at once, and those of one board: at most little force, and said.
TEST(Diagnosis, FrozenCountersAreSeen) {
  for (const std::uint32_t mask : {0xFFu, 0x0Fu, 0xF0u})
    for (const int start : {2100, 2350, 2900, 3300}) {
      Rig rig("spidar_g6x4", "wave");
      rig.run(start);
      ASSERT_EQ(rig.device.state(), DeviceState::kEnabled) << rig.said();
      const DeviceSample frozen = rig.good();
      const Vector3 from = rig.twin.pose().X_BG.p;
      rig.take(frozen);
      int seen = 0;
      double way = 0;
      for (int k = 1; k <= 100 && !seen; ++k) {
        DeviceSample s = rig.good();
        for (std::size_t i = 0; i < 8; ++i)
          if (mask >> i & 1u) s.counts[i] = frozen.counts[i];
        rig.take(s);
        way = (rig.twin.pose().X_BG.p - from).norm();
        if (rig.device.state() != DeviceState::kEnabled) seen = k;
      }
      if (way < 5e-3 && !seen) continue;  // it has hardly moved
      EXPECT_GT(seen, 0) << mask << " from " << start << ", " << 1e3 * way << " mm";
      // A slow grip makes the lengths contradict each other before a third counter misses enough.
      for (int k = 0; k < 100 && rig.device.cause() == DeviceCause::kStringDoubtful; ++k) {
        DeviceSample s = rig.good();
        for (std::size_t i = 0; i < 8; ++i)
          if (mask >> i & 1u) s.counts[i] = frozen.counts[i];
        rig.take(s);
      }
      const DeviceCause cause = rig.device.cause();
      EXPECT_EQ(cause, mask == 0xFF ? DeviceCause::kCountersFrozen : DeviceCause::kBoardRepeats) << mask << " from " << start << rig.said();
    }
}

/// `check DEVICE` names a speed: counts that freeze after a faster motion are seen within the time it names, after a slower one never.
TEST(Diagnosis, FrozenCountsAreSeenAboveTheSpeedThatCheckNames) {
  constexpr double kTick = 1e-4;  // finer than a count at these speeds
  for (const char* name : {"spidar_g6x3r", "spidar_g6x5r"}) {
    const DeviceDef def = load(name);
    for (const double share : {0.7, 1.3}) {
      StillCounters still(def);
      std::array<std::int64_t, kMaxStrings> counts{};
      const double rate = share * still.tellingSpeed() / std::fabs(def.strings[0].length_per_count);  // [counts/s]
      int k = 0;
      for (; k < 3000; ++k) {
        counts[0] = static_cast<std::int64_t>(rate * kTick * k);
        still.take(counts, kTick);
        ASSERT_FALSE(still.frozen()) << name << ' ' << share << ' ' << k;
      }
      int seen = 0;
      for (; k < 6000 && !still.frozen(); ++k, ++seen) still.take(counts, kTick);
      const double within = 1.1 * StillCounters::kRest;
      if (share > 1) EXPECT_LE(seen * kTick, within) << name;
      if (share < 1) EXPECT_EQ(k, 6000) << name << ": a slower one may have stopped";
    }
  }
}

/// A string tells how the grip stopped only if it went until then, and as fast as it went last: the others go on at a count in 4 ms, as in
/// the hand of somebody who comes to rest.
TEST(Diagnosis, AStringThatSlowedDownBeforeTheOthersIsNotFrozen) {
  const DeviceDef def = load("spidar_g6x4");
  for (const int ticks_a_count : {0, 4}) {  // of the fast string, afterwards; 0: it stops at once
    StillCounters still(def);
    std::array<std::int64_t, kMaxStrings> counts{};
    const double fast = 2 * still.tellingSpeed() / std::fabs(def.strings[0].length_per_count) * 1e-3;  // [counts/tick]
    double way = 0;
    for (int k = 0; k < 300; ++k) {
      if (k < 100) way += fast;
      if (k < 200 && k % 4 == 0) ++counts[1];
      if (k >= 100 && k < 200 && ticks_a_count > 0 && k % ticks_a_count == 0) way += 1;
      counts[0] = static_cast<std::int64_t>(way);
      still.take(counts, 1e-3);
      ASSERT_FALSE(still.frozen()) << ticks_a_count << ' ' << k;
    }
  }
}

/// A hand that rests, reverses, and stops as hands do is no board that repeats its counts.
TEST(Diagnosis, AGripThatStopsIsNotFrozen) {
  for (const char* path : {"wave", "touch_cube", "rest"}) {
    Rig rig("spidar_g6x5r", path);
    for (int k = 0; k < 12000; ++k) {
      rig.tick(along(0, 0, std::min(5.0, std::max(0.0, 2000 * (-0.004 - rig.device.pose().p.z())))));
      ASSERT_FALSE(rig.device.flags() & kCountersFrozen) << path << ' ' << k;
    }
  }
}

/// A grip that a wall pushes is not at home, however near: the calibration is refused, asked twice as well, and no string is blamed later.
TEST(Diagnosis, ACalibrationUnderForceIsRefusedAndSaysSo) {
  for (const double newtons : {1.0, 3.0}) {
    Rig rig;
    rig.run(1200);
    ASSERT_EQ(rig.device.state(), DeviceState::kEnabled);
    rig.run(600, along(0, newtons, 0));  // 2 and 6 mm from home, in a hand of 500 N/m
    const double off = rig.device.pose().p.norm();
    ASSERT_GT(off, 1e-3);
    for (int k = 0; k < 2; ++k) {
      rig.device.calibrateAtHome();
      rig.run(20, along(0, newtons, 0));
      EXPECT_TRUE(rig.device.flags() & kCalibrationRefused) << newtons;
      EXPECT_NE(rig.said().find("a force pushes the grip"), std::string::npos) << rig.said();
      EXPECT_NEAR(rig.device.pose().p.norm(), off, 1e-3);
    }
    rig.device.calibrateAt(rig.twin.pose());  // where it is
    rig.run(2);
    EXPECT_NEAR(rig.device.pose().p.norm(), off, 1e-3);
    rig.run(300);
    rig.device.calibrateAtHome();  // out of contact
    rig.run(2);
    EXPECT_LT((rig.device.pose().p - rig.twin.latchedPose().X_BG.p).norm(), 1e-3);
    EXPECT_EQ(rig.device.state(), DeviceState::kEnabled);
  }
}

}  // namespace device_diagnosis_test
}  // namespace haptic
