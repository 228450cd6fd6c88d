/// The energy ledger: where the energy is, where it went. An observer: given wrenches, twists and memories, it books; no
/// stage of the step reads what it has written.
///
/// What a contact takes from its bodies is the work of its impulses: impulse times the mean of the velocities before and
/// after, which is what the bodies lose, to rounding, however much one step stops them. Velocity Verlet kicks twice
/// between two evaluations: with the last force (its work is known from that evaluation's power and the power's rate) and
/// with the new one. What the bodies lost to the springs and what the springs did not gain is dissipated; for the normal
/// springs the difference is named `turning`, for k Vol n has no potential while n turns.
#pragma once
#include <vector>

#include "haptic_core/geometry/loaded_vector.h"
#include "haptic_core/world/contact_evaluation.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/placement.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// An explicit contact until its work is booked.
struct BookedContact {
  int pair = -1;                       ///< index in the state's pairs
  Pose X_WP;                           ///< of the patch
  /// Force at the evaluation; impulse beside it.
  Wrench F_BP_P, J_BP_P;               ///< force, and the impulse that corrects it, see LocatedForce
  Wrench elastic_P, elastic_impulse_P;  ///< of these the spring's
  bool sticking = false;                          ///< friction held it
  FrictionMemory before;               ///< at the last evaluation
  Twist V_AB_P;                        ///< at the end of the step
};
using BookedContacts = LoadedVector<BookedContact>;  ///< explicit contacts of one step

/// What the books are made from.
struct LedgerView {
  const Model& model;     ///< constant
  const HandWork& hands;  ///< which links hands hold, and how they moved
  Placement& placement;  ///< velocities of links are set for a booking, and set back to the state's
};

/// (in realtime) The energy in a contact's springs enters its new memory and the report; its work is booked when the
/// velocities at the end are known.
void noteContact(int pair, const ContactEvaluation& contact, const FrictionMemory& before, double elastic_energy,
                 FrictionMemory& now, BookedContacts& contacts, EnergyLedger& energy) noexcept;

/// (in realtime) After a step of symplectic Euler; `v_mean`: over the kick. Leaves `v_mean` in the placement.
void bookEuler(const LedgerView& view, double h, const std::vector<double>& v_mean, const BookedContacts& contacts,
               State& state) noexcept;

/// (in realtime) After a step of velocity Verlet, the placement at its end. v_half: between the kicks; v_ahead: after the
/// next half kick. Leaves in the memories what that half kick will do.
void bookVerlet(const LedgerView& view, double h, const std::vector<double>& v_half, const std::vector<double>& v_ahead,
                BookedContacts& contacts, State& state) noexcept;
/// The last part of it alone: at the first step, where nothing was done before.
void notePowers(const LedgerView& view, double h, const std::vector<double>& v_ahead, BookedContacts& contacts,
                State& state) noexcept;

/// (in realtime) The rest of the energy of a contact that parted `tau` after the last evaluation, while its force fell like
/// (tau - t)ⁿ, n = `order`: half a kick, and what corrects it (release.h). h = 0: nothing was kicked.
void bookRelease(const FrictionMemory& last, double h, double tau, double order, EnergySums& sums) noexcept;

/// Of what moves by itself [J].
struct MechanicalEnergy {
  double kinetic = 0, potential = 0;  ///< of motion; of gravity
};
/// (in realtime) As the placement has it.
MechanicalEnergy mechanicalEnergy(const Model& model, const HandWork& hands, const Placement& placement) noexcept;

/// (in realtime) Energies now and sums so far; what the balance lost since the last step is the time step's. `unaccounted`:
/// EnergySums::unaccounted before the step. Where the balance is taken anew, springs that were loaded before anybody looked
/// enter it, and the supply.
void closeLedger(const LedgerView& view, double unaccounted, State& state, EnergyLedger& energy) noexcept;

}  // namespace haptic
