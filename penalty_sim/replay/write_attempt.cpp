// A reduced session as a bag.
#include <haptic_msgs/SessionInfo.h>
#include <haptic_msgs/recorded_messages.h>
#include <rosbag/bag.h>

#include "haptic_core/base/build_info.h"
#include "haptic_core/base/error.h"
#include "replay/shrink.h"

namespace haptic {
namespace {

constexpr std::uint32_t kTicksPerMessage = 64;  // as the recorder has them

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

/// Where the bodies are packed, the file's text is not needed: one that is a few bytes stands for it.
void nameScene(const ShrinkAttempt& attempt, const RecordedSession& like, haptic_msgs::SessionInfo& m) {
  m.scene = like.scene;
  m.scene_file = like.scene_file;
  m.scene_text = like.scene_text;
  m.scene_fingerprint = like.fingerprint;
  if (attempt.start.bodies.empty()) return;
  m.scene_file = like.scene + "_shrunk.urdf";
  m.scene_text = "<robot name=\"" + like.scene + "\"><link name=\"world\"/><link name=\"none\"/><joint name=\"none\" type=\"fixed\">"
                 "<parent link=\"world\"/><child link=\"none\"/></joint></robot>\n";
  SceneOptions options;
  options.default_density = like.default_density;
  options.step = attempt.start.step;
  options.text = m.scene_text;
  m.scene_fingerprint = fingerprint(loadScene(m.scene_file, options).world);
}

haptic_msgs::SessionInfo sessionInfo(const ShrinkAttempt& attempt, const RecordedSession& like, std::uint64_t world_hash) {
  haptic_msgs::SessionInfo m;
  m.header.stamp = ros::Time(1);
  m.version = m.VERSION;
  m.program = programVersion();
  m.build = buildFlags();
  nameScene(attempt, like, m);
  m.default_density = like.default_density;
  m.rate = like.rate;
  m.first_tick = attempt.start.first_tick;
  m.links = linkNames(attempt.scene.world);
  m.device_texts = like.device_texts;
  for (const SessionStart::HandStart& hand : attempt.start.hands) {
    m.devices.push_back(hand.device);
    m.pointers.push_back(hand.pointer);
    append(m.hand_settings, numbersOf(hand.settings));
    append(m.device_memory, hand.memory);
    m.device_memory_sizes.push_back(static_cast<std::uint32_t>(hand.memory.size()));
    append(m.hand_memory, hand.loop_memory);
    m.hand_memory_sizes.push_back(static_cast<std::uint32_t>(hand.loop_memory.size()));
  }
  m.world_state = attempt.start.world_state;
  m.world_hash = world_hash;
  m.world_tuning = attempt.start.world_tuning;
  m.bodies = attempt.start.bodies;
  m.paused = attempt.start.paused;
  return m;
}

std::vector<int> stringsOf(const SessionStart& start) {
  std::vector<int> strings;
  for (const SessionStart::HandStart& hand : start.hands) strings.push_back(static_cast<int>(hand.def.strings.size()));
  return strings;
}

}  // namespace

void writeAttempt(const ShrinkAttempt& attempt, const RecordedSession& like, bool recorded_hashes, const std::string& path) {
  SessionReplay replay(attempt.scene.world, attempt.start);
  const std::uint64_t world_hash = replay.world().hash();
  try {
    rosbag::Bag bag(path, rosbag::bagmode::Write);
    bag.setCompression(rosbag::compression::LZ4);
    const ros::Time stamp(1);
    bag.write("recorded/session", stamp, sessionInfo(attempt, like, world_hash));
    std::vector<int> strings = stringsOf(attempt.start);
    haptic_msgs::TickRecord run;
    const auto publish = [&] {
      run.header.stamp = stamp;
      if (run.ticks > 0) bag.write("recorded/ticks", stamp, run);
      run = haptic_msgs::TickRecord();
    };
    std::size_t event = 0;
    for (std::size_t t = 0; t < attempt.ticks.size(); ++t) {
      for (; event < attempt.events.size() && attempt.events[event].tick <= attempt.ticks[t].tick; ++event) {
        const LoopEvent& e = attempt.events[event];
        replay.apply(e.command);
        if (e.command.is<DropHand>()) publish(), strings.erase(strings.begin() + e.command.hand);
        haptic_msgs::LoopEvent message = toLoopEvent(e);
        message.header.stamp = stamp;
        bag.write("recorded/events", stamp, message);
      }
      const TickHash hash = replay.tick(attempt.ticks[t]);
      const TickHash& kept = recorded_hashes ? attempt.hashes[t] : hash;
      if (run.ticks < kTicksPerMessage && addTick(attempt.ticks[t], kept, strings, run)) continue;
      publish();
      addTick(attempt.ticks[t], kept, strings, run);
    }
    publish();
    bag.close();
  } catch (const rosbag::BagException& error) {
    throw SetupError(path, std::string("cannot be written: ") + error.what(), "name a file in a folder that is writable");
  }
}

}  // namespace haptic
