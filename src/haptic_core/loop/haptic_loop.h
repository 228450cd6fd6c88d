/// The product: counts in, tensions out, the world in between.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "haptic_core/loop/command.h"
#include "haptic_core/loop/tick_input.h"
#include "haptic_core/world/world.h"

namespace haptic {

class Spidar;
class Hand;

/// What one hand measured, asked for and presented in a tick.
struct HandReport {
  Pose X_BG;                       ///< measured grip, in the device's base
  Twist V_BG;                      ///< filtered, at G's origin, in B
  double opening = 0;              ///< 7-DOF grips [m]
  Pose X_WP;                       ///< where the hand wants the pointer
  Wrench F_asked_B;                ///< on the hand at G's origin, in B, as the tensions shall give it
  Wrench F_achieved_B;             ///< wrench of the tensions
  StringVector length;             ///< [m]
  StringVector tension;            ///< [N]
  double pose_residual = 0;        ///< rms of the length errors [m]
  double port_energy = 0;          ///< absorbed at the port since the start [J]
  double stiffness = 0;            ///< of the pointer's contacts, at the grip, as the scene says [N/m]
  double stiffness_share = 1;      ///< of it that the hand is given: below 1 where it could not bear all (world/hand_bound.h)
  double fade = 0;                 ///< 0…1: the gain on the whole wrench
  double dissipated = 0;           ///< by the passivity controller since the start [J]
  unsigned device_flags = 0;       ///< limits and faults: see Spidar
  bool valid = false;              ///< calibrated, and the pose solved
  bool in_contact = false;         ///< the world pushes the pointer
  bool clutched = false;           ///< the pointer stands while the grip moves
  bool passivity_acts = false;     ///< the controller's damper is in F_asked_B
  bool slewed = false;             ///< what is wanted changes faster than F_asked_B may (spidar/force_slew.h)
};

/// What one tick of the loop came to.
struct TickReport {
  /// Ticks since the start, this one included.
  std::uint64_t tick = 0;
  /// Valid entries of `hand`.
  int hands = 0;
  /// By hand, in the order of `attach`.
  std::array<HandReport, kMaxHands> hand;
  /// Of the world.
  StepReport step;
};

/// The closed loop between up to kMaxHands devices and one world. It does no I/O: the caller exchanges with
/// the devices.
class HapticLoop {
 public:
  /// The world must outlive the loop.
  explicit HapticLoop(World& world);
  ~HapticLoop();

  /// Set-up: connects a device to pointer `pointer` of the world; returns the hand's index. Throws SetupError.
  int attach(Spidar& device, int pointer, const HandSettings& settings);
  /// Between two ticks: carries a command out. Throws SetupError when it cannot be done; then nothing has changed.
  void take(const LoopCommand& command);

  /// (in realtime) One tick of `h` [s], no I/O, from its complete input: one sample per attached hand, in order.
  void tick(const TickInput& input, double h) noexcept;

  /// (in realtime) The same for samples alone.
  void tick(const DeviceSample* samples, double h) noexcept;

  /// (in realtime) Some device presents more than a hand feels (0.05 N): who lets go of it waits until the law has taken it away.
  bool presses() const noexcept;

  const DriveCommand& drive(int hand) const noexcept;  ///< for the next exchange
  /// Of the last tick.
  const TickReport& report() const noexcept { return report_; }
  /// Hand i < handCount().
  Hand& hand(int i) noexcept { return *hands_[i]; }
  /// Attached hands.
  int handCount() const noexcept { return count_; }
  /// The world stands, see PauseWorld.
  bool paused() const noexcept { return paused_; }
  /// Contents of the last ChangeBodies; null: the world has the bodies that it was made with.
  const std::shared_ptr<std::vector<double>>& bodies() const noexcept { return bodies_; }
  /// The caller's.
  World& world() noexcept { return world_; }

 private:
  void detach(int hand);
  World& world_;
  std::array<std::unique_ptr<Hand>, kMaxHands> hands_;
  int count_ = 0;
  bool paused_ = false;
  std::shared_ptr<std::vector<double>> bodies_;
  TickReport report_;
};

}  // namespace haptic
