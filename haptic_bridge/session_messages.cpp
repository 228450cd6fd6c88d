#include "haptic_bridge/session_messages.h"

#include <fstream>
#include <iterator>
#include <sstream>

#include "haptic_core/base/build_info.h"

namespace haptic {
namespace {

std::string textOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

std::string parameterText(const BridgeParameters& p) {
  std::ostringstream out;
  out << "rate: " << p.rate << "\nseconds: " << p.seconds << "\nsoft_start: " << p.soft_start << "\npassivity: "
      << (p.passivity == PassivityMode::kOff ? "off" : p.passivity == PassivityMode::kAct ? "act" : "observe")
      << "\nclutch_button: " << p.clutch_button << "\ngrab_button: " << p.grab_button
      << "\npriority: " << p.realtime.priority << "\ncpu: " << p.realtime.cpu << "\n";
  return out.str();
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

std::vector<std::string> deviceTexts(const SessionStart& start) {
  std::vector<std::string> texts;
  for (const SessionStart::HandStart& hand : start.hands) texts.push_back(textOf(hand.def.file));
  return texts;
}

haptic_msgs::SessionInfo toSessionInfo(const RealtimeThread::Start& start, const std::vector<std::string>& device_texts,
                                       const BridgeParameters& parameters) {
  haptic_msgs::SessionInfo m;
  m.header.stamp = ros::Time::now();
  m.version = m.VERSION;
  m.program = programVersion();
  m.build = buildFlags();
  m.scene = start.scene;
  m.scene_file = start.source.file;
  m.scene_text = start.source.text;
  m.scene_fingerprint = start.source.fingerprint;
  m.default_density = start.source.default_density;
  m.rate = parameters.rate;
  m.first_tick = start.session.first_tick;
  m.links = start.links;
  m.device_texts = device_texts;
  for (const SessionStart::HandStart& hand : start.session.hands) {
    m.devices.push_back(hand.device);
    m.pointers.push_back(hand.pointer);
    append(m.hand_settings, numbersOf(hand.settings));
    append(m.device_memory, hand.memory);
    m.device_memory_sizes.push_back(static_cast<std::uint32_t>(hand.memory.size()));
    append(m.hand_memory, hand.loop_memory);
    m.hand_memory_sizes.push_back(static_cast<std::uint32_t>(hand.loop_memory.size()));
  }
  m.world_state = start.session.world_state;
  m.world_hash = start.world_hash;
  m.world_tuning = start.session.world_tuning;
  m.bodies = start.session.bodies;
  m.paused = start.session.paused;
  m.parameters = parameterText(parameters);
  return m;
}

}  // namespace haptic
