/// One hand: a device on its pointer. Sense → couple → (the world steps) → render.
#pragma once
#include <atomic>

#include "haptic_core/loop/haptic_loop.h"

namespace haptic {

class Hand {
 public:
  Hand(Spidar& device, int pointer, const HandSettings& settings);

  /// (in realtime) Counts → pose; the port's energy is observed on the displacement since the last sample.
  void sense(const DeviceSample& sample, double h) noexcept;
  /// (in realtime) Grip → pointer target. Without a valid pose the pointer stands still.
  void couple(World& world) noexcept;
  /// (in realtime) The pointer's wrench → fade → passivity → the device's limits, tensions and drive.
  void render(const World& world, double h) noexcept;

  /// (in realtime) `periods` ticks were lost: the force drops to 1/(1 + periods) and fades in again.
  void noteOverrun(int periods) noexcept { report_.fade /= 1 + periods; }
  /// Any thread. While held, the pointer stands and the grip moves freely; refused while the pointer is in
  /// contact, for the wrench would jump to that of another place.
  void requestClutch(bool held) noexcept { clutch_requested_.store(held, std::memory_order_relaxed); }
  /// Any thread. The force fades in anew: after a reset or another load of the world.
  void requestSoftStart() noexcept { soft_start_requested_.store(true, std::memory_order_relaxed); }

  const HandReport& report() const noexcept { return report_; }
  const DriveCommand& drive() const noexcept;
  const PassivityController& passivity() const noexcept { return passivity_; }
  const HandSettings& settings() const noexcept { return settings_; }
  Spidar& device() noexcept { return device_; }
  int pointer() const noexcept { return pointer_; }

 private:
  Spidar& device_;
  int pointer_;
  HandSettings settings_;
  WorkspaceMap map_;
  PassivityController passivity_;
  HandReport report_;
  bool was_valid_ = false, in_contact_ = false;
  std::atomic<bool> clutch_requested_{false}, soft_start_requested_{false};
};

}  // namespace haptic
