/// One tick of a device, copied for other threads: topics, recorders, diagnostics.
#pragma once
#include <string>

#include "haptic_core/spidar/spidar.h"

namespace haptic {

/// One tick of a device, copied for other threads.
struct DeviceRecord {
  std::uint64_t tick = 0;     ///< index of the tick
  std::int64_t stamp_ns = 0;  ///< steady clock at the start of the tick
  DeviceSample sample;        ///< sample of the wire
  Pose X_BG;                        ///< grip; meaningless unless `pose_valid`
  std::int64_t latched_ns = 0;      ///< steady clock at the instant of the counts that the pose comes from
  Twist V_BG;                       ///< at G's origin, in B
  /// Wrench asked for and wrench presented: on the hand at G's origin, in B, after the device's limits [N·m],
  /// [N].
  Wrench F_asked_B, F_achieved_B;   ///< on the hand at G's origin, in B, after the device's limits
  /// By string [m], [N].
  StringVector length, tension;     ///< [m], [N]
  double opening = 0;               ///< 7-DOF grips [m]
  double opening_rate = 0;          ///< [m/s]
  double grasp_force = 0;           ///< presented along the opening [N]
  double pose_residual = 0;         ///< [m]
  DeviceState state = DeviceState::kUncalibrated;  ///< after the tick
  bool calibrated = false;                         ///< the strings' lengths are known
  bool held = true;           ///< the dead-man switch is, or there is none
  bool currentless = false;   ///< every board has answered a drive without current, and all since were such
  bool pose_valid = false;    ///< calibrated, and the counts are not older than the limit
  bool pose_new = false;      ///< made in this tick
  double delay = 0;           ///< mean age of the counts: the wire's part of the loop's delay [s]
  double counts_age = 0;      ///< of the oldest board's counts [s]
  double lost_share = 0;      ///< of the exchanges, in the last 50 ms [1]
  double stable_stiffness = 0;  ///< largest wall that is stable in a relaxed hand with that delay [N/m]
  int suspect_string = -1;    ///< the one that disagrees most; -1: none
  std::uint32_t suspects = 0;  ///< bit per string that may be the one
  std::uint32_t still_strings = 0;  ///< bit per string that stands still, of cause kBoardRepeats
  double suspect_error = 0;   ///< measured minus true length of it [m]
  int hottest_motor = 0;      ///< index of the string
  unsigned flags = 0;  ///< see DeviceFlag
  DeviceCause cause = DeviceCause::kNone;  ///< of FAULT or REDUCED; else why force is off, or the note on this tick
  int board = -1;             ///< id of the board that the wire blamed last; -1: none, or none is known
  double late = 0;            ///< of cause kLoopLate [s]
  double absence = 0;         ///< of flag kForceWaits: how long the silence was [s]
  bool asleep = false;        ///< in it the machine slept
  bool link_lost = false;     ///< nothing answers on the wire, or has not for long enough
};

/// (in realtime) What `device` did in the tick that just ended; the thread that ticks it calls it.
DeviceRecord recordOf(const Spidar& device, std::uint64_t tick, std::int64_t stamp_ns,
                      const DeviceSample& sample) noexcept;

/// The state as users see it: DISCONNECTED while nothing answers, whatever the device will be then.
const char* stateName(const DeviceRecord& record);
/// The fault and its remedy, one sentence each; empty when all is well. Allocates: not for a tick.
std::string advice(const DeviceRecord& record, const std::string& device_name);
/// The state and what to do now: `advice`, or that of a device that is well. Never empty.
std::string standing(const DeviceRecord& record, const std::string& device_name);

}  // namespace haptic
