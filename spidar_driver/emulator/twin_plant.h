/// The device twin behind the emulated boards, with the faults that strings and encoders have.
#pragma once
#include <array>

#include "haptic_core/spidar/device_twin.h"
#include "spidar_driver/emulator/motor_plant.h"

namespace haptic {

class TwinPlant : public MotorPlant {
 public:
  /// The twin's time starts with the first drive, so that a scripted hand waits for the driver.
  TwinPlant(const DeviceDef& device, TwinSettings settings);

  void advance(std::int64_t now_ns) override;
  void drive(int channel, std::int16_t digit) override;
  std::int32_t position(int channel) const override;

  // Faults of one string; they last until `mend`.
  void slacken(int string,
               double metres);        ///< it hangs loose by that much: its count stays ahead, it cannot pull
  void slip(int string, int counts);  ///< its encoder lost step, at once
  void freeze(int string);            ///< it is stuck: its count stands still
  void snap(int string);              ///< it broke: its motor winds it in, it cannot pull
  void mend(int string);              ///< as before the fault; a slipped encoder stays off

  void setHand(const HandPath& path);  ///< starts a scripted motion of the hand now
  const DeviceTwin& twin() const { return twin_; }
  /// What a sound encoder would say.
  std::int64_t trueCount(int string) const { return valid(string) ? counted(string) : 0; }
  const DriveCommand& command() const { return command_; }

 private:
  enum class Condition : unsigned char { kSound, kSlack, kFrozen, kSnapped };
  struct StringFault {
    Condition condition = Condition::kSound;
    std::int64_t offset = 0;  ///< [counts]
    std::int64_t frozen = 0;  ///< [counts]
  };
  bool valid(int string) const {
    return string >= 0 && string < static_cast<int>(twin_.def().strings.size());
  }

  double period_;
  DeviceTwin twin_;
  DriveCommand command_;
  /// The encoder goes on between two steps of the twin: boards are read at instants of their own.
  std::int64_t counted(int string) const;

  static constexpr int kRateSteps = 4;  ///< over which the encoders' rate is taken: a quarter of a count of noise
  DeviceSample sample_;
  std::array<DeviceSample, kRateSteps> past_{};  ///< the samples before, the oldest at past_[steps_ % kRateSteps]
  std::array<StringFault, kMaxStrings> fault_{};
  HandPath hand_;
  double hand_start_ = 0, time_ = 0;
  std::int64_t start_ns_ = 0, last_ns_ = 0, steps_ = 0;
  bool started_ = false, hand_set_ = false;
};

}  // namespace haptic
