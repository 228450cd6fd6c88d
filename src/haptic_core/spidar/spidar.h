/// One device: encoder counts in, grip pose and twist out; wrench in, drive voltages out.
///
/// Per tick: `sense` (freshness → counts → lengths → pose → twist, health), then `actuate`, which is `admit` (NaN gate, clamps, age;
/// one gain on the whole wrench; one law of change, force_slew.h) and `present` (tension distribution → clamp and rate limit per string
/// → volts). All are real-time; no step is skipped by any state, so the drive is defined for whatever comes in. The invariant that ties
/// force to counts: freshness.h.
/// `sense` only gathers evidence; one table gives the cause and its consequence for the force: device_diagnosis.h.
#pragma once
#include <vector>

#include "haptic_core/base/decay.h"
#include "haptic_core/spidar/calibration.h"
#include "haptic_core/spidar/device_diagnosis.h"
#include "haptic_core/spidar/device_requests.h"
#include "haptic_core/spidar/force_slew.h"
#include "haptic_core/spidar/freshness.h"
#include "haptic_core/spidar/loop_clock.h"
#include "haptic_core/spidar/steady_lengths.h"
#include "haptic_core/spidar/still_counters.h"
#include "haptic_core/spidar/string_health.h"
#include "haptic_core/spidar/string_kinematics.h"
#include "haptic_core/spidar/tension_distribution.h"
#include "haptic_core/spidar/transport.h"

namespace haptic {

/// State of the device: it decides which forces are allowed.
enum class DeviceState : unsigned char {
  kUncalibrated,  ///< lengths unknown: minimum tension, no pose
  kReady,         ///< pose valid, minimum tension
  kEnabled,       ///< presents the wrench
  kReduced,       ///< a string is doubtful: presents at most `reduced_force`
  kFault,         ///< no force until `recover`: balanced least tensions where the pose is sound, else zero current
};

const char* toString(DeviceState state);  ///< the state in words

/// Settings of a device that its file does not state.
struct SpidarSettings {
  /// First-order low-pass of the twist; delay 1/(2π f) = 0.8 ms. At 80 Hz, 2 ms, dampers of the size that a loop bears at its stiffest
  /// wall leave a swing of 55 Hz 0.11 of critical damping, at 200 Hz 0.17. One count at 1 kHz is 12 mm/s in it, 0.07 N of such a damper.
  double velocity_cutoff_hz = 200;
  double enable_ramp_s = 0.5;  ///< the gain rises to 1 in this time after enabling, so that the wrench does not hit the hand
  double force_slew = 2000;    ///< ρ of wrenches that come by topic [N/s]: 10 N in 5 ms, for who renders vibrations
  double torque_slew = 60;     ///< the same of torques [N·m/s]; over `force_slew` the reach of the law
  /// At most so fast the gain takes force away [N/s], as the loop's own ρ (kForceRate of world/hand_bound.h): 0.1 N in a tick of 1 kHz
  /// is a third of the least that is felt as a stroke, and 10 N are gone after 0.1 s.
  double release_rate = 100;
  double command_age_limit_s = 0.03;  ///< an older wrench decays: its sender died or hangs
  double command_decay_s = 0.02;      ///< from the age limit to minimum tension
  double tension_slew = 5000;         ///< rise of one string's tension per second [N/s], beside the clamp: whatever
                                      ///< goes wrong above, 10 N take 2 ms. Falling is not limited
  double reduced_force = 1;           ///< greatest force in state kReduced [N]: the gain is its share of the greatest force
  bool refuse_over_rate = false;      ///< true on hardware: a rate above the wire's is a fault, not a remark
  HealthSettings health;              ///< of strings and motors
  FreshnessSettings freshness;        ///< of counts
};

/// One SPIDAR, real or simulated: encoder counts to grip pose, wrench to motor voltages.
class Spidar {
 public:
  /// Uncalibrated, with the force off.
  explicit Spidar(const DeviceDef& def, const SpidarSettings& settings = {});

  /// (in realtime) Takes the counts of one exchange, and follows the requests; h [s] is the period of the exchanges, `lost` the time
  /// beyond it in which the runner made none.
  void sense(const DeviceSample& sample, double h, const TimeLost& lost = {}) noexcept;
  /// (in realtime) The wrench on the hand at G's origin in B that may be presented where `F_G_B` is asked for: within the limits, times
  /// the gain, no faster than `slew` lets it change for a grip that `moved` since the last sample. `command_age` [s]: of what is asked.
  Wrench admit(const Wrench& F_G_B, const ForceSlew& slew, const Twist& moved, double h, double command_age = 0) noexcept;
  /// (in realtime) Makes the drive for the next exchange; `F_G_B` as `admit` gave it, with a damper's force perhaps: a wrench beyond what
  /// is allowed now only falls. Grasp force along the opening [N].
  void present(const Wrench& F_G_B, double grasp_force, double h) noexcept;
  /// (in realtime) Both, for a wrench that comes from elsewhere: by the law of the device's own rates.
  void actuate(const Wrench& F_G_B, double grasp_force, double h, double command_age = 0) noexcept;
  /// (in realtime) What is asked for is another thing from now on (another world, a pause's end): the gain begins at 0 and rises to 1
  /// within `seconds`, or in the time of a ramp that is not over yet. What is presented goes there by the law.
  void beginAnew(double seconds) noexcept;
  bool presses() const noexcept;                  ///< (in realtime) it presents more than a hand feels (0.05 N)
  double gain() const noexcept { return gain_; }  ///< s, of the last `admit`
  Wrench withinLimits(Wrench F_G_B) const noexcept;  ///< (in realtime) shortened to the limits that are tuned now
  const DriveCommand& drive() const noexcept { return drive_; }  ///< made by the last `actuate`; zero before
  /// (in realtime) For an exchange that comes after time was lost: zero where the force has to wait for a person who asks, for the
  /// command in the making is of before.
  const DriveCommand& driveAfter(const TimeLost& lost) const noexcept {
    return lost.seconds > LoopClock::kLasting ? kNoDrive : drive_;
  }
  /// Between two ticks: another runner ticks the device from now on. The time until its first tick is nobody's silence.
  void handOver() noexcept { clock_.handOver(); }

  // Set-up, or between two ticks: requests that the next `sense` follows, beside earlier ones. A calibration waits for
  // fresh counts of every board. Other threads send an AskDevice (loop/command.h).
  void ask(const DeviceRequests& requests) noexcept;  ///< (in realtime)
  void calibrateAtHome() noexcept { calibrateAt(GripPose{}); }  ///< the grip is held at B's origin, unrotated
  void calibrateAt(const GripPose& jig) noexcept { ask({true, false, -1, jig}); }  ///< a jig holds the grip there
  /// From the next tick on; true begins with a ramp.
  void setForceEnabled(bool enabled) noexcept { ask({false, false, enabled ? 1 : 0, {}}); }
  /// Leaves kFault and kReduced when the cause is gone, with the force off: `setForceEnabled` switches it on.
  void recover() noexcept { ask({false, true, -1, {}}); }
  /// (in realtime) STOP: the force is off and the current zero from the next exchange on, until somebody asks for `recover` or for
  /// force. Between two ticks.
  void stop() noexcept;
  /// (in realtime) The dead-man switch; force is on only while it is held. Held until something else is told. Between two ticks.
  void hold(bool held) noexcept { held_ = held; }
  /// (in realtime) Takes back the requests that the next `sense` would follow on this sample: recordings `ask` them again by name.
  DeviceRequests takeRequests(const DeviceSample& sample) noexcept;

  /// Set-up, or between two ticks: the exits of a calibration replace the file's, and its lengths at count 0 become
  /// the device's; the pose starts at `guess`. Allocates. Throws SetupError when it is one for another device.
  void adopt(const Calibration& calibration, const GripPose& guess);

  /// Set-up: lengths at count 0 [m] from a saved calibration, valid while the counters have not been reset.
  /// The pose starts at `guess`.
  void restoreCalibration(const StringVector& zero_length, const GripPose& guess = {}) noexcept;

  /// Complete memory, for recordings: `restore` of it makes this device or another of the same description go on
  /// bit for bit. Between two ticks; `save` allocates unless `out` has room. `restore` throws SetupError when it is of
  /// another device.
  std::vector<double> save() const;
  void save(std::vector<double>& out) const;        ///< appends to `out`
  void restore(const std::vector<double>& memory);  ///< see `save`

  /// What evolves from tick to tick, each field once: saved, restored and compared by base/fields.h. Beside it the memory has
  /// the exits that a calibration may have moved, λ and the active set of the tensions.
  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.max_force_), visit(s.max_torque_), visit(s.state_), visit(s.calibrated_), visit(s.zero_current_), visit(s.enabled_);
    visit(s.held_), visit(s.stopped_);
    visit(s.opening_rate_), visit(s.gain_), visit(s.rise_s_), visit(s.grasp_), visit(s.heat_share_);
    visit(s.since_counts_), visit(s.since_pose_);
    visit(s.pose_stamp_ns_), visit(s.cause_), visit(s.cause_flags_);  // the stamp is whole up to 2^53 ns, 104 days
    visit(s.late_s_), visit(s.absence_s_), visit(s.waits_), visit(s.asleep_);
    visit(s.still_strings_), visit(s.refusal_), visit(s.doubted_), visit(s.interrupted_), visit(s.counts_stamp_ns_);
    visit(s.zero_length_), visit(s.length_), visit(s.told_), visit(s.solution_), visit(s.twist_), visit(s.asked_), visit(s.wanted_);
    visit(s.achieved_);
    visit(s.health_), visit(s.freshness_), visit(s.still_), visit(s.clock_), visit(s.steady_lengths_), visit(s.steady_);
  }

  /// Limits and λ that may change while running, within the device file's own. Between two ticks.
  struct Tuning {
    double lambda = 0;      ///< of the device's rule [1]: TensionDistribution::ruleLambda
    double max_force = 0;   ///< [N], at most the file's
    double max_torque = 0;  ///< [N·m], at most the file's
  };
  Tuning tuning() const { return {distribution_.ruleLambda(), max_force_, max_torque_}; }  ///< as it is now
  void tune(const Tuning& tuning);  ///< throws SetupError naming value and bounds

  // Results of the last tick; the same thread as `sense`.
  DeviceState state() const noexcept { return state_; }     ///< after the last tick
  bool calibrated() const noexcept { return calibrated_; }  ///< the strings' lengths are known
  bool stopped() const noexcept { return stopped_; }        ///< since a `stop`: the strings may be slack
  bool held() const noexcept { return held_; }              ///< the dead-man switch is, or there is none
  /// Every board has answered a drive without current, and all since were such. Not in the memory: a restored device asks anew.
  bool currentless() const noexcept { return currentless_; }
  bool poseValid() const noexcept { return calibrated_ && freshness_.fresh(); }  ///< the pose means something now
  std::int64_t poseStamp() const noexcept { return pose_stamp_ns_; }  ///< of the counts that the pose comes from
  bool poseIsNew() const noexcept { return pose_is_new_; }            ///< it was made in this tick
  const Freshness& freshness() const noexcept { return freshness_; }  ///< of the counts
  /// Largest wall [N/m] that is stable in a relaxed hand with the delay that the wire has now.
  double stableStiffness() const noexcept { return stable_stiffness_; }
  /// Of the grip in the device's base; means something while poseValid().
  const Pose& pose() const noexcept { return solution_.pose.X_BG; }
  /// The same from steady lengths (steady_lengths.h), for walls and springs that are stiff against a count.
  const Pose& steadyPose() const noexcept { return steady_.X_BG; }
  const Twist& twist() const noexcept { return twist_; }  ///< V_BG of the steady pose: filtered, at G's origin, in B
  double opening() const noexcept { return solution_.pose.opening; }   ///< of a 7-DOF grip [m]
  double openingRate() const noexcept { return opening_rate_; }        ///< low-passed as the twist is [m/s]
  const PoseSolution& solution() const noexcept { return solution_; }  ///< with the strings' length errors
  const StringVector& zeroLengths() const noexcept { return zero_length_; }  ///< at count 0 [m]; after calibration
  const StringVector& lengths() const noexcept { return length_; }  ///< measured [m]; NaN before calibration
  /// Of the last tick's wrench.
  const TensionReport& tension() const noexcept { return distribution_.report(); }
  const Wrench& askedWrench() const noexcept { return asked_; }  ///< after all limits
  /// Wrench of the tensions on the hand, at G's origin, in B.
  const Wrench& achievedWrench() const noexcept { return achieved_; }
  const StringVector& toldTension() const noexcept { return told_; }  ///< tensions that the motors are told in the next exchange [N]
  unsigned flags() const noexcept { return flags_; }                  ///< DeviceFlag bits of the last tick
  /// The flags of the tick that led to kFault or kReduced; 0 in the other states.
  unsigned causeFlags() const noexcept { return cause_flags_; }
  /// Why it is in kFault or kReduced; in the other states why force is off, or the note on this tick.
  DeviceCause cause() const noexcept { return cause_; }
  double lateBy() const noexcept { return late_s_; }  ///< of cause kLoopLate [s]
  double absence() const noexcept { return absence_s_; }  ///< silence for which the force waits, of flag kForceWaits [s]
  bool asleep() const noexcept { return asleep_; }        ///< the machine slept during a part of it
  /// Bit per string that stood still while others moved, of cause kBoardRepeats.
  std::uint32_t stillStrings() const noexcept { return still_strings_; }
  bool linkLost() const noexcept { return clock_.linkLost(); }  ///< nothing answers on the wire, or has not for long enough
  unsigned buttons() const noexcept { return buttons_; }  ///< bit per grip button, of the last sample
  const StringHealth& health() const noexcept { return health_; }  ///< of strings and motors
  int suspectString() const noexcept { return health_.suspect(); }  ///< the one that disagrees most; -1: none

  const DeviceDef& def() const noexcept { return def_; }                 ///< with the exits as calibrated
  const SpidarSettings& settings() const noexcept { return settings_; }  ///< as constructed
  /// With the exits as calibrated.
  const StringKinematics& kinematics() const noexcept { return kinematics_; }

 private:
  static constexpr DriveCommand kNoDrive{};
  void follow(const DeviceRequests& requests, const DeviceSample& sample) noexcept;
  bool mayCalibrate(const GripPose& jig) const noexcept;
  void placeExits(const double* numbers);
  void startAt(const GripPose& pose) noexcept;
  double elapsedSince(std::int64_t last_ns, const DeviceSample& sample, double since, double h) const noexcept;
  bool takeLengths(const DeviceSample& sample, double elapsed) noexcept;
  bool takePose(const DeviceSample& sample, double elapsed) noexcept;
  void watchCounters(const DeviceSample& sample, double elapsed) noexcept;
  void checkFreshness(const DeviceSample& sample, bool plausible, double h, const TimeLost& lost) noexcept;
  void awaitPerson() noexcept;
  void checkWire(double h) noexcept;
  void obey(const CauseRow& row) noexcept;
  void enterFault(const CauseRow& row, bool zero_current) noexcept;
  void name(const CauseRow& row) noexcept;
  static constexpr double kRestForce = 0.1;  ///< [N]; tensions that cannot be balanced better leave the hand alone instead
  bool presents() const noexcept { return state_ == DeviceState::kEnabled || state_ == DeviceState::kReduced; }
  void updatePose(const PoseSolution& solved, const GripPose& steady, double h) noexcept;
  bool checkResidual(const PoseSolution& solved, const GripPose& last, double h) noexcept;
  bool restsSafely() const noexcept;
  bool endsAtOnce() const noexcept;
  void endAtOnce() noexcept;
  double allowedShare() const noexcept;
  void moveGain(double h) noexcept;
  void writeDrive(bool zero_current, double h) noexcept;

  DeviceDef def_;
  SpidarSettings settings_;
  Decay velocity_memory_;  ///< of the low-pass of velocities
  StringKinematics kinematics_;
  TensionDistribution distribution_;
  StringHealth health_;
  Freshness freshness_;
  StillCounters still_;
  SteadyLengths steady_lengths_;
  LoopClock clock_;
  DeviceRequests requests_;  ///< not in the memory: a recording has them when they are followed

  double max_force_ = 0, max_torque_ = 0;  ///< clamps on the wrench [N], [N·m]
  DeviceState state_ = DeviceState::kUncalibrated;
  bool calibrated_ = false, zero_current_ = false, enabled_ = false, held_ = true, stopped_ = false, pose_is_new_ = false;
  std::int64_t pose_stamp_ns_ = 0, counts_stamp_ns_ = 0;
  StringVector zero_length_;  ///< length at count 0 [m]
  StringVector length_;
  PoseSolution solution_;
  GripPose steady_;
  Twist twist_;
  double opening_rate_ = 0, heat_share_ = 1;
  double gain_ = 0, rise_s_ = 0;  ///< s on the whole wrench, and the time in which it rises by 1 [s]
  double grasp_ = 0;              ///< grasp force of the last tick [N]
  double stable_stiffness_ = 0;
  double since_counts_ = 0, since_pose_ = 0;  ///< since the last counts of every board, and the last pose [s]
  Wrench admitted_;                   ///< by the law, in this tick; `asked_` with what comes behind it
  Wrench wanted_, asked_, achieved_;  ///< gain times what is asked for; what the law makes of it; what the tensions make of that
  StringVector told_;  ///< tensions of drive_ [N]; zero without current
  DriveCommand drive_;
  unsigned flags_ = 0, cause_flags_ = 0, buttons_ = 0;
  std::uint64_t signs_ = 0;         ///< evidence of this tick beside the flags
  DeviceCause cause_ = DeviceCause::kNone;
  double absence_s_ = 0;
  double late_s_ = 0, refusal_ = 0; ///< refusal_: for so long a second request to calibrate is meant [s]
  std::uint32_t still_strings_ = 0;
  std::uint64_t zero_drives_ = 0;  ///< so many drives without current were made in a row
  bool currentless_ = false;
  bool doubted_ = false;      ///< there was a fault since the last calibration
  bool interrupted_ = false;  ///< force was on when the pause began
  bool waits_ = false;        ///< a silence lasted while force was on: it waits for a person who asks
  bool asleep_ = false;       ///< in that silence the machine slept
  bool paused_ = false, recovered_ = false;  ///< of this tick: no current; `recover` left kFault or kReduced
};

}  // namespace haptic
