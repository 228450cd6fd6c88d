/// Where the time of a step goes, when somebody wants to know.
#pragma once
#include <chrono>
#include <limits>

namespace haptic {

/// Times of one world step [s]; NaN: not measured.
struct StageTimes {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();  ///< not measured
  double search = kUnknown;     ///< boxes, and which of them overlap
  double detection = kUnknown;  ///< pairs that turned out not to touch
  double volume = kUnknown;     ///< contact volumes and their moments
  double force = kUnknown;      ///< pressure and friction over the patches; an implicit solve with its contacts
  double motion = kUnknown;     ///< hands, bodies, joints, kinematics, ledger
  double total() const { return search + detection + volume + force + motion; }  ///< of the stages
};

/// Adds the time since its last call to a stage. Off, it is one test of a flag; on, it reads the clock (about 25 ns on
/// x86-64, no system call), which it adds to each stage it ends.
class StageClock {
 public:
  bool on = false;  ///< off: the times stay as they are

  /// A step begins: all times are 0.
  void start(StageTimes& times) noexcept {
    if (!on) return;
    times = {0, 0, 0, 0, 0};
    last_ = Clock::now();
  }
  /// Adds the time since the last call.
  void end(double& stage) noexcept {
    if (!on) return;
    const Clock::time_point now = Clock::now();
    stage += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_;
};

}  // namespace haptic
