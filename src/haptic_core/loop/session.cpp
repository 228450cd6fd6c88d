#include "haptic_core/loop/session.h"

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/step_history.h"

namespace haptic {

LoopMemory roomFor(const SessionStart& start, std::size_t world_numbers) {
  LoopMemory memory;
  memory.world_state.reserve(world_numbers);
  memory.world_tuning = WorldTuning::fromNumbers(start.world_tuning);
  for (std::size_t i = 0; i < start.hands.size(); ++i) {
    memory.hand[i].device.reserve(start.hands[i].memory.size());
    memory.hand[i].loop.reserve(Hand::mostMemory(start.hands[i].settings, start.step));
  }
  return memory;
}

void remember(HapticLoop& loop, std::uint64_t tick, LoopMemory& memory) {
  const World& world = loop.world();
  memory.tick = tick;
  memory.world_hash = world.hash();
  world.history().latest().pack(memory.world_state);
  memory.world_tuning = world.tuning();
  memory.bodies = loop.bodies();
  memory.paused = loop.paused();
  memory.hands = loop.handCount();
  for (int i = 0; i < memory.hands; ++i) {
    memory.hand[i].settings = loop.hand(i).settings();
    loop.hand(i).device().save(memory.hand[i].device);
    loop.hand(i).save(memory.hand[i].loop);
  }
}

SessionStart startedAt(const SessionStart& first, const LoopMemory& memory, const std::array<int, kMaxHands>& hands) {
  SessionStart start = first;
  start.first_tick = memory.tick;
  start.world_state = memory.world_state;
  start.world_tuning = memory.world_tuning.numbers();
  start.bodies = memory.bodies ? *memory.bodies : first.bodies;
  start.paused = memory.paused;
  start.hands.clear();
  for (int i = 0; i < memory.hands; ++i) {
    start.hands.push_back(first.hands.at(static_cast<std::size_t>(hands[i])));
    start.hands.back().settings = memory.hand[i].settings;
    start.hands.back().memory = memory.hand[i].device;
    start.hands.back().loop_memory = memory.hand[i].loop;
  }
  return start;
}

SessionReplay::SessionReplay(const WorldDef& scene, const SessionStart& start)
    : world_(start.bodies.empty() ? scene : unpackBodies(start.bodies)), step_(start.step) {
  if (std::fabs(scene.settings.step - start.step) > 1e-12) {
    throw SetupError(scene.name, "has a step of " + std::to_string(1e3 * scene.settings.step) + " ms, the recording one of " +
                                     std::to_string(1e3 * start.step) + " ms", "give the scene the recording's rate");
  }
  world_.tune(WorldTuning::fromNumbers(start.world_tuning));
  world_.restore(start.world_state);
  loop_ = std::make_unique<HapticLoop>(world_);
  for (const SessionStart::HandStart& hand : start.hands) {
    devices_.push_back(std::make_unique<Spidar>(hand.def));
    devices_.back()->restore(hand.memory);
    names_.push_back(hand.device);
    const int index = loop_->attach(*devices_.back(), hand.pointer, hand.settings);
    if (!hand.loop_memory.empty()) loop_->hand(index).restore(hand.loop_memory);
  }
  loop_->take({PauseWorld{start.paused}});
}

void SessionReplay::apply(const LoopCommand& command) {
  if (const auto* change = std::get_if<ChangeBodies>(&command.kind)) {
    loop_->take({ChangeBodies{change->packed, nullptr}});  // `next` was compiled for the recorded world
    return;
  }
  loop_->take(command);
  if (!command.is<DropHand>()) return;
  devices_.erase(devices_.begin() + command.hand);
  names_.erase(names_.begin() + command.hand);
}

const TickHash& SessionReplay::tick(const TickInput& input) noexcept {
  loop_->tick(input, step_);
  hashTick(*loop_, hash_);
  return hash_;
}

std::string SessionReplay::partName(int i) const {
  const int links = hash_.parts - loop_->handCount();
  if (i < links) return "link " + world_.linkName(i);
  if (i - links < static_cast<int>(names_.size())) return "hand of " + names_[i - links];
  return "part " + std::to_string(i);
}

}  // namespace haptic
