/// What velocity Verlet keeps of each pair from one evaluation to the next, beside the state.
#pragma once
#include <vector>

#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic::comparators {

/// Data of a contact for the next step: where it pulled, how hard, and when it would part.
struct ReleaseMemory {
  Pose X_WP;                       ///< of the patch
  Wrench F_BP_W, elastic_W;        ///< on B about P; of that the normal spring's
  double leave = 0;                ///< time to depth 0 at the present rate [s]; infinite: approaching
  double order = 1;                ///< n of F ~ (time to depth 0)ⁿ
};

struct PairMemory {
  std::uint64_t key = 0;           ///< ActivePair::key
  std::uint64_t evaluation = 0;    ///< VerletContacts::evaluations when its boxes overlapped last
  ReleaseMemory release;           ///< for the instant at which it parts
  ContactPower power;              ///< that its force takes from what kicks move [W]
  ContactPower power_rate;         ///< of the same wrench while the bodies speed up [W/s]
};

/// A contact until its work is booked.
struct BookedContact {
  int pair = -1;  ///< slot in the state's pairs
  Pose X_WP;      ///< of the patch
  /// Force at the evaluation; impulse beside it.
  Wrench F_BP_P, J_BP_P;                ///< force, and the impulse that corrects it, see LocatedEvent
  Wrench elastic_P, elastic_impulse_P;  ///< of these the spring's
  bool sticking = false;                ///< friction held it
  bool parted = false;                  ///< it ended within the step: no force, and the patch is the last one
  FrictionMemory before;                ///< at the last evaluation
  PairMemory last;                      ///< likewise
  Twist V_AB_P;                         ///< at the end of the step, of what kicks move
};

/// All that the contacts of a step hand to its motion and books.
struct VerletContacts {
  std::vector<PairMemory> memory;  ///< by slot of the state's pairs
  std::uint64_t evaluations = 0;   ///< so far
  std::vector<int> on_link;        ///< by world link: contacts that touched at the last evaluation
  std::vector<Wrench> kick;        ///< by world link, about O: impulses of events inside the step [N·m·s, N·s]
  bool has_kick = false;           ///< else `kick` holds nothing of this step
  std::vector<BookedContact> booked;  ///< while the ledger is kept

  explicit VerletContacts(const Model& model);  ///< set-up: room for all links and contacts
};

/// (in realtime) Makes another contact of the volume of two shapes before a law sees it; null: the volume.
using ContactModel = void (*)(const ConvexShape& A, const ConvexShape& B, ContactWorkspace& workspace, ContactVolume& contact) noexcept;

/// (in realtime) All contacts here and now; see Advance.
void evaluateContacts(const Model& model, ContactModel contact_model, const Advance& advance, State& state, Work& work,
                      VerletContacts& contacts, StepReport& report) noexcept;

/// (in realtime) After a step, the placement at its end: a contact's two half kicks, with the last force (its work is known from that
/// evaluation's power and the power's rate) and with the new one; trees whose joints have laws are pulled at by the last force alone.
/// v_half: between the kicks, of joints with laws the mean over the step; v_ahead: after the next half kick.
void bookContacts(const LedgerView& view, double h, const std::vector<double>& v_half, const std::vector<double>& v_ahead,
                  VerletContacts& contacts, State& state) noexcept;
/// (in realtime) What the next half kick will do alone: at the first step, where nothing was done before.
void notePowers(const LedgerView& view, double h, const std::vector<double>& v_ahead, VerletContacts& contacts, State& state) noexcept;

}  // namespace haptic::comparators
