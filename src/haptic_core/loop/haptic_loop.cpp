#include "haptic_core/loop/haptic_loop.h"

#include "haptic_core/base/error.h"
#include "haptic_core/loop/hand.h"

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
  hands_[count_] = std::make_unique<Hand>(device, pointer, settings);
  report_.hands = count_ + 1;
  return count_++;
}

void HapticLoop::tick(const DeviceSample* samples, double h) noexcept {
  for (int i = 0; i < count_; ++i) hands_[i]->sense(samples[i], h);  // counts → lengths → grip pose
  for (int i = 0; i < count_; ++i) hands_[i]->couple(world_);        // grip pose → pointer target
  world_.step();                                                     // pairs → volumes → wrenches → motion
  for (int i = 0; i < count_; ++i) hands_[i]->render(world_, h);     // wrench → passivity → tensions
  for (int i = 0; i < count_; ++i) report_.hand[i] = hands_[i]->report();
  report_.step = world_.report();
  ++report_.tick;
}

void HapticLoop::noteOverrun(int periods) noexcept {
  for (int i = 0; i < count_; ++i) hands_[i]->noteOverrun(periods);
}

const DriveCommand& HapticLoop::drive(int hand) const noexcept {
  return hands_[hand]->drive();
}

}  // namespace haptic
