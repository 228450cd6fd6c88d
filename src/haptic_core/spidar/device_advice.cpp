#include <cmath>
#include <cstdio>

#include "haptic_core/spidar/device_record.h"

namespace haptic {
namespace {

std::string stringAdvice(const DeviceRecord& record) {
  if (record.suspect_string < 0) return "";
  char text[200];
  const bool too_short = record.suspect_error < 0;
  std::snprintf(text, sizeof text, "string %d measures %.1f mm too %s: %s. ", record.suspect_string,
                1e3 * std::fabs(record.suspect_error), too_short ? "short" : "long",
                too_short ? "broken, or its encoder slipped" : "slack, stuck, or its encoder slipped");
  return text;
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
  r.pose_valid = device.poseValid();
  r.pose_new = device.poseIsNew();
  r.latched_ns = device.poseStamp() != 0 ? device.poseStamp() : stamp_ns;
  r.delay = device.freshness().delay();
  r.counts_age = device.freshness().age();
  r.lost_share = device.freshness().lostShare();
  r.stable_stiffness = device.stableStiffness();
  r.suspect_string = device.suspectString();
  r.suspect_error = device.health().suspectError();
  r.hottest_motor = device.health().hottestMotor();
  r.flags = device.flags();
  r.cause = device.causeFlags();
  return r;
}

std::string advice(const DeviceRecord& record, const std::string& device_name) {
  if (record.flags & kLinkLost) return "the board is silent: check plug and power, then recover";
  if (record.cause & kCountersStuck)
    return "the counters stand still while the force changes: the board repeats itself; switch it off and on, recover";
  if (record.flags & kDelayTooLong) {
    char text[200];
    std::snprintf(text, sizeof text, "the wire's delay of %.1f ms leaves walls of at most %.2f N/mm stable: force is refused; "
                  "set the adapter's latency timer to 1 ms", 1e3 * record.delay, 1e-3 * record.stable_stiffness);
    return text;
  }
  if (record.flags & kAnswersLost) {
    char text[160];
    std::snprintf(text, sizeof text, "%.0f %% of the boards' answers are lost: check cable, power and ground, then recover",
                  100 * record.lost_share);
    return text;
  }
  if (record.state == DeviceState::kUncalibrated) return "hold the grip at the home pose and calibrate";
  if (!record.calibrated)
    return stringAdvice(record) +
           "A counter jumped: check cable and encoder, hold the grip at the home pose, recover and calibrate";
  if (record.state == DeviceState::kFault || record.state == DeviceState::kReduced)
    return stringAdvice(record) + "Wind it, hold the grip at the home pose, recover and calibrate";
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

}  // namespace haptic
