/// Energy that nobody put in, by the definition of `energy.gain_rel`.
#pragma once
#include <algorithm>
#include <cmath>

#include "haptic_core/world/report.h"

namespace haptic::bench {

/// Positive part of E(t) - E(0) - W(t) + D(t), beside the largest energy exchanged: of the changes of kinetic, potential,
/// elastic and tangential energy, |W| and D.
class EnergyGain {
 public:
  void look(const EnergyLedger& e) {
    if (!started_) first_ = e;
    started_ = true;
    const double dissipated = std::max(0.0, e.damping + e.friction - first_.damping - first_.friction);
    const double external = e.external - first_.external;
    exchanged_ = std::max({exchanged_, std::abs(e.kinetic - first_.kinetic), std::abs(e.potential - first_.potential),
                           std::abs(e.elastic - first_.elastic), std::abs(e.tangential - first_.tangential), std::abs(external),
                           dissipated});
    const double rounding =
        1e-13 * (e.kinetic + std::abs(e.potential) + e.elastic + e.tangential + std::abs(external) + dissipated);
    const double gain = e.total() - first_.total() - external + dissipated - rounding;
    largest_ = std::max(largest_, gain);
    if (exchanged_ > 0) worst_ = std::max(worst_, gain / exchanged_);
  }
  double worst() const { return worst_; }  ///< over what was exchanged so far: as defined
  /// Over what the whole run exchanged: a run that begins at rest has next to nothing to compare with at first.
  double worstOfRun() const { return exchanged_ > 0 ? largest_ / exchanged_ : 0; }

 private:
  EnergyLedger first_;
  bool started_ = false;
  double exchanged_ = 0, worst_ = 0, largest_ = 0;
};

}  // namespace haptic::bench
