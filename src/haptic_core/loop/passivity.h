/// Passivity observer and controller at the port between hand and device, in six degrees of freedom.
///
/// Observer (Hannaford & Ryu 2002). The wrench F on the hand is held over a tick, so the energy that the loop
/// absorbs in it is exactly -F·ΔX with ΔX the grip's displacement between two samples:
///     E_n = E_{n-1} - F_{n-1}·ΔX_n.
/// The port has been passive as long as E ≥ 0.
///
/// Controller. The tick to come is expected to absorb -F·V h. Where E would fall below zero, a damper
/// α M V is added with M = diag(r²,r²,r²,1,1,1) and α just large enough:
///     α = (deficit) / (h Vᵀ M V),  α ≤ α_max.
/// α_max keeps the sampled damper itself stable: a damper of coefficient α on the grip's mass m at step h rings
/// above α h / m = 1. What the cap leaves is carried over to the next ticks.
#pragma once
#include "haptic_core/base/spatial.h"

namespace haptic {

enum class PassivityMode : unsigned char { kOff, kObserve, kAct };

struct PassivitySettings {
  PassivityMode mode = PassivityMode::kObserve;
  double radius = 0.02;       ///< r [m]: weighs rotation against translation, about the grip's size
  double max_damping = 20;    ///< α_max [N·s/m]
};

class PassivityController {
 public:
  explicit PassivityController(const PassivitySettings& settings) : settings_(settings) {}
  void setSettings(const PassivitySettings& settings) { settings_ = settings; }  ///< between two ticks

  /// (in realtime) The displacement of the grip since the last sample, at G's origin, in B: [rad], [m].
  void observe(const Vector3& rotation, const Vector3& translation) noexcept;

  /// (in realtime) The wrench to be held over the next tick of `h` [s]: `F_B`, with the damper added when it acts.
  Wrench act(const Wrench& F_B, const Twist& V_BG, double h) noexcept;

  /// (in realtime) What the device really gives: the energy of the next tick is counted with it.
  void hold(const Wrench& F_achieved_B) noexcept { held_ = F_achieved_B; }

  double energy() const { return energy_; }          ///< E [J], absorbed since the start or the last reset
  double lowestEnergy() const { return lowest_; }    ///< min over time of E [J]
  double dissipated() const { return dissipated_; }  ///< by the controller [J]
  bool acting() const { return acting_; }
  void reset() noexcept;

 private:
  PassivitySettings settings_;
  Wrench held_;
  double energy_ = 0, lowest_ = 0, dissipated_ = 0;
  bool acting_ = false;
};

}  // namespace haptic
