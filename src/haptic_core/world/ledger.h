/// The energy ledger: where the energy is, where it went. An observer: given wrenches, twists and memories, it books; no
/// stage of the step reads its books.
///
/// A contact takes from its bodies the work of its impulses: impulse times the mean of the velocities before and
/// after, which is the bodies' loss, to rounding, however much one step stops them. Velocity Verlet kicks twice
/// between two evaluations: with the last force (its work is known from that evaluation's power and the power's rate) and
/// with the new one. Trees whose joints have laws are pulled at by the last force alone, over the whole step. Energy that the bodies
/// lost to the springs and the springs did not gain is dissipated; for the normal springs the difference is named
/// `turning`, for k Vol n has no potential while n turns.
///
/// A hand that prescribes the motion of a link supplies the energy that the link's contacts take from it: their mean wrench over the
/// step, as they report it, times the way that the link was led. Each contact books this once, as taken from the hand and as
/// supplied by it: a supply that is summed up apart, with the force of another instant, would be energy from nothing. Velocity
/// Verlet's mean is the trapezoidal rule, which also springs follow, to the third power of the way; with implicit
/// Euler a hand supplies no less than springs gain.
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

/// An explicit contact until its work is booked.
struct BookedContact {
  int pair = -1;  ///< index in the state's pairs
  Pose X_WP;      ///< of the patch
  /// Force at the evaluation; impulse beside it.
  Wrench F_BP_P, J_BP_P;                ///< force, and the impulse that corrects it, see LocatedForce
  Wrench elastic_P, elastic_impulse_P;  ///< of these the spring's
  bool sticking = false;                ///< friction held it
  bool parted = false;                  ///< it ended within the step: no force, and the patch is the last one
  FrictionMemory before;                ///< at the last evaluation
  ReleaseMemory last;                   ///< likewise
  Twist V_AB_P;                         ///< at the end of the step, of what kicks move
};
using BookedContacts = LoadedVector<BookedContact>;  ///< explicit contacts of one step

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

/// (in realtime) Keeps a contact until its work is booked, when the velocities at the end are known. `pair`: the state's at `index`, as
/// the last evaluation left it.
void noteContact(int index, const ActivePair& pair, const ContactEvaluation& contact, BookedContacts& contacts) noexcept;
/// (in realtime) A contact that parted inside a step of velocity Verlet: its last force times `time` corrects the kick [s].
void noteRelease(int index, const ActivePair& pair, double time, BookedContacts& contacts) noexcept;

/// (in realtime) After a step of velocity Verlet, the placement at its end. v_half: between the kicks, of joints with laws the
/// mean over the step; v_ahead: after the next half kick. Leaves in the memories what that half kick will do.
void bookVerlet(const LedgerView& view, double h, const std::vector<double>& v_half, const std::vector<double>& v_ahead,
                BookedContacts& contacts, State& state) noexcept;
/// The last part of it alone: at the first step, where nothing was done before.
void notePowers(const LedgerView& view, double h, const std::vector<double>& v_ahead, BookedContacts& contacts,
                State& state) noexcept;

/// (in realtime) The energy of a contact that parted, where no kick is to be corrected.
void bookRelease(const FrictionMemory& last, EnergySums& sums) noexcept;

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
void closeLedger(const LedgerView& view, double unaccounted, State& state, EnergyLedger& energy) noexcept;

}  // namespace haptic
