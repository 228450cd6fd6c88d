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

haptic_msgs::LoopEvent toLoopEvent(const LoopEvent& event) {
  haptic_msgs::LoopEvent m;
  m.header.stamp = ros::Time::now();
  m.tick = event.tick;
  m.kind = static_cast<std::uint8_t>(event.command.kind.index());
  m.hand = event.command.hand;
  m.numbers = numbersOf(event.command);
  return m;
}

bool addTick(const RecordedTick& tick, const std::vector<int>& strings, haptic_msgs::TickRecord& m) {
  const TickInput& input = tick.input;
  const auto hands = static_cast<std::uint32_t>(input.hands), parts = static_cast<std::uint32_t>(tick.hash.parts);
  if (m.ticks == 0) {
    m.first_tick = input.tick;
    m.hands = hands;
    m.parts = parts;
    m.channels = 0;
    for (const int n : strings) m.channels += static_cast<std::uint32_t>(n);
  } else if (input.tick != m.first_tick + m.ticks || hands != m.hands || parts != m.parts) {
    return false;
  }
  for (int i = 0; i < input.hands; ++i) {
    const DeviceSample& sample = input.sample[i];
    m.counts.insert(m.counts.end(), sample.counts.begin(), sample.counts.begin() + strings[i]);
    m.stamp_ns.push_back(sample.stamp_ns);
    m.age_ticks.push_back(sample.age_ticks);
    m.age_us.push_back(sample.age_us);
    m.lost.push_back(sample.lost);
    m.buttons.push_back(sample.buttons);
    m.link_status.push_back(linkByte(sample));
  }
  m.lost_periods.push_back(lostWord(input));
  m.world_hash.push_back(tick.hash.world);
  m.part_hash.insert(m.part_hash.end(), tick.hash.part.begin(), tick.hash.part.begin() + tick.hash.parts);
  ++m.ticks;
  return true;
}

}  // namespace haptic
