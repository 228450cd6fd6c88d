// Encoders that slip, counts that are misread and blows on the grip, for every device that has more strings
// than degrees of freedom. The oracle is the twin: it knows what was done to which string, and where the grip
// is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "haptic_core/spidar/device_record.h"
#include "haptic_core/spidar/device_twin.h"

namespace haptic {
namespace slip_test {

constexpr double kStep = 1e-3;
constexpr double kSlips[] = {0.5e-3, -2e-3, 5e-3, -20e-3};  // [m]

/// Devices whose workspace holds the wave, ±30 mm about home.
std::vector<std::string> redundantDevices() {
  std::vector<std::string> names;
  for (const auto& file :
       std::filesystem::directory_iterator(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices")) {
    if (file.path().extension() != ".yaml") continue;
    const DeviceDef def = loadDevice(file.path());
    double reach = 1;
    for (const StringDef& string : def.strings) reach = std::min(reach, string.p_BE.cwiseAbs().maxCoeff());
    if (static_cast<int>(def.strings.size()) > def.dof && reach > 0.06) names.push_back(file.path().stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// A calibrated, enabled device whose grip is waved; what is done to the counts is added on their way.
struct SlipRig {
  SlipRig(const std::string& name, double exit_error, unsigned seed)
      : device(load(name)), twin(bent(load(name), exit_error, seed), waving()) {
    device.calibrateAtHome();
    device.setForceEnabled(true);
  }
  static DeviceDef load(const std::string& name) {
    return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml");
  }
  static DeviceDef bent(DeviceDef def, double exit_error, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> error(0, exit_error > 0 ? exit_error : 1);
    for (StringDef& string : def.strings)
      for (int c = 0; c < 3 && exit_error > 0; ++c) string.p_BE[c] += error(random);
    return def;
  }
  static TwinSettings waving() {
    TwinSettings settings;
    settings.path = handPath("wave");
    return settings;
  }
  void tick() {
    DeviceSample sample = twin.exchange(device.drive());
    for (int i = 0; i < device.kinematics().strings(); ++i)
      sample.counts[i] += std::llround(offset[i] / device.def().strings[i].length_per_count);
    device.sense(sample, kStep);
    Wrench F;
    const double t = twin.time();
    F.force = 3 * Vector3(std::sin(3 * t), std::cos(4 * t), std::sin(5 * t));
    device.actuate(F, 0, kStep);
    if (poseError() > 2e-3)
      force_on_wrong_pose = std::max(force_on_wrong_pose, device.askedWrench().force.norm());
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) tick();
  }
  double poseError() const { return (device.pose().p - twin.latchedPose().X_BG.p).norm(); }

  Spidar device;
  DeviceTwin twin;
  std::array<double, kMaxStrings> offset{};  ///< measured minus true length [m]
  double force_on_wrong_pose = 0;  ///< largest force presented on a pose wrong by more than 2 mm [N]
};

class Slip : public ::testing::TestWithParam<std::string> {};

TEST_P(Slip, OfAnInstantIsNamedAndCorrected) {
  int named = 0, all = 0;
  for (const double exit_error : {0.0, 50e-6}) {
    for (int string = 0; string < static_cast<int>(SlipRig::load(GetParam()).strings.size()); ++string) {
      SlipRig rig(GetParam(), exit_error, 1 + static_cast<unsigned>(string));
      rig.run(3000 + 100 * string);
      ASSERT_EQ(rig.device.state(), DeviceState::kEnabled);
      const double before = rig.poseError();
      rig.offset[string] = kSlips[string % 4];
      rig.run(500);
      ++all;
      named += rig.device.suspectString() == string;
      EXPECT_LE(rig.force_on_wrong_pose, rig.device.settings().reduced_force);
      const bool right = rig.device.state() == DeviceState::kEnabled && rig.poseError() < before + 0.4e-3;
      EXPECT_TRUE(right || rig.device.state() == DeviceState::kFault) << string;
      if (right && rig.device.suspectString() == string) {
        // The estimate is as good as the motion is smooth: 100 m/s² over one tick, and some encoder steps.
        EXPECT_NEAR(rig.device.health().suspectError(), rig.offset[string], 0.3e-3);
        EXPECT_NE(
            advice(recordOf(rig.device, 0, 0, {}), "").find("string " + std::to_string(string) + " slipped"),
            std::string::npos);
      }
    }
  }
  EXPECT_GE(named, 0.95 * all) << named << " of " << all;
}

TEST_P(Slip, ThatGrowsIsNamedAndEndsInAFault) {
  int named = 0, all = 0;
  const DeviceDef def = SlipRig::load(GetParam());
  if (static_cast<int>(def.strings.size()) < def.dof + 2)
    return;  // one redundant string tells that, not always which
  for (int string = 0; string < static_cast<int>(def.strings.size()); ++string) {
    SlipRig rig(GetParam(), 0, 1);
    rig.run(3000 + 100 * string);
    const double slip = string % 2 ? 4e-3 : -8e-3;
    for (int k = 1; k <= 100; ++k) {
      rig.offset[string] = slip * k / 100;
      rig.tick();
    }
    rig.run(400);
    EXPECT_EQ(rig.device.state(), DeviceState::kFault) << string;
    const std::uint32_t suspects = rig.device.health().suspects();
    EXPECT_TRUE(suspects >> string & 1u) << string << " is not among " << suspects;
    ++all;
    named += rig.device.suspectString() == string;
  }
  EXPECT_GE(named, 0.75 * all) << named << " of "
                               << all;  // some pairs stay nearly parallel for half a second
}

/// From the reading that contradicts itself, before anybody knows which string it is, or whether it is a fault at all: the force falls by
/// the device's own rate, and no further than to what a doubtful device may give.
TEST_P(Slip, LimitsTheForceWithTheFirstContradiction) {
  const int strings = static_cast<int>(SlipRig::load(GetParam()).strings.size());
  for (int string = 0; string < strings; ++string) {
    SlipRig rig(GetParam(), 0, 1);
    rig.run(3000 + 100 * string);
    int contradictions = 0;
    for (int k = 0; k < 100; ++k) {
      const double before = rig.device.gain();
      rig.offset[string] += 0.1e-3;  // below what is a jump
      rig.tick();
      if (!(rig.device.solution().residual > rig.device.settings().health.residual_limit)) continue;
      ++contradictions;
      const SpidarSettings& settings = rig.device.settings();
      const double most = rig.device.def().max_force, fall = settings.release_rate / most * kStep;
      EXPECT_LE(rig.device.gain(), std::max(settings.reduced_force / most, before - fall) + 1e-12) << string << " " << k;
    }
    EXPECT_GT(contradictions, 0) << string;
  }
}

TEST_P(Slip, AMisreadCountNeverBecomesAPose) {
  SlipRig rig(GetParam(), 0, 1);
  std::mt19937 random(5);
  rig.run(2000);
  for (int k = 0; k < 200; ++k) {
    const int string = static_cast<int>(random() % rig.device.def().strings.size());
    rig.offset[string] = (random() % 2 ? 1 : -1) * (0.6e-3 + 1e-6 * static_cast<double>(random() % 9000));
    rig.tick();
    EXPECT_TRUE(rig.device.flags() & kCountRefused) << k;
    EXPECT_LT(rig.poseError(), 0.5e-3) << k;
    rig.offset[string] = 0;
    rig.run(3 + static_cast<int>(random() % 10));
    ASSERT_EQ(rig.device.state(), DeviceState::kEnabled);
    ASSERT_EQ(rig.device.health().corrections(), 0);
  }
}

std::string plain(const ::testing::TestParamInfo<std::string>& info) {
  return info.param;
}
INSTANTIATE_TEST_SUITE_P(Devices, Slip, ::testing::ValuesIn(redundantDevices()), plain);

TEST(CountScreen, ABlowOnTheGripIsAMotion) {
  // The speed changes by up to 2 m/s from one reading to the next: 2000 m/s². Lengths in closed form, as
  // encoders give them.
  const DeviceDef def = SlipRig::load("spidar_g6x3r");
  const StringKinematics kinematics(def);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int blow = 0; blow < 500; ++blow) {
    CountScreen screen(def, {});
    const Vector3 start = 0.02 * Vector3(unit(random), unit(random), unit(random));
    const Vector3 before = 0.3 * Vector3(unit(random), unit(random), unit(random));
    const Vector3 change =
        (0.3 + unit(random) * unit(random)) * Vector3(unit(random), unit(random), unit(random));
    for (int k = 0; k < 20; ++k) {
      GripPose pose;
      pose.X_BG.p = start + before * (kStep * k) + change * (kStep * std::max(0, k - 10));
      StringVector length = kinematics.lengths(pose);
      for (int i = 0; i < 8; ++i) {
        const double step = def.strings[i].length_per_count;
        length[i] = step * std::round(length[i] / step);
      }
      const CountScreen::Verdict verdict = screen.judge(length, kinematics, pose, kStep);
      ASSERT_NE(verdict, CountScreen::Verdict::kSlipped) << blow << " at " << k;
      ASSERT_NE(verdict, CountScreen::Verdict::kLost) << blow << " at " << k;
    }
  }
}

/// A slip is corrected, and so is another one of that string later on; where the two lie within a second, the string sticks.
TEST(CountScreen, TwoSlipsOfAStringWithinASecondAreAStringThatSticks) {
  for (const int ticks_between : {150, 1500}) {
    SlipRig rig("spidar_g6x5r", 0, 1);
    rig.run(2000);
    rig.offset[4] = 2e-3;
    rig.run(ticks_between);
    ASSERT_NE(rig.device.state(), DeviceState::kFault) << ticks_between;
    ASSERT_EQ(rig.device.health().corrections(), 1) << ticks_between;
    rig.offset[4] = 4e-3;
    rig.run(20);
    EXPECT_EQ(rig.device.state() == DeviceState::kFault, ticks_between < 1000) << ticks_between;
    EXPECT_EQ(rig.device.suspectString(), 4) << ticks_between;
  }
}

TEST(CountScreen, TheFourthSlipIsAFault) {
  SlipRig rig("spidar_g6x3r", 0, 1);
  rig.run(2000);
  for (int k = 0; k < 3; ++k) {
    rig.offset[2] += 2e-3;
    rig.run(1100);
    ASSERT_EQ(rig.device.state(), DeviceState::kEnabled);
  }
  rig.offset[2] += 2e-3;
  rig.run(5);
  EXPECT_EQ(rig.device.state(), DeviceState::kFault);
  EXPECT_EQ(rig.device.suspectString(), 2);
}

TEST(CountScreen, ACounterThatRunsWildIsNamed) {
  SlipRig rig("spidar_g6x3r", 0, 1);
  std::mt19937 random(2);
  rig.run(2000);
  for (int k = 0; k < 6; ++k) {
    rig.offset[5] = 1e-6 * static_cast<double>(random() % 20000);
    rig.tick();
  }
  EXPECT_EQ(rig.device.state(), DeviceState::kFault);
  EXPECT_FALSE(rig.device.calibrated());
  EXPECT_EQ(rig.device.suspectString(), 5);
}

}  // namespace slip_test
}  // namespace haptic
