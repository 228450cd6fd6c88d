// Every row of the one table of ways back (spidar/ways_back.h): a hand presses a wall, force ends, nobody asks, somebody asks.
#include "haptic_core/spidar/ways_back.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <sstream>

#include "../../scenes/touch.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/spidar/device_record.h"
#include "haptic_core/spidar/device_twin.h"

namespace haptic {
namespace ways_back_test {

constexpr double kPeriod = 1e-3, kBack = 0.8;  // [s], [1]: share of the force before that counts as back
constexpr int kLong = 1500;                    // ticks; the slowest ramp takes half a second, a link is back after 0.3 s
constexpr DeviceSample kNoSample{};

DeviceDef g6x3r() { return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml"); }

/// A relaxed hand (500 N/m) whose target lies 10 mm within a wall of 2 N/mm: 4 N. `wire` changes what a tick of the wire brings.
struct Rig {
  DeviceDef def = g6x3r();
  DeviceTwin twin{def, settings()};
  Spidar device{def};
  World world{scenes::pointerOverWall(makeBox(Vector3::Constant(0.02)), 0.02, 2000 / (0.02 * 0.02), kPeriod)};
  HapticLoop loop{world};
  TickInput input;
  double before = 0, least = 0;  ///< force when it was undisturbed; the least since [N]

  Rig() {
    HandSettings hand;
    hand.workspace.X_WB.p = Vector3(0, 0, 0.02);
    loop.attach(device, 0, hand);
    device.calibrateAtHome();
    device.setForceEnabled(true);
    press(-0.02);
    run(3000);
    before = least = force();
  }
  static TwinSettings settings() {
    TwinSettings s;
    s.period = kPeriod;
    return s;
  }
  void press(double z) {
    HandTarget target;
    target.active = true;
    target.pose.X_BG.p = Vector3(0, 0, z);
    twin.setHandTarget(target);
  }
  double force() const { return device.achievedWrench().force.norm(); }
  void tick(const std::function<void(DeviceSample&)>& wire = {}) {
    input.hands = 1;
    input.sample[0] = twin.exchange(device.driveAfter(input.lost(kPeriod)));
    if (wire) wire(input.sample[0]);
    loop.tick(input, kPeriod);
    ++input.tick;
    input.lost_periods = 0;
    input.asleep = false;
    least = std::min(least, force());
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) tick();
  }
  void lose(int periods) {
    input.lost_periods = periods;
    tick();
  }
  void silent(int ticks) {
    for (int i = 1; i <= ticks; ++i) {
      tick([i](DeviceSample& s) { s.status = LinkStatus::kSilent, s.age_us = static_cast<std::uint32_t>(1000 * i); });
    }
  }
  void letIn(bool silent) {
    HandSettings settings = loop.hand(0).settings();
    settings.silent = silent;
    loop.take({ChangeHand{settings}});
  }
  bool back() const { return force() > kBack * before; }
  std::string said() const { return standing(recordOf(device, 0, 0, kNoSample), "device"); }

  /// What a person does, as the table says.
  void answer(Ask ask) {
    if (ask == Ask::kHold) device.hold(true);
    if (ask == Ask::kGoOn) loop.take({PauseWorld{false}});
    if (ask == Ask::kLetIn) letIn(false);
    if (ask == Ask::kCalibrate) device.calibrateAt(twin.pose()), run(5);
    if (ask == Ask::kCalibrate || ask == Ask::kRecover) device.recover(), run(400);
    if (ask == Ask::kCalibrate || ask == Ask::kRecover || ask == Ask::kEnable) device.setForceEnabled(true);
  }
};

/// What brings this end about, until its own cause is gone. The sender and a hot motor have no world: tests of their own.
void bringAbout(ForceEnd end, Rig& rig) {
  switch (end) {
    case ForceEnd::kLateTick:
      return rig.lose(12);
    case ForceEnd::kInterruption:
      rig.lose(300);
      return rig.silent(300);
    case ForceEnd::kLastingSilence:
      return rig.lose(5000);
    case ForceEnd::kFault:
      return rig.silent(600);
    case ForceEnd::kLengthsLost:
      return rig.tick([](DeviceSample& s) { s.status = LinkStatus::kRestarted; });
    case ForceEnd::kReduced:
      for (int i = 1; i <= 20; ++i) rig.tick([i](DeviceSample& s) { if (i % 5) s.status = LinkStatus::kStale, s.lost = 1; });
      return;
    case ForceEnd::kStop:
      return rig.loop.take({StopDevice{}});
    case ForceEnd::kSwitchedOff:
      return rig.device.setForceEnabled(false);
    case ForceEnd::kDeadMan:
      return rig.device.hold(false);
    case ForceEnd::kCalibration:
      return rig.device.calibrateAt(rig.twin.pose());
    case ForceEnd::kPause:
      return rig.loop.take({PauseWorld{true}});
    case ForceEnd::kOtherWorld:
      return rig.loop.take({RestoreWorld{rig.world.save()}});
    case ForceEnd::kSilentHand:
      return rig.letIn(true);
    case ForceEnd::kSender:
    case ForceEnd::kHot:
    case ForceEnd::kEnds:
      break;
  }
}

class WaysBack : public ::testing::TestWithParam<int> {};

TEST_P(WaysBack, ForceWaitsForWhomTheTableNames) {
  const WayBack& row = kWaysBack[GetParam()];
  ASSERT_EQ(static_cast<int>(row.end), GetParam());
  if (row.end == ForceEnd::kSender || row.end == ForceEnd::kHot) GTEST_SKIP() << "tests of their own";
  Rig rig;
  ASSERT_GT(rig.before, 3) << rig.said();
  bringAbout(row.end, rig);
  rig.run(kLong);
  EXPECT_EQ(rig.back(), row.ask == Ask::kNothing) << row.event << ": " << rig.force() << " of " << rig.before << " N, " << rig.said();
  if (row.end == ForceEnd::kLateTick) { EXPECT_GT(rig.least, kBack * rig.before) << "the force stays"; }
  if (row.end == ForceEnd::kReduced) { EXPECT_LE(rig.force(), 1) << rig.said(); }
  rig.answer(row.ask);
  rig.run(kLong);
  EXPECT_TRUE(rig.back()) << row.event << ": " << rig.force() << " of " << rig.before << " N, " << rig.said();
}
INSTANTIATE_TEST_SUITE_P(All, WaysBack, ::testing::Range(0, static_cast<int>(ForceEnd::kEnds)));

/// 0.5 s is the border, whoever made the silence: this program, the machine, boards, or one after the other.
TEST(WaysBack, HalfASecondIsTheBorderWhoeverMadeTheSilence) {
  for (const bool asleep : {false, true}) {
    for (const int periods : {450, 550, 60000}) {
      Rig rig;
      rig.input.asleep = asleep;
      rig.lose(periods);
      EXPECT_LT(rig.force(), 0.1) << "in the tick that comes after it";
      rig.run(kLong);
      EXPECT_EQ(rig.back(), periods < 500) << periods << ' ' << rig.said();
      EXPECT_EQ((rig.device.flags() & kForceWaits) != 0, periods > 500);
      if (periods < 500) continue;
      EXPECT_EQ(rig.said().find("slept") != std::string::npos, asleep) << rig.said();
      EXPECT_NE(rig.said().find("enable_force"), std::string::npos) << rig.said();
    }
  }
  Rig rig;  // boards and then this program, 0.3 s each: nobody's alone
  rig.silent(300);
  rig.input.lost_periods = 300;
  rig.silent(10);
  rig.run(kLong);
  EXPECT_FALSE(rig.back()) << rig.said();
  EXPECT_EQ(rig.device.state(), DeviceState::kReady) << "no board was silent for half a second: " << rig.said();
}

/// The exchange that comes after a silence already sends zero, and a request of before the silence is not what a person wants now.
TEST(WaysBack, NothingOfBeforeASilenceActsAfterIt) {
  Rig rig;
  rig.input.lost_periods = 60000;
  for (const double volt : rig.device.driveAfter(rig.input.lost(kPeriod)).voltage) EXPECT_EQ(volt, 0);
  rig.device.setForceEnabled(true);
  rig.run(kLong);
  EXPECT_FALSE(rig.back()) << rig.said();
  rig.device.setForceEnabled(true);
  rig.run(kLong);
  EXPECT_TRUE(rig.back()) << rig.said();
}

/// The grip is elsewhere by then: once somebody asks, the pointer glides to it and no body is struck.
TEST(WaysBack, ThePointerGlidesToAGripThatMovedMeanwhile) {
  Rig rig;
  GripPose elsewhere = rig.twin.pose();
  elsewhere.X_BG.p += Vector3(0.03, 0, 0.02);
  rig.twin.place(elsewhere);
  rig.twin.setHandTarget({elsewhere, true});
  const Vector3 from = rig.world.linkPose(1).p;
  rig.lose(5000);
  EXPECT_LT((rig.world.linkPose(1).p - from).norm(), 1e-4);
  rig.run(kLong);
  EXPECT_NEAR((rig.world.linkPose(1).p - rig.loop.report().hand[0].X_WP.p).norm(), 0, 1e-4);
}

TEST(WaysBack, ASilentSenderComesBackByARamp) {
  DeviceTwin twin(g6x3r());
  Spidar device(g6x3r());
  device.calibrateAtHome();
  device.setForceEnabled(true);
  Wrench F;
  F.force.x() = 3;
  const auto run = [&](int ticks, double age) {
    double steepest = 0;
    for (int i = 0; i < ticks; ++i) {
      const double before = device.askedWrench().force.norm();
      device.sense(twin.exchange(device.drive()), kPeriod);
      device.actuate(F, 0, kPeriod, age);
      steepest = std::max(steepest, device.askedWrench().force.norm() - before);
    }
    return steepest;
  };
  run(1000, 0);
  ASSERT_NEAR(device.askedWrench().force.norm(), 3, 1e-9);
  run(200, 0.1);
  EXPECT_EQ(device.askedWrench().force.norm(), 0);
  EXPECT_LE(run(1000, 0), 3 * kPeriod / device.settings().enable_ramp_s * 1.001);
  EXPECT_NEAR(device.askedWrench().force.norm(), 3, 1e-9);
}

TEST(WaysBack, AHotMotorCoolsAndTheForceGrows) {
  DeviceTwin twin(g6x3r());
  SpidarSettings settings;  // small motors
  settings.health.heat_time_s = 1;
  settings.health.hot = 0.02, settings.health.too_hot = 0.04;
  Spidar device(g6x3r(), settings);
  device.calibrateAtHome();
  device.setForceEnabled(true);
  const auto run = [&](double newton, double seconds, bool until_hot) {
    Wrench F;
    F.force.x() = newton;
    for (int i = 0; i < seconds / kPeriod && !(until_hot && (device.flags() & kMotorHot)); ++i) {
      GripPose trembling;  // counters that stand still under force are a fault
      trembling.X_BG.p.x() = 1e-4 * std::sin(0.06 * i);
      twin.place(trembling);
      device.sense(twin.exchange(device.drive()), kPeriod);
      device.actuate(F, 0, kPeriod);
    }
    return device.askedWrench().force.norm();
  };
  run(device.def().max_force, 10, true);
  ASSERT_TRUE(device.flags() & kMotorHot);
  EXPECT_LT(run(device.def().max_force, 2, false), 0.9 * device.def().max_force);
  run(0.5, 5, false);
  EXPECT_NEAR(run(0.5, 1, false), 0.5, 1e-9);
}

/// The README prints the rows, word by word.
TEST(WaysBack, TheReadmeSaysTheSame) {
  std::ifstream file(std::string(HAPTIC_SOURCE_DIR) + "/spidar_driver/README.md");
  std::stringstream text;
  text << file.rdbuf();
  for (const WayBack& row : kWaysBack) {
    const std::string line =
        std::string("\n| ") + row.event + " | " + row.by_itself + " | " + (row.asked[0] ? row.asked : "nothing") + " |\n";
    EXPECT_NE(text.str().find(line), std::string::npos) << line;
  }
}

}  // namespace ways_back_test
}  // namespace haptic
