#include "haptic_core/loop/haptic_loop.h"

#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/spidar/spidar.h"

namespace haptic {

HapticLoop::HapticLoop(World& world) : world_(world) {}
HapticLoop::~HapticLoop() = default;

int HapticLoop::attach(Spidar& device, int pointer, const HandSettings& settings) {
  if (count_ == kMaxHands) {
    throw SetupError("haptic loop", "more than " + std::to_string(kMaxHands) + " hands",
                     "detach one, or raise kMaxHands");
  }
  if (pointer < 0 || pointer >= world_.pointerCount()) {
    throw SetupError("hand " + std::to_string(count_),
                     "the scene has no pointer " + std::to_string(pointer) + " (it has " +
                         std::to_string(world_.pointerCount()) + ")",
                     "name one by <haptic:pointer link=... device=...>");
  }
  hands_[count_] = std::make_unique<Hand>(device, pointer, settings, world_.settings().step);
  report_.hands = count_ + 1;
  return count_++;
}

void HapticLoop::detach(int hand) {
  hands_[hand]->letGo(world_);
  for (int i = hand; i + 1 < count_; ++i) hands_[i] = std::move(hands_[i + 1]);
  hands_[--count_].reset();
  report_.hands = count_;
}

void HapticLoop::take(const LoopCommand& command) {
  if (const auto* pause = std::get_if<PauseWorld>(&command.kind)) {
    paused_ = pause->on;
  } else if (isForHand(command)) {
    if (command.hand < 0 || command.hand >= count_) {
      throw SetupError("a command", "names hand " + std::to_string(command.hand) + " of " + std::to_string(count_),
                       "name one that there is");
    }
    if (command.is<DropHand>()) return detach(command.hand);
    hands_[command.hand]->take(command);
  } else if (const auto* change = std::get_if<ChangeBodies>(&command.kind)) {
    const std::shared_ptr<NextWorld> next = nextWorld(*change, world_);
    std::array<int, kMaxHands> link{};
    for (int i = 0; i < count_; ++i) link[i] = world_.pointerLink(hands_[i]->pointer());
    apply({ChangeBodies{change->packed, next}}, world_);
    bodies_ = change->packed;
    for (int i = 0; i < count_; ++i) hands_[i]->followBodies(world_, *next, link[i]);
  } else {
    std::array<int, kMaxHands> link{};
    for (int i = 0; i < count_; ++i) {
      link[i] = world_.pointerLink(hands_[i]->pointer());
      hands_[i]->bear(world_);  // the command may be a step
    }
    apply(command, world_);
    for (int i = 0; i < count_; ++i) hands_[i]->followWorld(world_, link[i], command.is<RestoreWorld>());
  }
}

void HapticLoop::tick(const TickInput& input, double h) noexcept {
  for (int i = 0; i < count_; ++i) hands_[i]->sense(input.sample[i], h, input.lost(h)); // counts → lengths → grip pose
  if (paused_) {
    for (int i = 0; i < count_; ++i) hands_[i]->rest(world_, h);         // poses go on, nothing is asked for
  } else {
    for (int i = 0; i < count_; ++i) hands_[i]->couple(world_, h);       // grip pose → pointer target
    for (int i = 0; i < count_; ++i) hands_[i]->bear(world_);            // no stiffer than the hand bears
    world_.step();                                                       // pairs → volumes → wrenches → motion
    for (int i = 0; i < count_; ++i) hands_[i]->render(world_, h);       // wrench → gain and law → passivity → tensions
  }
  for (int i = 0; i < count_; ++i) report_.hand[i] = hands_[i]->report();
  report_.step = world_.report();
  ++report_.tick;
}

void HapticLoop::tick(const DeviceSample* samples, double h) noexcept {
  TickInput input;
  input.hands = count_;
  for (int i = 0; i < count_; ++i) input.sample[i] = samples[i];
  tick(input, h);
}

bool HapticLoop::presses() const noexcept {
  for (int i = 0; i < count_; ++i) {
    if (hands_[i]->device().presses()) return true;
  }
  return false;
}

const DriveCommand& HapticLoop::drive(int hand) const noexcept {
  return hands_[hand]->drive();
}

}  // namespace haptic
