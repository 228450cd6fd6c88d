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

/// A device of the twin whose grip is waved while a force goes round, and whose counts may be made false on their way.
struct Waved {
  DeviceTwin twin;
  Spidar device;

  explicit Waved(const DeviceDef& def) : twin(def, waving()), device(def) {
    device.calibrateAtHome();
    device.setForceEnabled(true);
  }
  template <class Falsify>
  void tick(Falsify&& falsify) {
    DeviceSample sample = twin.exchange(device.drive());
    falsify(sample.counts);
    device.sense(sample, kStep);
    Wrench F;
    const double t = twin.time();
    F.force = 3 * Vector3(std::sin(3 * t), std::cos(4 * t), std::sin(5 * t));
    device.actuate(F, 0, kStep);
  }

 private:
  static TwinSettings waving() {
    TwinSettings settings;
    settings.path = handPath("wave");
    return settings;
  }
};

void wave(const DeviceDef& def, const Slip& slip, SlipTally& tally) {
  Waved rig(def);
  const Spidar& device = rig.device;
  bool settled = false;
  const int last = slip.at_tick + static_cast<int>(slip.duration / kStep) + kReactionTicks;
  for (int k = 0; k < last; ++k) {
    rig.tick([&](auto& counts) {
      if (k < slip.at_tick) return;
      const double share = slip.duration > 0 ? std::min(1.0, (k - slip.at_tick + 1) * kStep / slip.duration) : 1;
      counts[slip.string] += std::llround(share * slip.size / def.strings[slip.string].length_per_count);
    });
    const double error = (device.pose().p - rig.twin.latchedPose().X_BG.p).norm();
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

/// What friction makes of a string's counts.
struct Sticky {
  double scale = 1;  ///< of its motion since the fault began
  double slips = 0;  ///< [m]; it stands still until it is off by so much, then it slips to where it belongs
};

/// How long a fault stays without FAULT [ms]: from the first count that is off by more than a quarter of a millimetre, 0 if none ever is;
/// and from the first reading whose lengths contradict each other.
struct Unnamed {
  double off = 0, contradicted = 0;
  bool right = false;  ///< the string is named
};
Unnamed stickyUnnamed(const DeviceDef& def, int string, const Sticky& sticky, int at_tick) {
  constexpr int kPatience = 3000;
  constexpr double kOff = 0.25e-3;  // [m]: nothing is to be seen before
  Waved rig(def);
  const Spidar& device = rig.device;
  const double step = def.strings[static_cast<std::size_t>(string)].length_per_count;
  std::int64_t first = 0, stuck = 0;
  int off_since = 0, contradicted_since = 0;
  for (int k = 0; k < at_tick + kPatience; ++k) {
    rig.tick([&](auto& counts) {
      std::int64_t& count = counts[static_cast<std::size_t>(string)];
      if (k == at_tick) first = stuck = count;
      if (k < at_tick) return;
      const std::int64_t truth = count;
      if (std::fabs(static_cast<double>(truth - stuck) * step) >= sticky.slips) stuck = truth;
      count = sticky.slips > 0 ? stuck : first + std::llround(sticky.scale * static_cast<double>(truth - first));
      if (off_since == 0 && std::fabs(static_cast<double>(truth - count) * step) > kOff) off_since = k;
    });
    if (contradicted_since == 0 && k >= at_tick && device.health().contradicted()) contradicted_since = k;
    if (device.state() != DeviceState::kFault) continue;
    const auto since = [&](int tick) { return tick > 0 ? (k - tick + 1) * kStep * 1e3 : 0; };
    return {since(off_since), since(contradicted_since), device.suspectString() == string};
  }
  return {kPatience, kPatience};
}

void sticky() {
  double worst = 0, worst_contradicted = 0;
  int trials = 0, named = 0;
  for (const char* name : {"spidar_g6x3r", "spidar_g6x5r", "spidar_g6x4"}) {
    const DeviceDef def = load(name);
    for (const Sticky& kind : {Sticky{0.9, 0}, Sticky{1, 1e-3}})
      for (int string = 0; string < static_cast<int>(def.strings.size()); ++string)
        for (int at = 1500; at < 7500; at += 1300) {
          const Unnamed unnamed = stickyUnnamed(def, string, kind, at + 77 * string);
          if (unnamed.off > 300) {
            std::printf("# %s: string %d, scale %.1f, slips %.0f mm, from %d: %.0f ms\n", name, string, kind.scale, 1e3 * kind.slips,
                        at + 77 * string, unnamed.off);
          }
          worst = std::max(worst, unnamed.off);
          worst_contradicted = std::max(worst_contradicted, unnamed.contradicted);
          ++trials;
          named += unnamed.right;
        }
  }
  figure("sticky.trials", trials, "1");
  figure("sticky.named_right_pct", 100.0 * named / trials, "%");
  figure("sticky.named_ms_max", worst, "ms");
  figure("sticky.named_after_contradiction_ms_max", worst_contradicted, "ms");
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

int main(int argc, char**) {
  using namespace haptic::bench;
  sticky();
  if (argc > 1) return 0;  // that alone
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
