#include "fault_rig.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/error.h"

namespace haptic::bench {
namespace {

constexpr double kVoltPerDigit = 3.3 / 4096;
constexpr int kSettleTicks = 1500;   // hand home and at rest: 1.5 s
constexpr int kBringUpTicks = 1000;  // to become enabled, with the ramp of 0.5 s
constexpr unsigned kAlarms = kSampleStale | kLinkLost | kEncoderJump | kResidualHigh | kCommandNotFinite;

}  // namespace

FaultRig::FaultRig(const DeviceDef& def) : device(def), plant(def, {}), bus(plant), line(bus), spidar(def) {
  int id = 1;
  for (const std::string& model : device.boards) bus.addBoard(model, id++);
  UartSettings settings;
  settings.reopen_s = 0.001;
  driver = std::make_unique<UartBoards>(device, settings, "memory", [this] {
    if (!line.plugged) throw SetupError("memory", "unplugged", "plug it in");
    return std::make_unique<MemoryLink>(line);
  });
  start_ns_ = line.now_ns;
}

void FaultRig::tick() {
  line.now_ns = std::max(line.now_ns, start_ns_ + ++ticks_ * static_cast<std::int64_t>(kPeriod * 1e9));
  sample = driver->exchange(spidar.drive());
  spidar.sense(sample, kPeriod);
  spidar.actuate(command, 0, kPeriod, command_age);
  checkBounds();
  const LinkReport r = driver->linkReport();
  const std::uint64_t disturbances =
      r.lost + r.late + r.unsound + r.foreign_bytes + r.refused_counts + r.restarts + r.bad_commands;
  alarmed_ = sample.status != LinkStatus::kOk || (spidar.flags() & kAlarms) ||
             disturbances != disturbances_ || spidar.state() == DeviceState::kReduced ||
             spidar.state() == DeviceState::kFault;
  disturbances_ = disturbances;
}

void FaultRig::run(int ticks) {
  for (int k = 0; k < ticks; ++k) tick();
}

/// What the boards drive: all zero, or each string between its tensions; digits are cut towards zero, so one
/// digit below the least tension is that tension.
void FaultRig::checkBounds() {
  if (bus.allCurrentsZero()) return;
  int channel = 0;
  for (const auto& b : bus.boards())
    for (int m = 0; m < b->shape().motors && channel < static_cast<int>(device.strings.size());
         ++m, ++channel) {
      const StringDef& s = device.strings[channel];
      const double tension = b->digit(m) * kVoltPerDigit / s.volt_per_newton;
      const double digit = kVoltPerDigit / std::abs(s.volt_per_newton);
      const bool dead = !b->powered();
      if (!dead && !(tension > s.min_tension - digit && tension < s.max_tension + 1e-9)) ++out_of_bounds_;
    }
}

bool FaultRig::bringUp() {
  command = Wrench{};
  command_age = 0;
  setHand("rest");
  spidar.setForceEnabled(false);
  run(kSettleTicks);
  spidar.recover();
  spidar.calibrateAtHome();
  // A device that believed a wrong pose pulled the grip aside, and the hand that holds it is no rigid jig:
  // with the tensions balanced it goes home, and a second calibration finds it there.
  run(kSettleTicks);
  spidar.calibrateAtHome();
  spidar.setForceEnabled(true);
  for (int k = 0; k < kBringUpTicks; ++k) {
    tick();
    if (enabled() && k > kBringUpTicks / 2) break;
  }
  return enabled() && poseError() < 1e-3;
}

double FaultRig::poseError() const {
  return (spidar.pose().p - plant.twin().pose().X_BG.p).norm();
}

double FaultRig::countError(int string) const {
  const double true_count = static_cast<double>(plant.trueCount(string));
  return std::abs((plant.position(string) - true_count) * device.strings[string].length_per_count);
}

}  // namespace haptic::bench
