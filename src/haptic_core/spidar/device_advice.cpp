#include <cmath>
#include <cstdio>

#include "haptic_core/spidar/device_record.h"

namespace haptic {
namespace {

constexpr const char* kAgain = "hold the grip at the home pose, call recover and calibrate, then enable_force";

/// recover alone would leave a device without a pose.
constexpr const char* kLengths = "hold the grip at the home pose, call calibrate first, then recover, then enable_force";

std::string listOf(std::uint32_t strings) {
  std::string text;
  for (int i = 0; i < kMaxStrings; ++i)
    if (strings >> i & 1u) text += (text.empty() ? "" : ", ") + std::to_string(i);
  return text;
}

/// "string 3 measures 4.5 mm too long", or what is known of it.
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

/// What led to FAULT or REDUCED; empty in the other states.
std::string causeAdvice(const DeviceRecord& record) {
  const bool fault = record.state == DeviceState::kFault;
  if (!fault && record.state != DeviceState::kReduced) return "";
  if (record.cause & kLinkLost) {
    const std::string known = record.calibrated ? "call recover, then enable_force" : kLengths;
    return "the boards were silent and answer again, the current stays zero: check plug and power, " + known;
  }
  if (record.cause & kUnguarded)
    return "the motor guard had ended or stood still, a new one watches, the current stays zero: find what stopped it, "
           "call recover, then enable_force";
  if (record.cause & kAnswersLost) return std::string(fault ? "no force" : "little force") +
                                          ", because too many answers of the boards were lost: check cable, power and ground, "
                                          "call recover, then enable_force";
  if (record.cause & kDelayTooLong)
    return "the wire had become too slow for force: set the adapter's latency timer to 1 ms, call recover, then enable_force";
  if (record.cause & kCounterRestarted)
    return std::string("a board has lost its power, its counters tell no lengths: check its supply, then ") + kLengths;
  if (record.cause & kCountersStill)
    return std::string("no counter moves although the force does: a board repeats its counts, or the grip is clamped; ") + kLengths;
  if (record.cause & kEncoderJump || !record.calibrated) {
    if (record.suspect_string < 0) return std::string("a counter jumped: check cables and encoders, ") + kAgain;
    return "the counter of string " + std::to_string(record.suspect_string) + " jumped: check its encoder and cable, " + kAgain;
  }
  if (record.cause & kOverRate) return "the exchange ran faster than the wire carries: lower the rate, then call recover";
  const std::string text = stringAdvice(record);
  return fault ? text : "little force, because " + text;
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
  r.cause = device.causeFlags();
  return r;
}

std::string advice(const DeviceRecord& record, const std::string& device_name) {
  if (record.flags & kLinkLost)
    return "the boards do not answer, the current is zero: check plug and power; when they are back, call recover";
  if (record.flags & kUnguarded)
    return "the motor guard has ended or stands still, the current is zero: nobody would turn the motors off if the driver died; "
           "when a new guard watches, call recover, then enable_force";
  if (const std::string text = causeAdvice(record); !text.empty()) return text;
  if (record.flags & kDelayTooLong) {
    char text[200];
    std::snprintf(text, sizeof text, "the wire's delay of %.1f ms leaves walls of at most %.2f N/mm stable, force is refused: "
                  "set the adapter's latency timer to 1 ms", 1e3 * record.delay, 1e-3 * record.stable_stiffness);
    return text;
  }
  if (record.flags & kAnswersLost) {
    char text[160];
    std::snprintf(text, sizeof text, "%.0f %% of the boards' answers are lost: check cable, power and ground, then call recover",
                  100 * record.lost_share);
    return text;
  }
  if (record.flags & kStopped)
    return "somebody said STOP, the motors are off: call recover for tensioned strings, or enable_force for force";
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
    return "the wrench is outside what the strings can present here (tension bounds)";
  return "";
}

std::string standing(const DeviceRecord& record, const std::string& device_name) {
  const std::string text = advice(record, device_name);
  if (!text.empty()) return text;
  if (record.state == DeviceState::kReady) return "the pose is known and the force is off: call enable_force for force";
  return "the wrench asked for is presented: nothing is to be done";
}

}  // namespace haptic
