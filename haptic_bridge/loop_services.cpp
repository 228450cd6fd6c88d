#include "haptic_bridge/loop_services.h"

#include <ros/console.h>

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"

namespace haptic {

LoopServices::LoopServices(ros::NodeHandle& priv, const std::string& name, const BridgeParameters& parameters,
                           RealtimeThread& loop)
    : name_(name), loop_(loop), server_(mutex_, priv) {
  applied_ = haptic_bridge::LoopConfig::__getDefault__();
  applied_.soft_start = parameters.soft_start;
  applied_.passivity = static_cast<int>(parameters.passivity);
  server_.updateConfig(applied_);
  server_.setCallback([this](haptic_bridge::LoopConfig& config, std::uint32_t level) { onParameters(config, level); });
  clutch_ = priv.advertiseService("clutch", &LoopServices::onClutch, this);
}

LoopServices::~LoopServices() {
  clutch_.shutdown();
  server_.clearCallback();
}

bool LoopServices::onClutch(haptic_msgs::Clutch::Request& request, haptic_msgs::Clutch::Response& response) {
  const auto devices = loop_.deviceNames();
  const bool ran = loop_.betweenTicks([&](LoopSession& session) {
    std::string known;
    int matched = 0;
    for (std::size_t i = 0; i < devices.size() && i < static_cast<std::size_t>(session.loop().handCount()); ++i) {
      known += " " + devices[i];
      if (!request.device.empty() && request.device != devices[i]) continue;
      ++matched;
      Hand& hand = session.loop().hand(static_cast<int>(i));
      if (request.hold && hand.report().in_contact && !hand.report().clutched) {
        response.message = "the pointer of " + devices[i] + " is in contact: move it free first";
        return;
      }
    }
    if (matched == 0) {
      response.message = "no hand '" + request.device + "'; there are:" + known;
      return;
    }
    for (std::size_t i = 0; i < devices.size() && i < static_cast<std::size_t>(session.loop().handCount()); ++i) {
      if (request.device.empty() || request.device == devices[i]) session.take({HoldClutch{request.hold != 0}, static_cast<int>(i)});
    }
    response.success = true;
  });
  if (!ran) response.message = "the loop does not tick";
  return true;
}

void LoopServices::onParameters(haptic_bridge::LoopConfig& config, std::uint32_t) {
  if (!started_) {  // the server tells its start values; those of the parameter server hold
    started_ = true;
    config = applied_;
    return;
  }
  try {
    if (!loop_.betweenTicks([&](LoopSession& session) { apply(session, config); })) {
      ROS_ERROR_STREAM_NAMED(name_, "parameters: the loop does not tick; nothing has changed");
      config = applied_;
    }
  } catch (const SetupError& error) {
    ROS_ERROR_STREAM_NAMED(name_, "parameters refused: " << error.what());
    // What came before the refused value may have been changed: put all of it back.
    config = applied_;
    loop_.betweenTicks([&](LoopSession& session) { apply(session, applied_); });
  }
  applied_ = config;
}

void LoopServices::reapply() {
  boost::recursive_mutex::scoped_lock lock(mutex_);
  try {
    loop_.betweenTicks([&](LoopSession& session) { apply(session, applied_); });
  } catch (const SetupError& error) {
    ROS_ERROR_STREAM_NAMED(name_, "parameters do not fit the new scene: " << error.what());
  }
}

void LoopServices::apply(LoopSession& session, const haptic_bridge::LoopConfig& config) const {
  for (const double value : {config.stiffness_scale, config.friction_scale, config.lambda_, config.limit_share,
                             config.force_scale, config.soft_start, config.coupling_stiffness, config.coupling_damping,
                             config.coupling_rotational_stiffness, config.coupling_rotational_damping}) {
    if (!std::isfinite(value)) throw SetupError("a parameter", "is not finite", "give a number");
  }
  WorldTuning tuning = session.world().tuning();
  tuning.stiffness_scale = config.stiffness_scale;
  tuning.friction_scale = config.friction_scale;
  for (int i = 0; i < session.world().pointerCount(); ++i) {
    PointerCoupling& coupling = tuning.coupling[i];
    coupling = session.world().pointer(i).coupling;
    if (config.coupling == haptic_bridge::Loop_scene) continue;
    coupling.mode = config.coupling == haptic_bridge::Loop_virtual ? PointerCoupling::Mode::kVirtual : PointerCoupling::Mode::kDirect;
    coupling.stiffness = config.coupling_stiffness;
    coupling.damping = config.coupling_damping;
    coupling.rotational_stiffness = config.coupling_rotational_stiffness;
    coupling.rotational_damping = config.coupling_rotational_damping;
  }
  if (tuning.numbers() != session.world().tuning().numbers()) session.take({TuneWorld{tuning}});
  for (int i = 0; i < session.loop().handCount(); ++i) {
    Hand& hand = session.loop().hand(i);
    const DeviceDef& def = hand.device().def();
    const Spidar::Tuning now = hand.device().tuning();
    const double own_lambda = def.border_lambda > 0 ? def.border_lambda : def.lambda;
    const Spidar::Tuning next{config.lambda_ > 0 ? config.lambda_ : own_lambda, config.limit_share * def.max_force,
                              config.limit_share * def.max_torque};
    if (next.lambda != now.lambda || next.max_force != now.max_force || next.max_torque != now.max_torque) {
      session.tuneDevice(i, next);
    }
    HandSettings settings = hand.settings();
    settings.force_scale = config.force_scale * session.definedForceScale(i);
    settings.soft_start_s = config.soft_start;
    settings.passivity.mode = static_cast<PassivityMode>(config.passivity);
    if (numbersOf(settings) != numbersOf(hand.settings())) session.take({ChangeHand{settings}, i});
  }
}

}  // namespace haptic
