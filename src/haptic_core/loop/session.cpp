#include "haptic_core/loop/session.h"

#include <cmath>

#include "haptic_core/base/error.h"
#include "haptic_core/base/fields.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/world/step_history.h"

namespace haptic {
namespace {

template <class T>
std::vector<double> numbersIn(const T& record) {
  std::vector<double> out;
  appendFields(record, out);
  return out;
}

template <class T>
T recordFrom(const std::vector<double>& numbers, const char* what) {
  T record;
  const std::size_t size = countFields(record);
  if (numbers.size() != size) {
    throw SetupError(what, "has " + std::to_string(numbers.size()) + " numbers instead of " + std::to_string(size),
                     "use a recording of this version");
  }
  const double* next = numbers.data();
  readFields(record, next);
  return record;
}

}  // namespace

LoopMemory roomFor(const SessionStart& start, std::size_t world_numbers) {
  LoopMemory memory;
  memory.world_state.reserve(world_numbers);
  memory.world_tuning = WorldTuning::fromNumbers(start.world_tuning);
  for (std::size_t i = 0; i < start.hands.size(); ++i) {
    memory.hand[i].device.reserve(start.hands[i].memory.size());
    memory.hand[i].loop.reserve(Hand::kMemoryNumbers);
  }
  return memory;
}

void remember(HapticLoop& loop, std::uint64_t tick, LoopMemory& memory) {
  const World& world = loop.world();
  memory.tick = tick;
  memory.world_hash = world.hash();
  world.history().latest().pack(memory.world_state);
  memory.world_tuning = world.tuning();
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
  start.hands.clear();
  for (int i = 0; i < memory.hands; ++i) {
    start.hands.push_back(first.hands.at(static_cast<std::size_t>(hands[i])));
    start.hands.back().settings = memory.hand[i].settings;
    start.hands.back().memory = memory.hand[i].device;
    start.hands.back().loop_memory = memory.hand[i].loop;
  }
  return start;
}

std::vector<double> numbersOf(const HandSettings& settings) { return numbersIn(settings); }

HandSettings handSettingsFrom(const std::vector<double>& numbers) {
  return recordFrom<HandSettings>(numbers, "settings of a hand");
}

std::vector<double> numbersOf(const DeviceRequests& requests) { return numbersIn(requests); }

DeviceRequests deviceRequestsFrom(const std::vector<double>& numbers) {
  return recordFrom<DeviceRequests>(numbers, "requests to a device");
}

SessionReplay::SessionReplay(const WorldDef& scene, const SessionStart& start) : world_(scene), step_(start.step) {
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
  requests_.resize(start.hands.size());
}

void SessionReplay::apply(const LoopEvent& event) {
  const bool of_world = event.kind == LoopEvent::Kind::kWorldState || event.kind == LoopEvent::Kind::kWorldTuning;
  if (!of_world && (event.hand < 0 || event.hand >= loop_->handCount())) {
    throw SetupError("event before tick " + std::to_string(event.tick), "names hand " + std::to_string(event.hand) +
                         " of " + std::to_string(loop_->handCount()), "use a recording that is complete");
  }
  switch (event.kind) {
    case LoopEvent::Kind::kWorldState:
      world_.restore(event.numbers);
      break;
    case LoopEvent::Kind::kWorldTuning:
      world_.tune(WorldTuning::fromNumbers(event.numbers));
      break;
    case LoopEvent::Kind::kDeviceState:
      devices_[event.hand]->restore(event.numbers);
      break;
    case LoopEvent::Kind::kHandSettings:
      loop_->hand(event.hand).setSettings(handSettingsFrom(event.numbers));
      break;
    case LoopEvent::Kind::kHandGone:
      loop_->detach(event.hand);
      devices_.erase(devices_.begin() + event.hand);
      names_.erase(names_.begin() + event.hand);
      requests_.erase(requests_.begin() + event.hand);
      break;
    case LoopEvent::Kind::kDeviceRequests:
      requests_[event.hand] = deviceRequestsFrom(event.numbers);
      break;
  }
}

const TickHash& SessionReplay::tick(const TickInput& recorded) noexcept {
  TickInput input = recorded;
  for (std::size_t i = 0; i < requests_.size(); ++i) {
    input.hand[i].device = requests_[i];
    requests_[i] = DeviceRequests{};
  }
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
