/// Results of a step.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/geometry/volume/loaded_vector.h"
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

/// One touching pair of links, as the last step left it. Wrench on B, about P, in W.
struct ContactReport {
  int link_a = -1, link_b = -1;           ///< world link indices
  Pose X_WP;                              ///< patch frame: centroid, z = normal from A to B
  Wrench F_BP_W;                          ///< [N·m], [N]
  double normal_force = 0;                ///< [N]
  double volume = 0, area = 0, depth = 0; ///< [m³], [m²], [m]
  bool sticking = false;                  ///< friction holds it below its limit
  unsigned flags = 0;                     ///< of the ContactVolume
  int shape_a = -1, shape_b = -1;         ///< the model's shape indices
  double event = 1;                       ///< share of the step after which it touched, slid or stuck; 1: none of them
};

/// Where the energy of a world is and went [J]: the first four now, the others as sums since the start.
struct EnergyLedger {
  double kinetic = 0, potential = 0;      ///< of all bodies; of gravity, springs at joints, between links
  double elastic = 0;                     ///< Σ ½ k ∫d² dA
  double tangential = 0;                  ///< in the friction springs
  double damping = 0, friction = 0;       ///< dissipated in contacts and joints (limits: friction), ≥ 0
  double turning = 0;                     ///< taken out by k·Vol·n beyond what ½ k ∫d² dA gained: n turned
  double external = 0;                    ///< work done on the world by hands and by the joints' drives
  double stilled = 0;                     ///< of `damping`: motion of islands that were brought to rest (stepping/standing_islands.h)
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

/// What one step of a world came to.
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

  /// Share of the energy of impacts that the steps may gain or lose without saying so: 2 % of the speed after an impact.
  static constexpr double kKeptInImpacts = 0.04;
  /// (in realtime) Impacts shorter than the step are made plastic by implicit steps and thrown back by explicit ones. `lost`: energy that
  /// is in no account since `impact` was 0 [J].
  void judgeImpacts(double lost) noexcept {
    if (impact > 0 && std::abs(lost) > kKeptInImpacts * impact) flags |= kImpactUnresolved;
  }
};

/// Flags of a contact for `StepReport::flags`.
inline unsigned flagsOf(const ContactReport& contact) noexcept {
  return (contact.flags & ContactVolume::kCapacityExceeded ? kContactsIncomplete : 0u) |
         (contact.flags & ContactVolume::kNormalFromHistory ? kNormalRemembered : 0u);
}

/// All that a step says: public, and read by nothing in the step.
struct Report {
  StepReport step;                        ///< of the whole world
  LoadedVector<ContactReport> contacts;   ///< of what a step visits: in the order of the pairs' keys within what is led and each island
  std::vector<ContactReport> left;        ///< by slot of its pair: of a contact of what is left out (stepping/activity.h), as it was last
  std::vector<int> resting;               ///< slots of those

  /// Set-up: room for the contacts of so many pairs.
  void fit(int pairs) {
    contacts.reserve(pairs);
    left.resize(static_cast<std::size_t>(pairs));
    resting.reserve(left.size());
  }
  int contactCount() const { return contacts.size() + static_cast<int>(resting.size()); }  ///< of all
  /// Of all, those of what is left out last; i < contactCount().
  const ContactReport& contact(int i) const { return i < contacts.size() ? contacts[i] : left[resting[i - contacts.size()]]; }

  /// (in realtime) Contact i of what a step visits is to be kept by the slot of its pair: until `dropLeft` it is in both.
  void leave(int i, int slot) noexcept {
    if (slot < 0) return;
    left[slot] = contacts[i];
    resting.push_back(slot);
    contacts[i].link_a = -1;
  }
  /// (in realtime) See `leave`.
  void dropLeft() noexcept {
    int kept = 0;
    for (int i = 0; i < contacts.size(); ++i) {
      if (contacts[i].link_a < 0) continue;
      if (kept != i) contacts[kept] = contacts[i];
      ++kept;
    }
    contacts.resize(kept);
  }
  /// (in realtime) Contacts whose `moves(slot)` are of what a step visits again.
  template <class Moves>
  void takeBack(Moves&& moves) noexcept {
    const auto goes = [&](int slot) { return moves(slot) && (contacts.push_back(left[slot]), true); };
    resting.erase(std::remove_if(resting.begin(), resting.end(), goes), resting.end());
  }
  void clearContacts() noexcept { contacts.clear(), resting.clear(); }  ///< (in realtime)

  /// (in realtime) Books a contact that began at a speed of approach [m/s]. What bodies gain by falling for a step is none.
  void addImpact(double speed, double reduced_mass, double fall) noexcept {
    if (speed > fall) step.impact += 0.5 * reduced_mass * speed * speed;
  }

  /// (in realtime) Adds a contact and what its volume and pressure flag.
  void addContact(const ContactReport& contact, bool clipped) noexcept {
    step.flags |= flagsOf(contact);
    if (clipped) step.flags |= kPressureClipped;
    contacts.push_back(contact);
  }
};

}  // namespace haptic
