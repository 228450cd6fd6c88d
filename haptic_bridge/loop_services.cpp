#include "haptic_bridge/loop_services.h"

namespace haptic {
namespace {

haptic_bridge::LoopConfig startOf(const BridgeParameters& parameters) {
  haptic_bridge::LoopConfig config = haptic_bridge::LoopConfig::__getDefault__();
  config.soft_start = parameters.soft_start;
  config.passivity = static_cast<int>(parameters.passivity);
  return config;
}

}  // namespace

LoopServices::LoopServices(ros::NodeHandle& priv, const std::string& name, const BridgeParameters& parameters,
                           RealtimeThread& loop)
    : loop_(loop), parameters_(priv, name, startOf(parameters), [this](const auto& config) { return apply(config); }) {
  clutch_ = priv.advertiseService("clutch", &LoopServices::onClutch, this);
}

LoopServices::~LoopServices() {
  clutch_.shutdown();
}

bool LoopServices::onClutch(haptic_msgs::Clutch::Request& request, haptic_msgs::Clutch::Response& response) {
  const bool ran = loop_.change([&](const LoopSession::View& view) {
    std::string known;
    std::vector<LoopCommand> commands;
    response.message.clear();
    for (std::size_t i = 0; i < view.hands.size(); ++i) {
      const LoopSession::View::Hand& hand = view.hands[i];
      known += " " + hand.name;
      if (!request.device.empty() && request.device != hand.name) continue;
      commands.push_back({HoldClutch{request.hold != 0}, static_cast<int>(i)});
      if (request.hold && hand.in_contact && !hand.clutched && response.message.empty()) {
        response.message = "the pointer of " + hand.name + " is in contact: move it free first";
      }
    }
    if (commands.empty()) response.message = "no hand '" + request.device + "'; there are:" + known;
    return response.message.empty() ? commands : std::vector<LoopCommand>();
  });
  if (!ran) response.message = "the loop does not tick";
  response.success = response.message.empty();
  return true;
}

bool LoopServices::apply(const haptic_bridge::LoopConfig& config) {
  loop_.startSilent(config.silent);
  return loop_.change([&](const LoopSession::View& view) { return commandsFor(config, view); });
}

std::vector<LoopCommand> LoopServices::commandsFor(const haptic_bridge::LoopConfig& config, const LoopSession::View& view) {
  std::vector<LoopCommand> commands;
  WorldTuning tuning = view.tuning;
  tuning.stiffness_scale = config.stiffness_scale;
  tuning.friction_scale = config.friction_scale;
  tuning.coupling = view.defined;
  for (PointerCoupling& coupling : tuning.coupling) {
    if (config.coupling == haptic_bridge::Loop_scene) continue;
    coupling.mode = config.coupling == haptic_bridge::Loop_virtual ? PointerCoupling::Mode::kVirtual : PointerCoupling::Mode::kDirect;
    coupling.stiffness = config.coupling_stiffness;
    coupling.damping = config.coupling_damping;
    coupling.rotational_stiffness = config.coupling_rotational_stiffness;
    coupling.rotational_damping = config.coupling_rotational_damping;
  }
  if (tuning.numbers() != view.tuning.numbers()) commands.push_back({TuneWorld{tuning}});
  for (std::size_t i = 0; i < view.hands.size(); ++i) {
    const LoopSession::View::Hand& hand = view.hands[i];
    const Spidar::Tuning &now = hand.tuning, &stated = hand.stated;
    const TuneDevice next{config.lambda_ > 0 ? config.lambda_ : stated.lambda, config.limit_share * stated.max_force,
                          config.limit_share * stated.max_torque};
    if (next.lambda != now.lambda || next.max_force != now.max_force || next.max_torque != now.max_torque) {
      commands.push_back({next, static_cast<int>(i)});
    }
    HandSettings settings = hand.settings;
    settings.force_scale = config.force_scale * hand.defined.force_scale;
    settings.soft_start_s = config.soft_start;
    settings.silent = config.silent;
    settings.passivity.mode = static_cast<PassivityMode>(config.passivity);
    if (numbersOf(settings) != numbersOf(hand.settings)) commands.push_back({ChangeHand{settings}, static_cast<int>(i)});
  }
  return commands;
}

}  // namespace haptic
