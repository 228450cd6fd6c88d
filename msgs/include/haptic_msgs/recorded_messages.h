/// From the loop's recordings to messages.
#pragma once
#include <haptic_msgs/LoopEvent.h>
#include <haptic_msgs/TickRecord.h>

#include <vector>

#include "haptic_core/loop/command.h"
#include "haptic_core/loop/tick_hash.h"
#include "haptic_core/loop/tick_input.h"

namespace haptic {

/// Without a stamp.
inline haptic_msgs::LoopEvent toLoopEvent(const LoopEvent& event) {
  haptic_msgs::LoopEvent m;
  m.tick = event.tick;
  m.kind = static_cast<std::uint8_t>(event.command.kind.index());
  m.hand = event.command.hand;
  m.numbers = numbersOf(event.command);
  return m;
}

/// Adds a tick to the run in `m`; `strings`: of each hand's device. False: it does not belong there (other hands, or not the next tick).
inline bool addTick(const TickInput& input, const TickHash& hash, const std::vector<int>& strings, haptic_msgs::TickRecord& m) {
  const auto hands = static_cast<std::uint32_t>(input.hands), parts = static_cast<std::uint32_t>(hash.parts);
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
    const DeviceSample& sample = input.sample[static_cast<std::size_t>(i)];
    m.counts.insert(m.counts.end(), sample.counts.begin(), sample.counts.begin() + strings[static_cast<std::size_t>(i)]);
    m.stamp_ns.push_back(sample.stamp_ns);
    m.age_ticks.push_back(sample.age_ticks);
    m.age_us.push_back(sample.age_us);
    m.lost.push_back(sample.lost);
    m.buttons.push_back(sample.buttons);
    m.link_status.push_back(linkByte(sample));
  }
  m.lost_periods.push_back(lostWord(input));
  m.world_hash.push_back(hash.world);
  m.part_hash.insert(m.part_hash.end(), hash.part.begin(), hash.part.begin() + hash.parts);
  ++m.ticks;
  return true;
}

}  // namespace haptic
