// Encoders that slip while the grip is waved: every string of three devices, 0.5 to 20 mm, at once and over
// 30 and 200 ms. Is the right string named, is it corrected or stopped within 0.5 s, and how much force meets
// a pose that is wrong? Then hours of hard use that must raise no alarm. The oracle is the twin, which knows
// what was done and where the grip is.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "figure.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic::bench {
namespace {

constexpr double kStep = 1e-3;
constexpr double kWrongPose = 2e-3;  // [m]
constexpr int kReactionTicks = 500;  // 0.5 s
constexpr int kSlipsPerString = 12;  // per device and duration
constexpr double kHardHours = 10;

DeviceDef load(const char* name) {
  return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/" + name + ".yaml");
}

struct SlipTally {
  int slips = 0, named = 0, settled = 0;
  double force_on_wrong_pose = 0;  ///< [N]
};

struct Slip {
  int string = 0;
  double size = 0;      ///< [m]
  double duration = 0;  ///< [s]; 0: from one reading to the next
  int at_tick = 0;
};

void wave(const DeviceDef& def, const Slip& slip, SlipTally& tally) {
  TwinSettings settings;
  settings.path = handPath("wave");
  DeviceTwin twin(def, settings);
  Spidar device(def);
  device.calibrateAtHome();
  device.setForceEnabled(true);
  bool settled = false;
  const int last = slip.at_tick + static_cast<int>(slip.duration / kStep) + kReactionTicks;
  for (int k = 0; k < last; ++k) {
    DeviceSample sample = twin.exchange(device.drive());
    if (k >= slip.at_tick) {
      const double share =
          slip.duration > 0 ? std::min(1.0, (k - slip.at_tick + 1) * kStep / slip.duration) : 1;
      sample.counts[slip.string] +=
          std::llround(share * slip.size / def.strings[slip.string].length_per_count);
    }
    device.sense(sample, kStep);
    Wrench F;
    const double t = twin.time();
    F.force = 3 * Vector3(std::sin(3 * t), std::cos(4 * t), std::sin(5 * t));
    device.actuate(F, 0, kStep);
    const double error = (device.pose().p - twin.latchedPose().X_BG.p).norm();
    if (error > kWrongPose)
      tally.force_on_wrong_pose = std::max(tally.force_on_wrong_pose, device.askedWrench().force.norm());
    settled = device.state() == DeviceState::kFault || device.health().corrections() > 0;
  }
  ++tally.slips;
  tally.named += device.suspectString() == slip.string;
  tally.settled += settled;
}

SlipTally slips(double duration) {
  SlipTally tally;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const char* name : {"spidar_g6x3r", "spidar_g6x5r", "spidar_g6x4"}) {
    const DeviceDef def = load(name);
    for (int k = 0; k < kSlipsPerString * static_cast<int>(def.strings.size()); ++k) {
      Slip slip;
      slip.string = k % static_cast<int>(def.strings.size());
      slip.size = 0.5e-3 * std::pow(40.0, unit(random)) * (unit(random) < 0.5 ? -1 : 1);
      slip.duration = duration;
      slip.at_tick = 1500 + static_cast<int>(8000 * unit(random));
      wave(def, slip, tally);
    }
  }
  std::printf(
      "# slips over %3.0f ms: %d, named right %d, corrected or stopped %d, at most %.2f N on a pose wrong by "
      "2 mm\n",
      1e3 * duration, tally.slips, tally.named, tally.settled, tally.force_on_wrong_pose);
  return tally;
}

/// A hand that darts to and fro at up to 2.5 m/s and 200 m/s², against a wall and a force that jumps every 50
/// ms.
int alarmsOfHardUse(double hours) {
  const DeviceDef def = load("spidar_g6x5r");
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  TwinSettings settings;
  settings.hand_stiffness = 800;
  settings.path.keys = {{0, Vector3::Zero(), Vector3::Zero(), 0}, {0.4, Vector3::Zero(), Vector3::Zero(), 0}};
  constexpr double kPathSeconds = 600;
  for (double t = 0.5; t < kPathSeconds - 1; t += 0.06 + 0.25 * std::fabs(unit(random)))
    settings.path.keys.push_back({t, 0.03 * Vector3(unit(random), unit(random), unit(random)),
                                  0.35 * Vector3(unit(random), unit(random), unit(random)), 0});
  settings.path.keys.push_back({kPathSeconds - 0.5, Vector3::Zero(), Vector3::Zero(), 0});  // no jump where it begins again
  const HandPath path = settings.path;
  DeviceTwin twin(def, settings);
  Spidar device(def);
  device.calibrateAtHome();
  device.setForceEnabled(true);
  Wrench noise;
  int alarms = 0;
  bool before = false;
  const long ticks = std::lround(hours * 3600 / kStep), round = std::lround(kPathSeconds / kStep);
  for (long k = 0; k < ticks; ++k) {
    if (k > 0 && k % round == 0) twin.setHandPath(path);
    device.sense(twin.exchange(device.drive()), kStep);
    if (k % 50 == 0) {
      noise.force = 8 * Vector3(unit(random), unit(random), unit(random));
      noise.torque = 0.1 * Vector3(unit(random), unit(random), unit(random));
    }
    Wrench F = noise;
    F.force.z() += std::min(10.0, std::max(0.0, 2000 * (-0.008 - device.pose().p.z())));
    device.actuate(F, 0, kStep);
    const bool now =
        (device.flags() & (kResidualHigh | kEncoderJump | kCountRefused | kStringCorrected)) != 0 ||
        (k > 10 && device.state() != DeviceState::kEnabled);
    alarms += now && !before;
    before = now;
  }
  return alarms;
}

}  // namespace
}  // namespace haptic::bench

int main() {
  using namespace haptic::bench;
  const SlipTally instant = slips(0), quick = slips(0.03), slow = slips(0.2);
  const auto percent = [](int part, int all) { return 100.0 * part / all; };
  figure("faults.named_right_pct", percent(instant.named, instant.slips), "%");
  figure("faults.slip_settled_pct", percent(instant.settled, instant.slips), "%");
  figure("faults.slip_force_on_wrong_pose_n", instant.force_on_wrong_pose, "N");
  figure("faults.named_right_growing_pct", percent(quick.named + slow.named, quick.slips + slow.slips), "%");
  figure("faults.slip_settled_growing_pct", percent(quick.settled + slow.settled, quick.slips + slow.slips),
         "%");
  figure("faults.slip_force_on_wrong_pose_growing_n",
         std::max(quick.force_on_wrong_pose, slow.force_on_wrong_pose), "N");
  figure("faults.string_alarms_per_h", alarmsOfHardUse(kHardHours) / kHardHours, "1/h");
  return 0;
}
