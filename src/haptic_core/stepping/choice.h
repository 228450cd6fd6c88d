/// The choice between explicit and implicit steps, island by island.
///
/// An island is stepped by velocity Verlet while no link of it comes near the bound of stability (stability_number.h),
/// implicitly otherwise. The numbers are those of the contacts that the explicit step itself has found at its end: where
/// one is too high, because something stiff was hit or grew, the step has not happened; it is taken back and done again
/// with that island implicit. An implicit island goes back when its numbers have been low for some steps in a row.
/// So the choice depends on the state alone; modes and numbers are part of it.
///
/// A contact that swings within few steps is stable and wrong: at three steps a bounce an explicit step may throw a body back
/// faster than it came. So where a contact moves and swings in fewer than ten steps, the step is done again in equal parts,
/// as long as all is explicit and at most eight pairs touch, even where the whole step would be unstable; else its island becomes
/// implicit, which loses speed instead of gaining, at a bounded cost.
#pragma once
#include <vector>

#include "haptic_core/world/contact_evaluation.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/visits.h"

namespace haptic {
struct Work;
}

namespace haptic::stepping {

/// Shares of the bound of stability at which an island becomes implicit, and explicit again. The numbers are upper
/// bounds, up to twice the true ones; the margin is for patches that grow within a step.
constexpr double kEnterImplicit = 0.9, kLeaveImplicit = 0.7;

/// Radians of a swing in a contact that a step may take: from `kRough` on the substep is cut to parts of `kFine`. A bounce then
/// keeps its speed to 1 %; finer costs in proportion.
constexpr double kRough = 0.7, kFine = 0.25;
constexpr int kMostParts = 8;  ///< √kStabilityBound/kFine: what swings faster is too stiff for parts
/// Change of depth within a substep, of the depth, below which a contact rests [1].
constexpr double kResting = 0.05;

/// The state before an attempt; the pairs before it are those of the last search.
struct Retreat {
  std::vector<double> q, v, pull, a_end, a_mean, v_mean, last_step;  ///< of the state, see State
  std::vector<TreeMode> mode;      ///< before its implicit islands
  std::vector<Wrench> wrench;      ///< on the hands
  EnergySums energy;               ///< of the ledger
  bool remembers = false;          ///< the last step's accelerations and means were kept: a tree is implicit
  int pair_count = 0;              ///< of the state
  unsigned flags = 0;              ///< of the report
};

/// Scratch of the choice between explicit and implicit steps: stability numbers, and the way back.
struct ChoiceWork {
  std::vector<double> number;  ///< stability numbers by link, of the last evaluation
  Retreat retreat;             ///< for `takeBack`
  double position_error = 0;   ///< of the part, of the island that errs most, as its attempt foresees [m]
  double parts = 1;            ///< that the attempt asks a substep to have
  bool cuts = false;           ///< all is explicit and little touches: parts are possible
  bool decided = false;        ///< the attempt stands, whatever it finds

  explicit ChoiceWork(const Model& model);  ///< set-up: room for all links
};

bool anyImplicit(const State& state) noexcept;  ///< a tree is stepped implicitly
/// Steps in a row with low numbers after which an implicit island becomes explicit. Fewer: a bouncing body is taken back at every touch;
/// more: a body that was hit stays implicit longer.
constexpr int kDwell = 8;
/// Longest part of a substep that the contacts ask for which touch at the start of a step [s].
double longestPart(const Model& model, const State& state) noexcept;

/// (in realtime) Before an attempt.
void keepForRetreat(const Model& model, const Visits& visits, const State& state, const HandWork& hands, const StepReport& report,
                    Retreat& retreat) noexcept;
/// (in realtime) The same of a tree that wakes within an attempt, before anything moves it.
void keepForRetreat(const ModelTree& tree, int index, const State& state, Retreat& retreat) noexcept;
/// Undoes an attempt, but for modes and wrenches on hands; everything is placed again.
void takeBack(const Model& model, State& state, Work& work, StepReport& report) noexcept;

/// Bodies that move, one stepped explicitly and the other implicitly, must not meet inside a step.
bool modesMeet(const Model& model, const State& state, const Work& work) noexcept;
/// Makes whole islands implicit in which a tree is implicit already or, with `by_numbers`, a link's number is too high.
void makeImplicit(const Model& model, bool by_numbers, State& state, Work& work) noexcept;
/// Makes everything implicit that an implicit step can move: no further attempt of the step is taken back.
void giveUpExplicit(const Model& model, State& state, const Work& work) noexcept;
/// The highest number against the bound, into the report. In parts all numbers are lower.
bool anyTooStiff(const Model& model, const Visits& visits, ChoiceWork& choice, StepReport& report) noexcept;

/// The numbers begin with the virtual couplings and force elements of explicit links.
void countCouplings(const Model& model, const State& state, Work& work) noexcept;
/// Share of the virtual couplings that pull at a link, as if it were free.
double couplingNumber(const Model& model, const State& state, const Work& work, int link) noexcept;
/// Adds the shares of the force elements on these trees, of those that are implicit or of those that are explicit.
void countForces(const Model& model, const TreeRange& trees, bool implicit, const State& state, Work& work) noexcept;
/// Adds a contact's shares to the numbers of its links; measured again where the patch has grown, shrunk or moved.
void noteStability(const Model& model, const ContactEvaluation& contact, Work& work, ActivePair& pair) noexcept;
/// The same, without what says how the contact swings.
void addStability(const Model& model, const ContactVolume& volume, const PatchTangent& tangent, const Pose& X_WP, Work& work,
                  ActivePair& pair) noexcept;

}  // namespace haptic::stepping
