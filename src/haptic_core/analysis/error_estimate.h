/// How far a running world is from the exact motion of its own model: step doubling on shadow worlds, beside the loop.
///
/// Two shadows start from the same saved state, and each hand goes on with the twist that it has there. One makes n steps
/// of h, as the running world would, bit for bit; the other covers the same time in steps of h/2. With a scheme of order
/// p the error of the first is (Richardson; Hairer, Nørsett, Wanner, Solving Ordinary Differential Equations I, II.4)
///     e ≈ |y_h - y_{h/2}| / (1 - 2^-p).
/// p is the scheme's: 1 for the Euler steps, with a hand, whose motion SDIRK2's stages do not see, and wherever a
/// joint has laws of its own (stepping/flow.h); 2 else. The wrench that a
/// hand gets is one value per step, held: of order 1 under every scheme.
///
/// The error of the model itself (foundation, tessellation, material) is not in it. Where a contact begins or ends inside
/// the window the order is lost for that window, and the number tells the size only.
///
/// Cost: 3 n steps.
#pragma once
#include <cmath>
#include <memory>
#include <vector>

#include "haptic_core/world/definition.h"
#include "haptic_core/world/hand_bound.h"
#include "haptic_core/world/tuning.h"

namespace haptic {

/// Errors at the end of the window, of the world stepped with h. NaN: a shadow lost a number, or nothing was estimated.
struct ErrorEstimate {
  int steps = 0;                       ///< n, of the window
  int order = 0;                       ///< p of positions and energy
  double position = std::nan("");      ///< greatest of any link's origin [m]
  double rotation = std::nan("");      ///< greatest of any link [rad]
  int link = -1;                       ///< with the greatest position error; -1: nothing moves
  double energy = std::nan("");        ///< of EnergyLedger::total() [J]; NaN: the world keeps no ledger
  std::vector<double> force, torque;   ///< per pointer, of the wrench that its hand gets: norms [N], [N·m]
};

/// Estimates the error of a running world by step doubling.
/// Shadows of one definition. Allocates; for a thread that may. Not shared between threads.
class ErrorEstimator {
 public:
  /// Long enough for the error of many steps to show over that of one, short enough for a hand to keep its twist.
  static constexpr int kWindowSteps = 16;

  /// Throws SetupError as World does.
  explicit ErrorEstimator(const WorldDef& def, int window_steps = kWindowSteps);
  ~ErrorEstimator();

  /// `state` is World::save() of a world of this definition with this tuning; `bounds` is what its hands bear
  /// (World::pointerBound), by pointer; empty: anything. Throws SetupError when the state is of another world.
  ErrorEstimate estimate(const std::vector<double>& state, const WorldTuning& tuning, const std::vector<PointerBound>& bounds = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace haptic
