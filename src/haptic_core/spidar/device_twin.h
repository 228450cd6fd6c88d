/// A SPIDAR in software, behind the same `exchange` as the hardware: encoders, motors, strings, grip and
/// hand.
#pragma once
#include "haptic_core/base/latest_value.h"
#include "haptic_core/spidar/hand_path.h"
#include "haptic_core/spidar/string_kinematics.h"
#include "haptic_core/spidar/transport.h"
#include "haptic_core/spidar/wall_bound.h"

namespace haptic {

/// How a simulated device behaves: its time, motors and hand.
struct TwinSettings {
  double period = 1e-3;            ///< simulated time per exchange [s]
  int substeps = 10;               ///< semi-implicit Euler steps per exchange; 0.1 ms resolves 1 kHz dynamics
  double motor_time_constant = 0;  ///< first-order lag of the tension [s]; 0: ideal motors
  bool hand = true;                ///< false: no hand holds the grip
  double hand_stiffness = 500;     ///< [N/m], a relaxed hand
  double hand_damping = kRelaxedHandDamping;         ///< [N·s/m]
  double hand_rotational_stiffness = 1.5;  ///< [N·m/rad]
  double hand_rotational_damping = 0.01;   ///< [N·m·s/rad]
  double gravity = 0;                      ///< on the grip, along -z of B [m/s²]; 0: the hand carries it
  std::int64_t first_count = 0;            ///< counters are relative: their value at the home pose
  HandPath path;                           ///< empty: rests at home
};

/// Where the hand wants the grip, from outside (an rviz marker). `active` false gives the hand back to the
/// path.
struct HandTarget {
  GripPose pose;        ///< of the grip, in B
  bool active = false;  ///< false: the path holds
};

/// Faults that the twin can simulate.
enum class TwinFaultKind : unsigned char {
  kSlack,    ///< the string sags: it measures up to `size` [m] too long within 50 ms and pulls nothing
  kSlip,     ///< the encoder slips by `size` [m]
  kStuck,    ///< the drum is stuck: the counter stands still
  kBreak,    ///< the string snaps: no pull, and the motor winds it in at `size` [m/s]
  kJump,     ///< the counter jumps by `size` [m]
  kSilence,  ///< the board does not answer
};

/// A fault that a simulated device can have.
struct TwinFault {
  TwinFaultKind kind = TwinFaultKind::kSlip;  ///< what breaks
  int string = 0;                             ///< index; of kSilence any string of the board
  double size = 0;                            ///< [m], or [m/s] for kBreak; of the others not read
};

/// A simulated SPIDAR: encoders, motors, strings, grip and hand.
/// Deterministic: the same commands give the same bits. Like the boards, an exchange answers before it
/// executes: the counts are latched, then the new command acts over one period.
class DeviceTwin : public Transport {
 public:
  /// At rest at home; throws SetupError for settings out of range.
  explicit DeviceTwin(const DeviceDef& def, const TwinSettings& settings = {});

  DeviceSample exchange(const DriveCommand& command) noexcept override;  ///< (in realtime)
  void zeroDrive() noexcept override { command_ = DriveCommand{}; }
  double maxRateHz() const override { return 1 / settings_.period; }
  const Pose* truth() const noexcept override { return &latched_.X_BG; }

  void setHandTarget(const HandTarget& target) noexcept {
    target_.write(target);
  }  ///< one other thread may call it

  /// Gives the hand a new script that begins now. For the thread that exchanges, between two exchanges; allocates.
  void setHandPath(const HandPath& path) {
    settings_.path = path;
    path_start_ = static_cast<double>(ticks_) * settings_.period;
  }

  // Truth. `latched` belongs to the counts of the last exchange, the rest to the end of its period.
  /// Of the grip, at the last latch of counts.
  const GripPose& latchedPose() const noexcept { return latched_; }
  const GripPose& pose() const noexcept { return grip_; }             ///< of the grip, now
  const Twist& twist() const noexcept { return V_BG_; }               ///< at G's origin, in B
  /// Mean wrench of the strings on the grip over the last period, at G's origin, in B.
  const Wrench& stringWrench() const noexcept { return string_wrench_; }
  const Wrench& handWrench() const noexcept { return hand_wrench_; }  ///< of the hand on the grip, likewise
  double time() const noexcept { return time_; }                      ///< [s]
  const DeviceDef& def() const noexcept { return def_; }              ///< the device it stands for

  /// Breaks something from the next exchange on; one fault at a time.
  void inject(const TwinFault& fault) noexcept;
  /// (in realtime) The fault is gone from the next exchange on; the counts are true again.
  void repair() noexcept { faulty_ = false; }

  /// Puts the grip somewhere, at rest (tests).
  void place(const GripPose& pose) noexcept;

 private:
  void latch(DeviceSample& sample) noexcept;
  void latchFault(DeviceSample& sample) noexcept;
  bool pulls(int string) const noexcept;
  void substep(double h) noexcept;
  Wrench handForce(double time, double& on_opening) noexcept;

  DeviceDef def_;
  TwinSettings settings_;
  StringKinematics kinematics_;
  StringVector home_length_, tension_;
  LatestValue<HandTarget> target_;
  HandTarget taken_target_;
  GripPose grip_, latched_;
  Twist V_BG_;
  double opening_rate_ = 0, time_ = 0, path_start_ = 0, inertia_ = 0;
  std::uint64_t ticks_ = 0;
  Wrench string_wrench_, hand_wrench_;
  DriveCommand command_;
  TwinFault fault_;
  bool faulty_ = false;
  double fault_time_ = 0;
  DeviceSample answered_;         ///< the last one
  std::int64_t fault_count_ = 0;  ///< of the faulty string when it broke
};

}  // namespace haptic
