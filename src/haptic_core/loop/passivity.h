/// Passivity observer and controller at the port between hand and device, in six degrees of freedom.
///
/// Observer (Hannaford & Ryu 2002). Commands and counts travel in one exchange: what tick n asks for acts from sample
/// n + 1 to sample n + 2. Over that interval the tensions t_n are held, so the energy that the loop absorbs is exactly
///     E_{n+2} = E_{n+1} + t_n·Δl,
/// Δl the change of the strings' lengths between the two samples. (The wrench of tick n times the grip's displacement
/// would miss the energy that the strings' geometry, two samples late, gives away: 0.1 N·s/m of negative damping.) The port has been
/// passive as long as E ≥ 0.
///
/// Counts. A string that trembles on the edge of a count seems to move by a whole one, q, each time; and as the controller
/// gives force while a count goes one way and takes it back while it goes the other, each tremble would be credited t·q
/// that no hand has given. So E is summed twice, and the lower sum counts: with the lengths of the counts, and with the
/// lengths that go on at their last rate as long as the counts allow, l_n = clamp(2 l_{n-1} - l_{n-2}, counts ± q/2), for
/// which a tremble on an edge is none. What both do not see, about one count, the controller keeps in reserve: it acts as
/// if E were lower by q · 1 N.
///
/// Controller. The grip, M = m diag(⅖r²,⅖r²,⅖r²,1,1,1), is expected to follow the strings: a wrench F held from velocity V
/// on gives F·V h + ½ h² Fᵀ M⁻¹ F. The second part matters: a light grip turns within a tick, and a controller that
/// forgets it pushes at the moments that feed the vibration. Where the interval that has begun and the next one together
/// would give more than E less the reserve, first a damper α (m/M) V is added to F_n, α ≤ α_max just large enough; α_max
/// keeps the sampled damper itself stable, for on the grip it rings above α h / m = 1. Where that is not enough, F_n is
/// scaled down to the energy that is left, to zero if need be: no force gives no energy.
#pragma once
#include "haptic_core/base/spatial.h"
#include "haptic_core/spidar/device_def.h"

namespace haptic {

/// Mode of the port.
enum class PassivityMode : unsigned char {
  kOff,      ///< the loop gives the scene's force, whatever a hand bears: for experiments
  kObserve,  ///< energy is counted, and contacts stiffer than a hand bears are weakened (world/hand_bound.h)
  kAct       ///< the controller acts as well
};

/// Settings of the observer and the controller at a hand's port.
struct PassivitySettings {
  /// Observing alone changes no force.
  PassivityMode mode = PassivityMode::kObserve;
  double radius = 0.02;       ///< r [m]: weighs rotation against translation, about the grip's size
  double max_damping = 20;    ///< α_max [N·s/m]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.mode), visit(s.radius), visit(s.max_damping);
  }
};

/// Passivity observer and controller of one hand's port. A tick calls `observe`, `act` and `hold`, in this
/// order.
class PassivityController {
 public:
  /// `grip_mass` [kg]: of the grip alone; a hand that holds it only makes it heavier. `quantum` [m]: q, what one count is
  /// of each string's length.
  PassivityController(const PassivitySettings& settings, double grip_mass, const StringVector& quantum)
      : settings_(settings), grip_mass_(grip_mass), quantum_(quantum) {
    start(StringVector::Zero(quantum.size()));
    before_.tension = in_strings_.tension = next_.tension = counted_;
  }
  void setSettings(const PassivitySettings& settings) { settings_ = settings; }  ///< between two ticks

  /// (in realtime) The strings' lengths at the first sample, or the first after some that told nothing [m].
  void start(const StringVector& length) noexcept;
  /// (in realtime) The strings' lengths at this sample, one period after the last [m].
  void observe(const StringVector& length) noexcept;

  /// (in realtime) The wrench to ask for, `F_B` or less than it: held over `h` [s] from the next sample on. `V_BG` is the
  /// mean velocity since the last sample: a filter's lag would have the controller push where the hand has turned.
  Wrench act(const Wrench& F_B, const Twist& V_BG, double h) noexcept;

  /// (in realtime) The wrench that the device will present instead: the energy is counted with it.
  void hold(const Wrench& F_achieved_B, const StringVector& tension) noexcept;

  /// All but the settings.
  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.counted_), visit(s.smooth_), visit(s.advance_), visit(s.before_), visit(s.in_strings_), visit(s.next_);
    visit(s.counted_energy_), visit(s.smooth_energy_), visit(s.energy_), visit(s.lowest_), visit(s.dissipated_);
    visit(s.acting_);
  }

  double energy() const { return energy_; }          ///< E [J], absorbed since the start
  double lowestEnergy() const { return lowest_; }    ///< min over time of E [J]
  double dissipated() const { return dissipated_; }  ///< by the controller [J]
  /// The damper or the scaling was at work in the last tick.
  bool acting() const { return acting_; }

 private:
  Twist response(const Wrench& F_B, double dt) const noexcept;  ///< M⁻¹ F dt
  double reserve() const noexcept;                              ///< [J]

  PassivitySettings settings_;
  double grip_mass_;
  StringVector quantum_;   ///< [m]
  StringVector counted_;   ///< lengths of the counts at the last sample [m]
  StringVector smooth_;    ///< the same, going on at the last rate [m]
  StringVector advance_;   ///< of `smooth_` in the last interval [m]
  struct Held {
    Wrench F_B;
    StringVector tension;  ///< [N]

    template <class Self, class Visit>
    static void eachField(Self& s, Visit&& visit) {
      visit(s.F_B), visit(s.tension);
    }
  };
  Held before_;      ///< between the last two samples
  Held in_strings_;  ///< since the last sample
  Held next_;        ///< goes out with the next exchange
  double counted_energy_ = 0, smooth_energy_ = 0;
  double energy_ = 0, lowest_ = 0, dissipated_ = 0;
  bool acting_ = false;
};

}  // namespace haptic
