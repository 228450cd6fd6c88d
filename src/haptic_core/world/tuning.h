/// What may change about a world while it runs, between two steps. Not part of the state: a reset keeps it.
#pragma once
#include <limits>
#include <vector>

#include "haptic_core/world/definition.h"

namespace haptic {

/// Values of a world that may change while it runs.
struct WorldTuning {
  double stiffness_scale = 1;  ///< of k and k_t of every pair, 0.01…10
  double friction_scale = 1;   ///< of μ0 and μ of every pair, 0…3
  Vector3 gravity = Vector3::Constant(std::numeric_limits<double>::quiet_NaN());  ///< [m/s²] in W; NaN: as it is now
  double budget = 0;           ///< of a step, in counted work (world/counted_work.h) [units]; 0: none
  std::vector<PointerCoupling> coupling;  ///< per pointer

  std::vector<double> numbers() const;                    ///< for recordings
  /// Throws SetupError when they are not as `numbers` gives them.
  static WorldTuning fromNumbers(const std::vector<double>& numbers);

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.stiffness_scale), visit(s.friction_scale), visit(s.gravity), visit(s.budget), visit(s.coupling);
  }
};

/// Inertia that a virtual coupling pulls at.
struct CouplingLoad {
  double mass = 0;           ///< of the pointer's link [kg]
  double least_inertia = 0;  ///< [kg·m²]
};

/// Throws SetupError naming value and bounds. A virtual coupling is an explicit spring-damper: of the bound
/// k h²/m + 2 b h/m < 4 at most a quarter is allowed, because contacts need the rest; `h` is the step [s].
void check(const WorldTuning& tuning, const std::vector<CouplingLoad>& loads, double h);

/// (in realtime) The coupling with nothing left to derive: of a critically damped spring with (ωh)² + 4 ωh = 1,
/// ω = 0.236/h. With `cap`, values that the link cannot bear are scaled down: a lighter one that was grabbed.
PointerCoupling resolved(const PointerCoupling& coupling, const CouplingLoad& load, double h, bool cap) noexcept;

}  // namespace haptic
