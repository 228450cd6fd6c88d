#include "spidar_driver/emulator/twin_plant.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kVoltPerDigit = 3.3 / 4096;  // current-sense ADC, as in the boards
constexpr double kWindSpeed = 2.0;            // of a motor whose string broke [m/s]
constexpr double kMaxPeriod = 2.5e-4;  // step of the twin [s]: counts no older than a quarter of a tick
// After a pause of the process the twin does not run after the clock for longer than this [s].
constexpr double kMaxCatchUp = 0.1;

TwinSettings fineSteps(TwinSettings settings) {
  settings.period = std::min(settings.period, kMaxPeriod);
  settings.substeps = 3;  // below 0.1 ms, as the twin's own default
  return settings;
}

}  // namespace

TwinPlant::TwinPlant(const DeviceDef& device, TwinSettings settings)
    : period_(fineSteps(settings).period), twin_(device, fineSteps(settings)) {
  sample_ = twin_.exchange(command_);
}

void TwinPlant::advance(std::int64_t now_ns) {
  last_ns_ = now_ns;
  if (!started_) return;
  const double behind =
      static_cast<double>(now_ns - start_ns_) * 1e-9 - static_cast<double>(steps_) * period_;
  if (behind > kMaxCatchUp) start_ns_ = now_ns - static_cast<std::int64_t>(steps_ * period_ * 1e9);
  while (static_cast<double>(now_ns - start_ns_) * 1e-9 >= static_cast<double>(steps_ + 1) * period_) {
    ++steps_;
    time_ += period_;
    DriveCommand acting = command_;
    for (std::size_t i = 0; i < twin_.def().strings.size(); ++i) {
      StringFault& f = fault_[i];
      if (f.condition == Condition::kSlack || f.condition == Condition::kSnapped) acting.voltage[i] = 0;
      if (f.condition == Condition::kSnapped)
        f.offset -= std::llround(kWindSpeed * period_ / twin_.def().strings[i].length_per_count);
    }
    if (hand_set_) twin_.setHandTarget({hand_.at(time_ - hand_start_), true});
    past_[static_cast<std::size_t>(steps_ % kRateSteps)] = sample_;
    sample_ = twin_.exchange(acting);
  }
}

std::int64_t TwinPlant::counted(int string) const {
  if (steps_ < kRateSteps) return sample_.counts[string];
  const DeviceSample& oldest = past_[static_cast<std::size_t>((steps_ + 1) % kRateSteps)];
  const double since = static_cast<double>(last_ns_ - start_ns_) * 1e-9 / period_ - static_cast<double>(steps_);
  const double moved = static_cast<double>(sample_.counts[string] - oldest.counts[string]) / kRateSteps;
  return sample_.counts[string] + std::llround(moved * std::clamp(since, 0.0, 1.0));
}

void TwinPlant::drive(int channel, std::int16_t digit) {
  if (!valid(channel)) return;
  if (!started_ && digit != 0) {
    started_ = true;
    start_ns_ = last_ns_;
  }
  command_.voltage[channel] = digit * kVoltPerDigit;
}

std::int32_t TwinPlant::position(int channel) const {
  if (!valid(channel)) return 0;
  const StringFault& f = fault_[channel];
  return static_cast<std::int32_t>(f.condition == Condition::kFrozen ? f.frozen
                                                                     : counted(channel) + f.offset);
}

void TwinPlant::slacken(int string, double metres) {
  if (!valid(string)) return;
  fault_[string].condition = Condition::kSlack;
  fault_[string].offset += std::llround(metres / twin_.def().strings[string].length_per_count);
}

void TwinPlant::slip(int string, int counts) {
  if (valid(string)) fault_[string].offset += counts;
}

void TwinPlant::freeze(int string) {
  if (!valid(string)) return;
  fault_[string].frozen = position(string);
  fault_[string].condition = Condition::kFrozen;
}

void TwinPlant::snap(int string) {
  if (valid(string)) fault_[string].condition = Condition::kSnapped;
}

void TwinPlant::mend(int string) {
  if (!valid(string)) return;
  StringFault& f = fault_[string];
  if (f.condition != Condition::kSound) f.offset = 0;
  f.condition = Condition::kSound;
}

void TwinPlant::setHand(const HandPath& path) {
  hand_ = path;
  hand_start_ = time_;
  hand_set_ = true;
}

}  // namespace haptic
