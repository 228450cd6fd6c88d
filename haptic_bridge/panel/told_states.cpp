#include "haptic_bridge/panel/told_states.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "haptic_msgs/flag_words.h"

namespace haptic {
namespace {

using haptic_msgs::DeviceState;

constexpr DeviceWord kStates[] = {{"UNCALIBRATED", Weight::kWarning}, {"READY", Weight::kNotice}, {"FORCE ON", Weight::kCalm},
                                  {"REDUCED", Weight::kWarning}, {"FAULT", Weight::kAlarm}, {"DISCONNECTED", Weight::kAlarm}};

template <std::size_t kCount>
void addFlags(const FlagWords (&words)[kCount], unsigned flags, const std::string& whose, std::vector<Told>& told) {
  for (const FlagWords& entry : words) {
    if (flags & entry.flag) told.push_back({entry.grade == FlagGrade::kWarning ? Weight::kWarning : Weight::kCalm, whose + entry.text});
  }
}

}  // namespace

const char* groundOf(Weight weight) {
  constexpr const char* kGrounds[] = {"#2e6b33", "#1f5fbf", "#8a4b00", "#b3123f"};
  return kGrounds[static_cast<int>(weight)];
}

DeviceWord wordOf(const DeviceState& state) {
  return state.state < sizeof kStates / sizeof kStates[0] ? kStates[state.state] : DeviceWord{"UNKNOWN", Weight::kWarning};
}

std::vector<Told> tell(const std::string& device, const DeviceState& state) {
  std::vector<Told> told;
  const DeviceWord word = wordOf(state);
  if (word.weight != Weight::kCalm) told.push_back({word.weight, device + " " + word.word + ": " + state.message});
  if (state.dead_man == DeviceState::SWITCH_RELEASED) {
    told.push_back({Weight::kNotice, device + ": the dead-man switch is released; hold it to feel"});
  }
  return told;
}

std::vector<Told> tell(const haptic_msgs::TickStatistics& loop, const std::vector<std::string>& pointers) {
  std::vector<Told> told;
  if (loop.paused) told.push_back({Weight::kNotice, "PAUSED: the world stands and nothing is felt; press Go on"});
  for (const haptic_msgs::HandReport& hand : loop.hands) {
    const std::string whose = loop.hands.size() > 1 ? hand.device + ": " : "";
    if (hand.clutched) told.push_back({Weight::kNotice, whose + "CLUTCH: the pointer stands while the grip moves; press Follow"});
    const bool known = pointers.empty() || std::find(pointers.begin(), pointers.end(), hand.pointer) != pointers.end();
    if (!known) {
      told.push_back({Weight::kNotice, whose + "HOLDS " + hand.pointer + ": press Release to let it go"});
    }
    char felt[80];
    const double force = std::hypot(hand.achieved.force.x, hand.achieved.force.y, hand.achieved.force.z);
    std::snprintf(felt, sizeof felt, hand.in_contact ? "the hand feels %.1f N" : "the hand touches nothing", force);
    told.push_back({Weight::kCalm, whose + felt});
    if (hand.softened) {
      std::snprintf(felt, sizeof felt, "softened to %.0f %%, as the hand bears it", 100 * hand.stiffness_share);
      told.push_back({Weight::kCalm, whose + felt});
    }
    addFlags(kDeviceFlagWords, hand.flags, whose, told);
  }
  return told;
}

std::vector<Told> tell(const haptic_msgs::StepReport& step) {
  std::vector<Told> told;
  if (!step.finite) {
    const std::string where = step.culprit.empty() ? "" : " at " + step.culprit;
    told.push_back({Weight::kAlarm, "THE WORLD STOPPED" + where + ": press Reset, then shorten the step"});
  }
  told.push_back({Weight::kCalm, std::to_string(step.contacts) + (step.contacts == 1 ? " contact" : " contacts")});
  addFlags(kStepFlagWords, step.flags, "", told);
  return told;
}

Told toldOfReplay() { return {Weight::kNotice, "REPLAY of a recorded session: no motor moves"}; }

}  // namespace haptic
