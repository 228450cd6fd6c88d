/// What happens between ticks, from the loop's thread to the recorder's.
#pragma once
#include "haptic_core/base/record_ring.h"
#include "haptic_core/loop/session.h"

namespace haptic {

/// Each slot keeps the room of its numbers: noting an event of up to `numbers` of them does not allocate. A greater one (a
/// world or a device that a user reset) allocates once per slot.
class EventRing : public RecordRing<LoopEvent> {
 public:
  explicit EventRing(std::size_t capacity, std::size_t numbers) : RecordRing(capacity) {
    LoopEvent event;
    event.numbers.resize(numbers);
    LoopEvent taken;
    for (std::size_t slot = 0; slot <= capacity; ++slot) push(event), pop(taken);
  }
};

}  // namespace haptic
