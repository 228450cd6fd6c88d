#include <cmath>
#include <cstdio>

#include "haptic_core/spidar/device_record.h"
#include "haptic_core/spidar/ways_back.h"

namespace haptic {
namespace {

constexpr const char* kAgain = "hold the grip at the home pose, call recover and calibrate, then enable_force";

/// recover alone would leave a device without a pose.
const char* const kLengths = wayBackFrom(ForceEnd::kLengthsLost).asked;

std::string listOf(std::uint32_t strings) {
  std::string text;
  for (int i = 0; i < kMaxStrings; ++i)
    if (strings >> i & 1u) text += (text.empty() ? "" : ", ") + std::to_string(i);
  return text;
}

/// "string 3 measures 4.5 mm too long", as far as it is known.
std::string suspectText(const DeviceRecord& record) {
  if (record.suspect_string < 0) return "the strings' lengths contradict each other";
  if ((record.suspects & (record.suspects - 1)) != 0)
    return "one of strings " + listOf(record.suspects) + " measures wrong, most likely " + std::to_string(record.suspect_string);
  char text[80];
  std::snprintf(text, sizeof text, "string %d measures %.1f mm too %s", record.suspect_string,
                1e3 * std::fabs(record.suspect_error), record.suspect_error < 0 ? "short" : "long");
  return text;
}

std::string stringAdvice(const DeviceRecord& record) {
  if (record.suspect_string < 0) return suspectText(record) + ": look for one that is slack, stuck or broken, " + kAgain;
  const bool too_short = record.suspect_error < 0;
  return suspectText(record) + (too_short ? ": broken, or its encoder slipped" : ": slack, stuck, or its encoder slipped") +
         "; wind it, " + kAgain;
}

/// A number with its unit's digits: "8.1".
std::string number(const char* format, double a, double b = 0) {
  char text[160];
  std::snprintf(text, sizeof text, format, a, b);
  return text;
}

/// What to do once the cause is gone; `calibrated`: the strings' lengths are still known.
std::string again(const DeviceRecord& record) {
  return record.calibrated ? wayBackFrom(ForceEnd::kFault).asked : kLengths;
}

/// The cause with its numbers, and the remedy.
std::string causeText(const DeviceRecord& record) {
  const std::string happened = whatHappened(record.cause, record.board, record.late);
  switch (record.cause) {
    case DeviceCause::kNone:
    case DeviceCause::kCauses:
      return "";
    case DeviceCause::kLoopLate:
      return happened;
    case DeviceCause::kUnplugged:
    case DeviceCause::kBoardSilent:
      if (record.link_lost)
        return "the boards do not answer (" + happened + "), the current is zero: check plug and power; when they are back, " +
               again(record);
      return happened + " and answers again, the current stays zero: check plug and power, " + again(record);
    case DeviceCause::kPowerLost:
    case DeviceCause::kBoardRestarted:
      return happened + ": check its supply, then " + kLengths;
    case DeviceCause::kOtherBoard:
      return happened + ": restart the driver";
    case DeviceCause::kTableSpoilt:
    case DeviceCause::kWrongMode:
    case DeviceCause::kCurrentsIgnored:
    case DeviceCause::kCountsOld:
      return happened + ": check cable and ground, if it comes again switch its power off and on; " + again(record);
    case DeviceCause::kForgets:
      return happened + ": switch its power off and on, then check its cable; " + again(record);
    case DeviceCause::kNoise:
      return happened + ": check cable, ground and baud rate; " + again(record);
    case DeviceCause::kAnswersLost:
      return happened + number(" (%.0f %%)", 100 * record.lost_share) + ": check cable, power and ground, " + again(record);
    case DeviceCause::kWireSlow:
      return number("the wire's delay of %.1f ms leaves walls of at most %.2f N/mm stable", 1e3 * record.delay,
                    1e-3 * record.stable_stiffness) +
             (record.state == DeviceState::kReduced ? "" : ", force is refused") + ": set the adapter's latency timer to 1 ms, " +
             again(record);
    case DeviceCause::kCounterJumped:
      if (record.suspect_string < 0) return happened + ": check cables and encoders, " + kAgain;
      return "the counter of string " + std::to_string(record.suspect_string) + " jumped: check its encoder and cable, " + kAgain;
    case DeviceCause::kBoardRepeats:
      return "the counters of strings " + listOf(record.still_strings) + " stand still while the others move: their board repeats "
             "its counts, check its supply and cable, then " + kLengths;
    case DeviceCause::kCountersStill:
      return happened + "; " + kLengths;
    case DeviceCause::kCountersFrozen:
      return happened + "; " + again(record);
    case DeviceCause::kStringWrong:
    case DeviceCause::kStringDoubtful:
      return stringAdvice(record);
    case DeviceCause::kUnguarded:
      return happened +
             ((record.flags & kUnguarded)
                  ? ", the current is zero: no process would turn the motors off if the driver died; when a new guard watches, "
                  : "; a new one watches, the current stays zero: find what stopped it, ") +
             again(record);
    case DeviceCause::kOverRate:
      return happened + ": lower the rate, then call recover";
  }
  return "";
}

/// Why the force waits for a person, and what that person does.
std::string waitText(const DeviceRecord& record) {
  const std::string why = record.asleep ? "this machine slept: nothing was exchanged" : "nothing was exchanged";
  const std::string then = record.calibrated ? wayBackFrom(ForceEnd::kLastingSilence).asked : kLengths;
  return why + number(" for %.1f s", record.absence) + ", the force is off and does not come back by itself: take the grip, and " + then;
}

}  // namespace

DeviceRecord recordOf(const Spidar& device, std::uint64_t tick, std::int64_t stamp_ns,
                      const DeviceSample& sample) noexcept {
  DeviceRecord r;
  r.tick = tick;
  r.stamp_ns = stamp_ns;
  r.sample = sample;
  r.X_BG = device.pose();
  r.V_BG = device.twist();
  r.F_asked_B = device.askedWrench();
  r.F_achieved_B = device.achievedWrench();
  r.length = device.lengths();
  r.tension = device.tension().tension;
  r.opening = device.opening();
  r.opening_rate = device.openingRate();
  r.grasp_force = device.tension().grasp_force;
  r.pose_residual = device.solution().residual;
  r.state = device.state();
  r.calibrated = device.calibrated();
  r.held = device.held();
  r.currentless = device.currentless();
  r.pose_valid = device.poseValid();
  r.pose_new = device.poseIsNew();
  r.latched_ns = device.poseStamp() != 0 ? device.poseStamp() : stamp_ns;
  r.delay = device.freshness().delay();
  r.counts_age = device.freshness().age();
  r.lost_share = device.freshness().lostShare();
  r.stable_stiffness = device.stableStiffness();
  r.suspect_string = device.suspectString();
  r.suspects = device.health().suspects();
  r.suspect_error = device.health().suspectError();
  r.hottest_motor = device.health().hottestMotor();
  r.flags = device.flags();
  r.cause = device.cause();
  r.board = sample.board;
  r.late = device.lateBy();
  r.absence = device.absence();
  r.asleep = device.asleep();
  r.link_lost = device.linkLost();
  r.still_strings = device.stillStrings();
  return r;
}

std::string advice(const DeviceRecord& record, const std::string& device_name) {
  const bool presents = record.state == DeviceState::kEnabled || record.state == DeviceState::kReduced;
  if ((record.flags & kCalibrationRefused) && presents && record.F_asked_B.force.norm() > 0)
    return "not calibrated: a force pushes the grip away from the pose that was named; switch it off (enable_force false) or take the grip "
           "out of contact, hold it there and call calibrate";
  if (record.flags & kCalibrationRefused)
    return "not calibrated: the grip is far from the pose that was named; hold it there and call calibrate, or call it again within "
           "10 s if the pose shown is wrong";
  if ((record.flags & kForceWaits) && record.state != DeviceState::kFault) return waitText(record);
  if (const std::string text = causeText(record); !text.empty())
    return record.state == DeviceState::kReduced ? "little force, because " + text : text;
  if (record.flags & kStopped)
    return std::string("somebody said STOP, the motors are off: ") + wayBackFrom(ForceEnd::kStop).asked;
  if (record.state == DeviceState::kUncalibrated)
    return "the pose is not known and the force is off: hold the grip at the home pose and call calibrate";
  if (!record.calibrated) return std::string("the strings' lengths are not known: ") + kAgain;
  if (!record.held) return "the dead-man switch is not held, the force is off: hold it, and enable_force if it is off, for force";
  if (record.flags & kStringCorrected) {
    char text[200];
    std::snprintf(text, sizeof text, "the encoder of string %d slipped by %.1f mm and was corrected: tighten it, and calibrate "
                  "at the next pause", record.suspect_string, 1e3 * std::fabs(record.suspect_error));
    return text;
  }
  if (record.flags & kOverRate)
    return "the exchange runs faster than the wire of " + device_name + " carries: lower the rate";
  if (record.flags & kMotorHot)
    return "motor " + std::to_string(record.hottest_motor) + " is hot: the wrench is faded until it has cooled";
  if (record.flags & kCommandNotFinite) return "the wrench command is not finite: it was taken as zero";
  if (record.flags & kCommandStale) return "no fresh wrench command: the sender has stopped";
  if (record.flags & kPoseNotConverged) return "the lengths fit no pose near the last one: the pose is held";
  if (record.flags & kTorqueIgnored) return "this grip is a point: torque is ignored";
  if (record.flags & kNotPresentable)
    return "the strings cannot present this wrench here (tension bounds)";
  return "";
}

const char* stateName(const DeviceRecord& record) { return record.link_lost ? "DISCONNECTED" : toString(record.state); }

std::string standing(const DeviceRecord& record, const std::string& device_name) {
  const std::string text = advice(record, device_name);
  if (!text.empty()) return text;
  if (record.state == DeviceState::kReady)
    return std::string("the pose is known and the force is off: ") + wayBackFrom(ForceEnd::kSwitchedOff).asked;
  return "the wrench asked for is presented: nothing is to be done";
}

}  // namespace haptic
