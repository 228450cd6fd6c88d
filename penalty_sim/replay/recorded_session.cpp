#include "replay/recorded_session.h"

#include <haptic_msgs/LoopEvent.h>
#include <haptic_msgs/SessionInfo.h>
#include <haptic_msgs/TickRecord.h>

#include <algorithm>
#include <boost/make_shared.hpp>

#include "haptic_core/base/build_info.h"
#include "haptic_core/base/error.h"
#include "replay/bag_reader.h"

namespace haptic {
namespace {

void refuse(const std::string& bag, const std::string& what, const std::string& remedy) { throw SetupError(bag, what, remedy); }

void checkFormat(const std::string& bag, const haptic_msgs::SessionInfo& info) {
  if (info.version == info.VERSION) return;
  refuse(bag, "was recorded in format " + std::to_string(info.version) + ", this program reads " + std::to_string(info.VERSION),
         "replay it with " + info.program);
}

RecordedSession begin(const std::string& bag, const haptic_msgs::SessionInfo& info) {
  RecordedSession s;
  s.scene = info.scene;
  s.scene_file = info.scene_file;
  s.scene_text = info.scene_text;
  s.fingerprint = info.scene_fingerprint;
  s.world_hash = info.world_hash;
  s.rate = info.rate;
  s.default_density = info.default_density;
  s.program = info.program;
  s.build = info.build;
  s.same_bits = sameBits(info.program, info.build);
  s.links = info.links;
  s.device_texts = info.device_texts;
  s.start.first_tick = info.first_tick;
  s.start.step = 1 / info.rate;
  s.start.world_state = info.world_state;
  s.start.world_tuning = info.world_tuning;
  s.start.bodies = info.bodies;
  s.start.paused = info.paused;
  const std::size_t hands = info.devices.size();
  const bool fits = hands > 0 && hands <= kMaxHands && info.device_texts.size() == hands && info.pointers.size() == hands &&
                    info.device_memory_sizes.size() == hands && info.hand_memory_sizes.size() == hands &&
                    info.hand_settings.size() % hands == 0 && info.rate > 0;
  if (!fits) refuse(bag, "its session does not say which hands it has", "record again");
  const std::size_t per_hand = info.hand_settings.size() / hands;
  std::size_t device_used = 0, hand_used = 0;
  const auto taken = [&](const std::vector<double>& from, std::size_t& used, std::size_t size) {
    if (size > from.size() - used) refuse(bag, "its session is cut short", "record again");
    const auto begin = from.begin() + static_cast<std::ptrdiff_t>(used);
    used += size;
    return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(size));
  };
  for (std::size_t i = 0; i < hands; ++i) {
    SessionStart::HandStart hand;
    hand.device = info.devices[i];
    hand.pointer = info.pointers[i];
    const auto first = info.hand_settings.begin() + static_cast<std::ptrdiff_t>(i * per_hand);
    hand.settings = handSettingsFrom({first, first + static_cast<std::ptrdiff_t>(per_hand)});
    hand.memory = taken(info.device_memory, device_used, info.device_memory_sizes[i]);
    hand.loop_memory = taken(info.hand_memory, hand_used, info.hand_memory_sizes[i]);
    s.start.hands.push_back(hand);
  }
  return s;
}

/// Encoder channels of each hand from its description's count of strings, which stands first in its memory.
std::vector<std::uint32_t> channelsOf(const SessionStart& start) {
  std::vector<std::uint32_t> channels;
  for (const SessionStart::HandStart& hand : start.hands) {
    channels.push_back(hand.memory.empty() ? 0 : static_cast<std::uint32_t>(hand.memory[0]));
  }
  return channels;
}

bool sizesFit(const haptic_msgs::TickRecord& m) {
  const std::size_t ticks = m.ticks, by_hand = ticks * m.hands;
  return m.hands <= kMaxHands && m.parts <= TickHash::kMaxParts && m.counts.size() == ticks * m.channels &&
         m.stamp_ns.size() == by_hand && m.age_ticks.size() == by_hand && m.age_us.size() == by_hand &&
         m.lost.size() == by_hand && m.buttons.size() == by_hand &&
         m.link_status.size() == by_hand &&
         m.lost_periods.size() == ticks && m.world_hash.size() == ticks && m.part_hash.size() == ticks * m.parts;
}

void addRun(const std::string& bag, const haptic_msgs::TickRecord& m, const std::vector<std::uint32_t>& channels,
            RecordedSession& session) {
  const std::uint64_t next = session.start.first_tick + session.ticks.size();
  if (m.first_tick != next) {
    refuse(bag, "ticks " + std::to_string(next) + " to " + std::to_string(m.first_tick) + " are missing",
           "the recorder could not keep up: record fewer topics, or to a faster disk");
  }
  std::uint32_t all = 0;
  for (const std::uint32_t n : channels) all += n;
  if (!sizesFit(m) || m.hands != channels.size() || m.channels != all || all == 0) {
    refuse(bag, "its ticks at " + std::to_string(m.first_tick) + " have no encoder counts that fit the devices", "record again");
  }
  for (std::uint32_t t = 0; t < m.ticks; ++t) {
    TickInput input;
    input.tick = m.first_tick + t;
    takeLostWord(m.lost_periods[t], input);
    input.hands = static_cast<int>(m.hands);
    std::size_t channel = static_cast<std::size_t>(t) * m.channels;
    for (std::uint32_t h = 0; h < m.hands; ++h) {
      const std::size_t at = static_cast<std::size_t>(t) * m.hands + h;
      DeviceSample& sample = input.sample[h];
      for (std::uint32_t c = 0; c < channels[h]; ++c) sample.counts[c] = m.counts[channel++];
      sample.stamp_ns = m.stamp_ns[at];
      sample.age_ticks = m.age_ticks[at];
      sample.age_us = m.age_us[at];
      sample.lost = m.lost[at];
      sample.buttons = m.buttons[at];
      takeLinkByte(m.link_status[at], sample);
    }
    session.ticks.push_back(input);
    session.periods += 1 + static_cast<std::uint64_t>(input.lost_periods);
    TickHash hash;
    hash.world = m.world_hash[t];
    hash.parts = static_cast<int>(m.parts);
    const auto part = m.part_hash.begin() + static_cast<std::ptrdiff_t>(t) * m.parts;
    std::copy(part, part + m.parts, hash.part.begin());
    session.hashes.push_back(hash);
  }
  session.clock.push_back({session.ticks.size(), m.header.stamp.toSec() - static_cast<double>(session.periods) * session.start.step});
}

struct Messages {
  std::vector<haptic_msgs::SessionInfo::ConstPtr> sessions;
  std::vector<haptic_msgs::LoopEvent::ConstPtr> events;
  std::vector<haptic_msgs::TickRecord::ConstPtr> runs;
};

template <class Message>
typename Message::ConstPtr unpacked(std::string& bytes) {
  const auto message = boost::make_shared<Message>();
  ros::serialization::IStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::deserialize(stream, *message);
  return message;
}

Messages readMessages(const std::string& path) {
  Messages messages;
  const std::vector<RecordedKind> kinds{kindOf<haptic_msgs::SessionInfo>("recorded/session"),
                                        kindOf<haptic_msgs::LoopEvent>("recorded/events"),
                                        kindOf<haptic_msgs::TickRecord>("recorded/ticks")};
  const std::size_t others = readBag(path, kinds, [&](std::size_t kind, std::string& bytes) {
    if (kind == 0) messages.sessions.push_back(unpacked<haptic_msgs::SessionInfo>(bytes));
    if (kind == 1) messages.events.push_back(unpacked<haptic_msgs::LoopEvent>(bytes));
    if (kind == 2) messages.runs.push_back(unpacked<haptic_msgs::TickRecord>(bytes));
  });
  if (messages.sessions.empty() && messages.runs.empty() && others > 0) {
    refuse(path, "its recorded/ messages are of another version", "replay it with the program that recorded it");
  }
  if (messages.sessions.empty() || messages.runs.empty()) {
    refuse(path, "holds no encoder counts", "record with ./run demo --record, or with record:=BAG of the launch file");
  }
  return messages;
}

}  // namespace

std::vector<RecordedSession> readSessions(const std::string& bag) {
  Messages messages = readMessages(bag);
  // Messages of different topics may have crossed on their way into the bag; ticks tell the order.
  const auto by_first_tick = [](const auto& a, const auto& b) { return a->first_tick < b->first_tick; };
  std::stable_sort(messages.sessions.begin(), messages.sessions.end(), by_first_tick);
  std::stable_sort(messages.runs.begin(), messages.runs.end(), by_first_tick);
  std::stable_sort(messages.events.begin(), messages.events.end(), [](const auto& a, const auto& b) { return a->tick < b->tick; });
  std::vector<RecordedSession> sessions;
  auto run = messages.runs.begin();
  auto event = messages.events.begin();
  for (std::size_t i = 0; i < messages.sessions.size(); ++i) {
    checkFormat(bag, *messages.sessions[i]);
    const std::uint64_t end = i + 1 < messages.sessions.size() ? messages.sessions[i + 1]->first_tick : UINT64_MAX;
    RecordedSession session = begin(bag, *messages.sessions[i]);
    std::vector<std::uint32_t> channels = channelsOf(session.start);
    for (; event != messages.events.end() && (*event)->tick < end; ++event) {
      session.events.push_back({(*event)->tick, commandFrom((*event)->kind, (*event)->hand, (*event)->numbers)});
    }
    auto gone = session.events.begin();
    for (; run != messages.runs.end() && (*run)->first_tick < end; ++run) {
      for (; gone != session.events.end() && gone->tick <= (*run)->first_tick; ++gone) {
        if (!gone->command.is<DropHand>()) continue;
        if (gone->command.hand < 0 || gone->command.hand >= static_cast<int>(channels.size())) {
          refuse(bag, "loses a hand that it has not", "record again");
        }
        channels.erase(channels.begin() + gone->command.hand);
      }
      addRun(bag, **run, channels, session);
    }
    if (!session.ticks.empty()) sessions.push_back(std::move(session));
  }
  if (sessions.empty()) refuse(bag, "holds no encoder counts", "record with ./run demo --record");
  return sessions;
}

}  // namespace haptic
