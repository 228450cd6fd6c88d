// How soon broken strings, slipped encoders and silent boards are noticed: faults of the twin, at random
// instants of a waved grip; then an undisturbed run that must raise no alarm; then commands that must not
// leave the bounds.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <string>

#include "fault_tally.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"

namespace {

using namespace haptic;

constexpr double kStep = 1e-3;

struct Rig {
  Spidar device;
  DeviceTwin twin;
  long out_of_bounds = 0;

  static TwinSettings waving() {
    TwinSettings settings;
    settings.path = handPath("wave");
    // One wave after the other, without a pause.
    const HandPath once = settings.path;
    for (int round = 1; round < 200; ++round)
      for (HandKey key : once.keys) {
        key.time += round * once.duration() + 1e-9;
        settings.path.keys.push_back(key);
      }
    return settings;
  }

  explicit Rig(const DeviceDef& def) : device(def), twin(def, waving()) {
    device.calibrateAtHome();
    device.setForceEnabled(true);
  }

  void tick(const Wrench& F = {}, double age = 0) {
    device.sense(twin.exchange(device.drive()), kStep);
    device.actuate(F, 0, kStep, age);
    for (int i = 0; i < device.kinematics().strings(); ++i) {
      const StringDef& s = device.def().strings[i];
      const double tension = device.drive().voltage[i] / s.volt_per_newton;
      const bool off = device.drive().voltage[i] == 0;  // zero current after a lost link
      out_of_bounds +=
          !off && !(tension >= s.min_tension * (1 - 1e-12) && tension <= s.max_tension * (1 + 1e-12));
    }
  }
};

Wrench pushing(double time) {
  Wrench F;
  F.force = 2 * Vector3(std::sin(3 * time), std::cos(4 * time), std::sin(5 * time));
  return F;
}

struct Kind {
  TwinFaultKind kind;
  double size;
  const char* name;
};

}  // namespace

haptic::bench::FaultTally haptic::bench::twinFaults() {
  const DeviceDef def = loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml");
  const Kind kinds[] = {{TwinFaultKind::kSlip, 3e-3, "slip 3 mm"},
                        {TwinFaultKind::kSlack, 5e-3, "slack 5 mm"},
                        {TwinFaultKind::kStuck, 0, "stuck drum"},
                        {TwinFaultKind::kBreak, 5, "break, wound in at 5 m/s"},
                        {TwinFaultKind::kJump, 0.1, "counter jumps 0.1 m"},
                        {TwinFaultKind::kSilence, 0, "board silent"}};
  constexpr int kPerKind = 80, kPatience = 2000;
  int injected = 0, detected = 0, recovered = 0, idle = 0;
  long out_of_bounds = 0;
  std::vector<double> delays;
  std::mt19937 random(1);
  Rig rig(def);
  for (const Kind& kind : kinds) {
    std::vector<double> of_kind;
    for (int trial = 0; trial < kPerKind; ++trial) {
      const int quiet = 600 + static_cast<int>(random() % 500);
      for (int i = 0; i < quiet; ++i) rig.tick(pushing(rig.twin.time()));
      if (rig.device.state() != DeviceState::kEnabled) {
        ++idle;
        continue;
      }
      rig.twin.inject({kind.kind, static_cast<int>(random() % 8), kind.size});
      ++injected;
      int ticks = 0;
      const auto noticed = [&rig] {  // a slip that is corrected is named, and said until the next calibration
        return rig.device.state() != DeviceState::kEnabled || (rig.device.flags() & kStringCorrected);
      };
      for (; ticks < kPatience && !noticed(); ++ticks) rig.tick(pushing(rig.twin.time()));
      if (noticed()) {
        ++detected;
        of_kind.push_back(ticks * kStep * 1e3);
      }
      for (int i = 0; i < 50; ++i) rig.tick(pushing(rig.twin.time()));
      // Repair: the user mends the string, puts the grip into the jig, recovers and calibrates.
      rig.twin.repair();
      rig.device.recover();
      rig.device.setForceEnabled(true);
      rig.device.calibrateAt(rig.twin.pose());
      for (int i = 0; i < 5; ++i) rig.tick();
      const double error = (rig.device.pose().p - rig.twin.latchedPose().X_BG.p).norm();
      recovered += rig.device.state() == DeviceState::kEnabled && error < 1e-4;
    }
    delays.insert(delays.end(), of_kind.begin(), of_kind.end());
    std::sort(of_kind.begin(), of_kind.end());
    const std::size_t n = of_kind.size();
    std::printf("# %-26s %2zu of %d noticed, median %.0f ms, longest %.0f ms\n", kind.name, n, kPerKind,
                n ? of_kind[n / 2] : 0, n ? of_kind[n - 1] : 0);
  }
  out_of_bounds += rig.out_of_bounds;

  Rig quiet(def);
  constexpr double kQuietHours = 9.5;
  long alarms = 0;
  for (long i = 0; i < static_cast<long>(kQuietHours * 3600 / kStep); ++i) {
    quiet.tick(pushing(quiet.twin.time()));
    alarms +=
        (quiet.device.flags() & (kResidualHigh | kEncoderJump | kLinkLost | kMotorHot | kOverRate)) != 0;
  }
  out_of_bounds += quiet.out_of_bounds;

  // Whatever comes in: NaN, infinities, 1e30, alternating signs, commands of any age.
  Rig abused(def);
  const double inf = std::numeric_limits<double>::infinity();
  const double values[] = {0, 1e30, -1e30, inf, -inf, std::nan(""), 1e-300, 8, -8};
  for (int i = 0; i < 100000; ++i) {
    Wrench F;
    for (int c = 0; c < 3; ++c) {
      F.force[c] = values[random() % 9];
      F.torque[c] = values[random() % 9];
    }
    abused.tick(F, std::fabs(values[random() % 9]) * 0.01);
  }
  out_of_bounds += abused.out_of_bounds;

  FaultTally tally;
  tally.injected = injected;
  tally.detected = detected;
  tally.recovered = recovered;
  tally.idle = idle;
  tally.missed = injected - detected;
  tally.detect_ms = delays;
  tally.out_of_bounds = out_of_bounds;
  tally.alarms = alarms;
  tally.quiet_hours = kQuietHours;
  return tally;
}
