/// The energy ledger: where the energy is, where it went. An observer: given wrenches, twists and memories, it books; no
/// stage of the step reads its books.
///
/// A contact takes from its bodies the work of its impulses: impulse times the mean of the velocities before and after, which is the
/// bodies' loss, to rounding, however much one step stops them (stepping/step_books.h). Energy that the bodies
/// lost to the springs and the springs did not gain is dissipated; for the normal springs the difference is named
/// `turning`, for k Vol n has no potential while n turns.
///
/// A hand that prescribes the motion of a link supplies the energy that the link's contacts take from it. Of a contact in which nothing
/// moves by itself that is the mean of its force at both ends times the way that it was led: of second order, as springs are.
#pragma once
#include <vector>

#include "haptic_core/base/sum_tree.h"
#include "haptic_core/geometry/volume/loaded_vector.h"
#include "haptic_core/world/contact_evaluation.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/visits.h"

namespace haptic {

/// Energies by tree, so that what sleeps is not summed anew. Pairs count with A's tree, or with B's where A's never moves.
struct LedgerSums {
  /// [J], see EnergyLedger.
  enum Column : unsigned char { kKinetic, kPotential, kElastic, kTangential, kColumns };
  std::vector<SumTree<kColumns>::Row> now;  ///< by tree: scratch of one sum
  SumTree<kColumns> tree;                   ///< by tree
  explicit LedgerSums(const Model& model) : now(model.trees.size()), tree(model.trees.size()) {}  ///< set-up
};

/// Inputs of the books.
struct LedgerView {
  const Model& model;     ///< constant
  const Visits& visits;   ///< what may have changed
  const HandWork& hands;  ///< which links hands hold, and how they moved
  Placement& placement;  ///< velocities of links are set for a booking, and set back to the state's
  LedgerSums& sums;      ///< of energies
};

/// (in realtime) A contact in which nothing moves by itself, over a part of h [s]: as it was before, and as the pair has it now. Hands and
/// belts supply all that it takes. X_WP: of the patch.
void bookLed(const LedgerView& view, double h, const ActivePair& pair, const FrictionMemory& before, const LedForce& last,
             const Pose& X_WP, State& state) noexcept;

/// Of what moves by itself [J].
struct MechanicalEnergy {
  double kinetic = 0, potential = 0;  ///< of motion; of gravity
};
/// (in realtime) Energies of all, of what sleeps as they were.
const SumTree<LedgerSums::kColumns>::Row& sumEnergies(const LedgerView& view, const State& state) noexcept;
/// (in realtime) As the placement has it, summed over all movers: between two steps.
MechanicalEnergy mechanicalEnergy(const Model& model, const HandWork& hands, const Placement& placement, const double* q) noexcept;

/// (in realtime) Energies now and sums so far; the balance's loss since the last step is the time step's. `unaccounted`:
/// EnergySums::unaccounted before the step. Where the balance is taken anew, springs that were loaded before
/// enter it, and the supply.
EnergyLedger closeLedger(const LedgerView& view, double unaccounted, State& state) noexcept;

}  // namespace haptic
