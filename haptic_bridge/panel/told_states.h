/// The states of devices, session and loop in words: which one it is, and what to do.
#pragma once
#include <haptic_msgs/DeviceState.h>
#include <haptic_msgs/StepReport.h>
#include <haptic_msgs/TickStatistics.h>

#include <functional>
#include <string>
#include <vector>

namespace haptic {

/// How much a state asks of whoever sees it.
enum class Weight : unsigned char { kCalm, kNotice, kWarning, kAlarm };

/// Ground for white words [#rrggbb], of a contrast of 4.5 and more.
const char* groundOf(Weight weight);

/// One state.
struct Told {
  Weight weight;
  std::string text;
};

/// Takes all that a source tells now, in place of what it told before.
using Say = std::function<void(const std::string& source, const std::vector<Told>& told)>;

/// A device's state in capitals.
struct DeviceWord {
  const char* word;
  Weight weight;
};
DeviceWord wordOf(const haptic_msgs::DeviceState& state);

std::vector<Told> tell(const std::string& device, const haptic_msgs::DeviceState& state);
/// `pointers`: links that the scene gives the hands; a hand with another link has grabbed it. Empty: not known yet.
std::vector<Told> tell(const haptic_msgs::TickStatistics& loop, const std::vector<std::string>& pointers);
std::vector<Told> tell(const haptic_msgs::StepReport& step);
Told toldOfReplay();

}  // namespace haptic
