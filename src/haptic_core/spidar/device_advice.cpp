#include <cstdio>
#include <string>

#include "haptic_core/spidar/spidar.h"

namespace haptic {
namespace {

std::string stringAdvice(const Spidar& device) {
  const int i = device.health().suspect();
  if (i < 0) return "";
  char text[200];
  const double error = device.health().suspectError();
  std::snprintf(text, sizeof text, "string %d measures %.1f mm too %s: %s. ", i,
                1e3 * (error < 0 ? -error : error), error < 0 ? "short" : "long",
                error < 0 ? "broken, or its encoder slipped" : "slack, stuck, or its encoder slipped");
  return text;
}

}  // namespace

std::string advice(const Spidar& device) {
  const unsigned flags = device.flags();
  if (flags & kLinkLost) return "the board is silent: check plug and power, then recover";
  if (device.state() == DeviceState::kUncalibrated) return "hold the grip at the home pose and calibrate";
  if (!device.calibrated())
    return stringAdvice(device) +
           "A counter jumped: check cable and encoder, hold the grip at the home pose, recover and calibrate";
  if (device.state() == DeviceState::kFault || device.state() == DeviceState::kReduced)
    return stringAdvice(device) + "Wind it, hold the grip at the home pose, recover and calibrate";
  if (flags & kOverRate)
    return "the exchange runs faster than the wire of " + device.def().name + " carries: lower the rate";
  if (flags & kMotorHot)
    return "motor " + std::to_string(device.health().hottestMotor()) +
           " is hot: the wrench is faded until it has cooled";
  if (flags & kCommandNotFinite) return "the wrench command is not finite: it was taken as zero";
  if (flags & kCommandStale) return "no fresh wrench command: the sender has stopped";
  if (flags & kPoseNotConverged) return "the lengths fit no pose near the last one: the pose is held";
  if (flags & kTorqueIgnored) return "this grip is a point: torque is ignored";
  if (flags & kNotPresentable)
    return "the wrench is outside what the strings can present here (tension bounds)";
  return "";
}

}  // namespace haptic
