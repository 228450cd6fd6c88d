#include "haptic_core/spidar/spidar.h"

#include <gtest/gtest.h>

#include <limits>

#include "haptic_core/spidar/device_twin.h"

namespace haptic {
namespace spidar_test {

constexpr double kStep = 1e-3;

DeviceDef g6x3r() {
  return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml");
}

/// A device on its twin, calibrated at home and, when asked, past the enable ramp.
struct Rig {
  Spidar device;
  DeviceTwin twin;
  Rig(const TwinSettings& settings, bool enabled) : device(g6x3r()), twin(g6x3r(), settings) {
    device.calibrateAtHome();
    device.setForceEnabled(enabled);
  }
  void tick(const Wrench& F = {}, double age = 0) {
    device.sense(twin.exchange(device.drive()), kStep);
    device.actuate(F, 0, kStep, age);
  }
  void run(int ticks, const Wrench& F = {}) {
    for (int i = 0; i < ticks; ++i) tick(F);
  }
};

TEST(Spidar, HasNoPoseBeforeCalibration) {
  Spidar device(g6x3r());
  DeviceTwin twin(g6x3r());
  device.sense(twin.exchange(device.drive()), kStep);
  EXPECT_EQ(device.state(), DeviceState::kUncalibrated);
  EXPECT_FALSE(device.calibrated());
  EXPECT_TRUE(device.lengths().array().isNaN().all());
  device.setForceEnabled(true);
  device.sense(twin.exchange(device.drive()), kStep);
  Wrench F;
  F.force.x() = 5;
  device.actuate(F, 0, kStep);
  for (int i = 0; i < 8; ++i) {
    const StringDef& s = device.def().strings[i];
    EXPECT_DOUBLE_EQ(device.drive().voltage[i], s.min_tension * s.volt_per_newton);
  }
}

TEST(Spidar, FollowsTheTwinWithinTheEncoderStep) {
  TwinSettings settings;
  settings.first_count = -12345;
  settings.path = handPath("touch_cube");
  Rig rig(settings, false);
  for (int i = 0; i < 9000; ++i) {
    rig.tick();
    const Vector3 error = rig.device.pose().p - rig.twin.latchedPose().X_BG.p;
    ASSERT_LT(error.norm(), 33e-6) << i;  // two counts: half a count per string, amplified by the geometry
    ASSERT_LT((rig.device.pose().R - rig.twin.latchedPose().X_BG.R).norm() / std::sqrt(2.0), 3.5e-3) << i;
  }
}

TEST(Spidar, PresentsTheWrenchItIsAskedFor) {
  TwinSettings settings;
  Rig rig(settings, true);
  Wrench F;
  F.force = Vector3(2, -1, 3);
  F.torque = Vector3(0.02, 0.03, -0.01);
  rig.run(2000, F);
  EXPECT_EQ(rig.device.state(), DeviceState::kEnabled);
  // λ weakens the wrench by about λ / (smallest eigenvalue of A W² Aᵀ, 0.4 here) = 2.5 %, in the norm with W.
  const Wrench error = rig.twin.stringWrench() - F;
  const double r = rig.device.kinematics().knotRadius();
  EXPECT_LT(std::hypot(error.force.norm(), error.torque.norm() / r),
            0.035 * std::hypot(F.force.norm(), F.torque.norm() / r));
  // The two differ by the encoder step: 8 strings of up to 10 N turned by 20 µm / 0.1 m at most.
  EXPECT_LT((rig.twin.stringWrench().force - rig.device.achievedWrench().force).norm(), 8 * 10 * 20e-6 / 0.1);
}

TEST(Spidar, DriveStaysWithinBoundsWhateverComesIn) {
  Rig rig(TwinSettings{}, true);
  rig.run(1000);
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  const double values[] = {0, 1e30, -1e30, inf, -inf, nan, 1e-300, 5, -5};
  for (int i = 0; i < 5000; ++i) {
    Wrench F;
    for (int c = 0; c < 3; ++c) {
      F.force[c] = values[(i * 7 + c * 3) % 9];
      F.torque[c] = values[(i * 5 + c * 2) % 9];
    }
    rig.tick(F, values[i % 9]);
    for (int s = 0; s < 8; ++s) {
      const StringDef& def = rig.device.def().strings[s];
      const double tension = rig.device.drive().voltage[s] / def.volt_per_newton;
      ASSERT_GE(tension, def.min_tension * (1 - 1e-12));
      ASSERT_LE(tension, def.max_tension * (1 + 1e-12));
    }
    ASSERT_LE(rig.device.askedWrench().force.norm(), rig.device.def().max_force * (1 + 1e-12));
  }
}

TEST(Spidar, AnOldCommandDecaysToMinimumTension) {
  Rig rig(TwinSettings{}, true);
  Wrench F;
  F.force.x() = 3;
  rig.run(1000, F);
  EXPECT_NEAR(rig.device.askedWrench().force.x(), 3, 1e-9);
  rig.tick(F, 0.04);
  EXPECT_NEAR(rig.device.askedWrench().force.x(), 1.5, 1e-9);
  rig.tick(F, 1.0);
  EXPECT_EQ(rig.device.askedWrench().force.x(), 0);
  EXPECT_TRUE(rig.device.flags() & kCommandStale);
}

TEST(Spidar, ALostLinkGivesZeroCurrentUntilRecovered) {
  Rig rig(TwinSettings{}, true);
  rig.run(1000);
  DeviceSample lost = rig.twin.exchange(rig.device.drive());
  lost.status = LinkStatus::kDisconnected;
  rig.device.sense(lost, kStep);
  rig.device.actuate(Wrench{}, 0, kStep);
  EXPECT_EQ(rig.device.state(), DeviceState::kFault);
  for (double volt : rig.device.drive().voltage) EXPECT_EQ(volt, 0);
  rig.tick();
  for (double volt : rig.device.drive().voltage) EXPECT_EQ(volt, 0);
  rig.device.recover();
  rig.tick();
  EXPECT_NE(rig.device.state(), DeviceState::kFault);
  EXPECT_NE(rig.device.drive().voltage[0], 0);
}

TEST(Spidar, WithoutAGuardThereIsAPoseAndNoCurrentUntilRecovered) {
  Rig rig(TwinSettings{}, true);
  Wrench F;
  F.force.x() = 3;
  rig.run(1000, F);
  ASSERT_EQ(rig.device.state(), DeviceState::kEnabled);
  for (int k = 0; k < 50; ++k) {
    DeviceSample alone = rig.twin.exchange(rig.device.drive());
    alone.status = LinkStatus::kUnguarded;
    rig.device.sense(alone, kStep);
    rig.device.actuate(F, 0, kStep);
    EXPECT_EQ(rig.device.state(), DeviceState::kFault);
    EXPECT_TRUE(rig.device.poseIsNew()) << k;
    for (double volt : rig.device.drive().voltage) EXPECT_EQ(volt, 0);
  }
  rig.run(10, F);
  EXPECT_EQ(rig.device.state(), DeviceState::kFault) << "a new guard is no reason to pull";
  for (double volt : rig.device.drive().voltage) EXPECT_EQ(volt, 0);
  rig.device.recover();
  rig.tick();
  EXPECT_EQ(rig.device.state(), DeviceState::kReady);
}

TEST(Spidar, StopIsZeroCurrentInTheSameTickUntilSomebodyAsks) {
  Rig rig(TwinSettings{}, true);
  Wrench F;
  F.force.x() = 3;
  rig.run(1000, F);
  ASSERT_GT(rig.device.drive().voltage[0], 0);
  rig.device.stop();
  for (int k = 0; k < 20; ++k) {
    rig.tick(F);
    EXPECT_EQ(rig.device.state(), DeviceState::kReady);
    EXPECT_TRUE(rig.device.flags() & kStopped);
    for (double volt : rig.device.drive().voltage) EXPECT_EQ(volt, 0) << k;
  }
  const std::vector<double> memory = rig.device.save();
  Spidar other(rig.device.def());
  other.restore(memory);
  EXPECT_TRUE(other.stopped()) << "a replay from here on must know it";
  rig.device.recover();
  rig.tick(F);
  EXPECT_EQ(rig.device.state(), DeviceState::kReady);
  EXPECT_GT(rig.device.drive().voltage[0], 0) << "tension, without force";
  rig.device.stop();
  rig.tick(F);
  rig.device.setForceEnabled(true);
  rig.run(20, F);
  EXPECT_EQ(rig.device.state(), DeviceState::kEnabled);
  EXPECT_LT(rig.device.askedWrench().force.x(), 0.2) << "the way back into force is a ramp";
}

TEST(Spidar, IsWithoutCurrentOnceTheBoardsHaveAnsweredADriveWithoutIt) {
  Rig rig(TwinSettings{}, true);
  rig.run(1000);
  const auto tick = [&rig](LinkStatus status, std::uint32_t age_ticks) {
    DeviceSample sample = rig.twin.exchange(rig.device.drive());
    sample.status = status;
    sample.age_ticks = age_ticks;
    rig.device.sense(sample, kStep);
    rig.device.actuate(Wrench{}, 0, kStep);
    return rig.device.currentless();
  };
  EXPECT_FALSE(tick(LinkStatus::kOk, 0));
  rig.device.stop();
  EXPECT_FALSE(tick(LinkStatus::kOk, 0)) << "this exchange sent the drive from before";
  EXPECT_FALSE(tick(LinkStatus::kOk, 1)) << "sent, and the counts answer the exchange before";
  EXPECT_FALSE(tick(LinkStatus::kSilent, 0)) << "nothing answers";
  EXPECT_FALSE(tick(LinkStatus::kOk, 3));
  EXPECT_TRUE(tick(LinkStatus::kOk, 3));
  EXPECT_TRUE(tick(LinkStatus::kSilent, 0)) << "the boards keep their last command";
  rig.device.recover();
  EXPECT_TRUE(tick(LinkStatus::kOk, 0)) << "as this exchange ended";
  EXPECT_FALSE(tick(LinkStatus::kOk, 0));
}

TEST(Spidar, ForceIsOnOnlyWhileTheSwitchIsHeld) {
  Rig rig(TwinSettings{}, true);
  Wrench F;
  F.force.x() = 3;
  rig.run(1000, F);
  EXPECT_NEAR(rig.device.askedWrench().force.x(), 3, 1e-9);
  rig.device.hold(false);
  rig.tick(F);
  EXPECT_EQ(rig.device.state(), DeviceState::kReady);
  EXPECT_EQ(rig.device.askedWrench().force.norm(), 0);
  rig.device.setForceEnabled(true);
  rig.run(200, F);
  EXPECT_EQ(rig.device.askedWrench().force.norm(), 0) << "not by enabling either";
  EXPECT_TRUE(rig.device.flags() & kReleased);
  const std::vector<double> memory = rig.device.save();
  Spidar other(rig.device.def());
  other.restore(memory);
  EXPECT_FALSE(other.held()) << "a replay from here on must know it";
  rig.device.hold(true);
  rig.run(20, F);
  EXPECT_EQ(rig.device.state(), DeviceState::kEnabled);
  EXPECT_LT(rig.device.askedWrench().force.x(), 0.2) << "the way back into force is a ramp";
  rig.run(1000, F);
  EXPECT_NEAR(rig.device.askedWrench().force.x(), 3, 1e-9);
}

// A limit that is lowered while a force is on, a doubt or a release: from then on the force only falls until it is within, wherever what
// is wanted turns meanwhile and whatever a damper behind the law adds; by the law all the while.
TEST(Spidar, AForceBeyondALimitThatIsLoweredOnlyFalls) {
  constexpr double kBefore = 8, kLowered = 2;
  const ForceSlew slew{4000, 0.02, 100};
  const Twist moved{Vector3::Zero(), Vector3(0.1, 0, 0)};  // 0.4 N in a tick
  for (const bool off : {false, true}) {
    Rig rig({}, true);
    Wrench F;
    F.force.x() = kBefore;
    rig.run(900, F);
    ASSERT_NEAR(rig.device.askedWrench().force.norm(), kBefore, 1e-9);
    Spidar::Tuning tuning = rig.device.tuning();
    if (off) rig.device.setForceEnabled(false);
    else tuning.max_force = kLowered;
    rig.device.tune(tuning);
    double last = kBefore;
    for (int i = 0; i < 200; ++i) {
      rig.device.sense(rig.twin.exchange(rig.device.drive()), kStep);
      F.force = kBefore * Vector3(std::cos(0.5 * i), std::sin(0.5 * i), 0);
      Wrench damped = rig.device.admit(F, slew, moved, kStep);
      damped.force += Vector3(0, 1, 0);
      const Vector3 before = rig.device.askedWrench().force;
      rig.device.present(damped, 0, kStep);
      const double now = rig.device.askedWrench().force.norm();
      ASSERT_LE(now, std::max(off ? 0 : kLowered, last) * (1 + 1e-12)) << i;
      EXPECT_LE((rig.device.askedWrench().force - before).norm(), 0.5 + 1 + 1e-9) << i;
      last = now;
    }
    EXPECT_LE(last, off ? 0 : kLowered * (1 + 1e-12));
  }
}

// Little force stays little where the greatest force is raised meanwhile.
TEST(Spidar, AForceThatIsReducedDoesNotRiseWithTheLimit) {
  Rig rig({}, true);
  Spidar::Tuning tuning = rig.device.tuning();
  const double whole = tuning.max_force;
  tuning.max_force = 1;
  rig.device.tune(tuning);
  Wrench F;
  F.force.x() = whole;
  rig.run(900, F);
  for (int i = 0; i < 40 && rig.device.state() == DeviceState::kEnabled; ++i) {  // a fifth of the answers come
    DeviceSample sample = rig.twin.exchange(rig.device.drive());
    if (i % 5) sample.status = LinkStatus::kStale, sample.lost = 1;
    rig.device.sense(sample, kStep);
    rig.device.actuate(F, 0, kStep);
  }
  ASSERT_EQ(rig.device.state(), DeviceState::kReduced);
  tuning.max_force = whole;
  rig.device.tune(tuning);
  for (int i = 0; i < 300; ++i) {
    rig.tick(F);
    ASSERT_LE(rig.device.askedWrench().force.norm(), 1 + 1e-9) << i;
  }
}

TEST(DeviceTwin, AnswersBeforeItExecutes) {
  TwinSettings settings;
  settings.hand = false;
  DeviceTwin twin(g6x3r(), settings);
  DriveCommand pull;
  pull.voltage[0] = 5 * twin.def().strings[0].volt_per_newton;
  const DeviceSample first = twin.exchange(pull);
  EXPECT_EQ(first.counts[0], 0);
  EXPECT_GT(twin.pose().X_BG.p.norm(), 0);
  EXPECT_EQ(twin.latchedPose().X_BG.p.norm(), 0);
}

}  // namespace spidar_test
}  // namespace haptic
