/// Results of a step.
#pragma once
#include <algorithm>
#include <cstdint>

#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/world/contact_reports.h"
#include "haptic_core/world/stage_clock.h"

namespace haptic {

/// Bits of StepReport::flags.
enum StepFlag : unsigned {
  kPairsDropped = 1u << 0,        ///< more overlapping boxes than the model has room for: raise kNeighboursPerShape
  kContactsIncomplete = 1u << 1,  ///< a contact volume dropped faces; it still pushes
  kNormalRemembered = 1u << 2,    ///< a contact without area vector used its last normal
  kNotConverged = 1u << 3,        ///< the implicit solve ended at `residual`: shorten the step
  kPressureClipped = 1u << 4,     ///< somewhere a damper would have pulled; the pressure was held at 0 there
  kJointsNotConverged = 1u << 5,  ///< some joint's force is not what its law says: shorten the step
  kDissipationGave = 1u << 6,     ///< a damper or friction gave energy over the step: the books of losses fall; shorten the step
  kTooFast = 1u << 7,             ///< a body moved farther than shapes are thick: its island needed more spans than kMostSpans
  kImpactUnresolved = 1u << 8,    ///< contacts began whose energy the step did not keep: see EnergyLedger::numerical, shorten the step
  kRunaway = 1u << 9,             ///< the world stopped: its steps had made more energy than there was; shorten the step
  kGaveWay = 1u << 10,            ///< something was left out for the budget of a step: islands wait longer, second attempts, iterations
};

/// Where the energy of a world is and went [J]: the first four now, the others as sums since the start.
struct EnergyLedger {
  double kinetic = 0, potential = 0;      ///< of all bodies; of gravity, springs at joints, between links
  double elastic = 0;                     ///< Σ ½ k ∫d² dA
  double tangential = 0;                  ///< in the friction springs
  double damping = 0, friction = 0;       ///< dissipated in contacts and joints (limits: friction), ≥ 0
  double turning = 0;                     ///< taken out by k·Vol·n beyond what ½ k ∫d² dA gained: n turned
  double external = 0;                    ///< work done on the world by hands and by the joints' drives
  double stilled = 0;                     ///< of `damping`: motion of islands that were brought to rest (stepping/rest.h)
  double numerical = 0;                   ///< lost by the time steps; negative: gained. The balance's deficit since the start,
                                          ///< and the part of `turning` that was taken while n stood still
  /// Energy that a world without losses would keep.
  double total() const { return kinetic + potential + elastic + tangential; }
  /// Constant up to the step's error.
  double balance() const { return total() + damping + friction + turning - external; }
};

/// A joint of one degree of freedom as the last step left it.
struct JointReading {
  double position = 0;                    ///< [rad] or [m]
  double velocity = 0;                    ///< [rad/s] or [m/s]
  double effort = 0;                      ///< of drive, spring, damping, friction and limits together [N·m] or [N]
  double drive = 0;                       ///< of its drive alone [N·m] or [N]
};

/// Flags of a contact for `StepReport::flags`.
inline unsigned flagsOf(const ContactReport& contact) noexcept {
  return (contact.flags & ContactVolume::kCapacityExceeded ? kContactsIncomplete : 0u) |
         (contact.flags & ContactVolume::kNormalFromHistory ? kNormalRemembered : 0u);
}

/// What the solve of one island came to.
struct IslandReport {
  int iterations = 0;           ///< Newton steps, line searches not counted
  int evaluations = 0;          ///< of the exact geometry
  int factorisations = 0;       ///< matrices
  int parts = 0;                ///< solved one after the other: 1; more where friction changed inside, or after halving
  double residual = 0;          ///< speed that is left to change [m/s]
  double wrench_error = 0;      ///< wrench that this leaves out of balance [N], moments over the body's size
  double budget_used = 0;       ///< evaluations over those it may take
  bool converged = true;        ///< the tolerance was reached in every part
  bool joints_converged = true; ///< every joint's force is on its graph in every part
  bool fell_back = false;       ///< SDIRK2 was replaced by implicit Euler in a part of this step
};

/// What one step of a world came to: public, written by the step and read by nothing in it.
struct StepReport {
  std::uint64_t step = 0;                 ///< steps since the start
  int pairs = 0, contacts = 0;            ///< of overlapping boxes; of touching shapes
  EnergyLedger energy;                    ///< kept while WorldSettings::energy_ledger is set
  double closure = 0;                     ///< largest gap left in a loop [m]
  int iterations = 0;                     ///< of the solve, most of any island; 0: all flowed
  int evaluations = 0, factorisations = 0;  ///< of the exact geometry and of matrices, most of any island
  double residual = 0;                    ///< largest speed that an implicit solve left to change [m/s]
  double wrench_error = 0;                ///< largest wrench that it left out of balance [N]
  int parts = 0;                          ///< solves after one another: more than 1 where friction changed or something was fast
  int implicit_islands = 0;               ///< islands stepped implicitly
  int standing = 0;                       ///< articulations of them that stand: at rest, left out until something comes near
  int waiting = 0;                        ///< articulations that wait for a turn of their own (stepping/own_rate.h)
  double lag = 0;                         ///< of them, the longest since its last turn [s]
  double work = 0;                        ///< counted (world/counted_work.h) [units]
  int fallbacks = 0;                      ///< islands in which SDIRK2 was replaced by implicit Euler
  double impact = 0;                      ///< energy of approach of the contacts that began in this step [J]
  bool finite = true;                     ///< false: the world stopped; `culprit` names the link
  int culprit = -1;                       ///< world link index; -1: none
  unsigned flags = 0;                     ///< StepFlag bits
  StageTimes stages;                      ///< filled while `World::measureStages` is on
  /// Error of position that the step adds, as its accepted attempts estimate it, of the island that errs most [m]; turns count at
  /// the reach of the body. 0 with a comparator.
  double position_error = 0;
  double budget_used = 0;                 ///< evaluations of an implicit island over those it may take, the largest share

  /// (in realtime) Flags of a contact. `clipped`: its dampers would have pulled.
  void flag(const ContactReport& contact, bool clipped) noexcept {
    flags |= flagsOf(contact);
    if (clipped) flags |= kPressureClipped;
  }
  /// (in realtime) The solve of one more island. `moves`: false where the island stays as it was.
  void add(const IslandReport& island, bool moves) noexcept {
    iterations = std::max(iterations, island.iterations);
    evaluations = std::max(evaluations, island.evaluations);
    factorisations = std::max(factorisations, island.factorisations);
    if (moves) {
      wrench_error = std::max(wrench_error, island.wrench_error);
      residual = std::max(residual, island.residual);
    }
    fallbacks += island.fell_back;
    parts = std::max(parts, island.parts);
    budget_used = std::max(budget_used, island.budget_used);
    if (!island.converged) flags |= kNotConverged;
    if (!island.joints_converged) flags |= kJointsNotConverged;
  }
  /// (in realtime) A gap left in a loop [m].
  void addGap(double gap) noexcept { closure = std::max(closure, gap); }
};

}  // namespace haptic
