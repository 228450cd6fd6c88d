/// The implicit schemes, each as an attempt at a part of an island's step:
///
///   stand           nothing moves, where a stage of implicit Euler finds that.
///   implicit Euler  one stage (stage_passes.h) of length h.
///   SDIRK2          two stages, g = γ h, γ = 1 - 1/√2 (Alexander 1977: second order, L-stable, stiffly accurate):
///                   v_b = v0 + (1-γ) h a1, q_b = q0 ⊕ (1-γ) h v1, s_b = s0 + (1-γ)/γ (s1 - s0); of what sticks poses say
///                   how far s went, and only what yielded is drawn out.
///   BDF2            one stage, g = h (1 + w)/(1 + 2 w) with w = h over the last step (Hairer, Nørsett, Wanner, Solving ODEs I, III.5:
///                   second order, stable for w ≤ 1 + √2 in any sequence): v_b = v0 + (h - g) ā, q_b = q0 ⊕ (h - g) v̄, with the means
///                   of the last step, which the state keeps. It halves the solves of what goes on smoothly. The first step after an
///                   event (a contact begins or ends, friction changes its mode, a hand lets go, a tree that flowed) has none to go on
///                   from.
///
/// Each starts from the state, and leaves its solution in the stage, whose last solve it is. Those of second order change nothing
/// else but caches of pairs: their attempt says how far they err, and `commit` takes it into state and books. Implicit Euler always
/// counts, and commits itself.
///
/// Errors of position over a length s: implicit Euler s/2 |Δv|; BDF2 2/9 s² |a1 - a0|, a0 at the end of the last step; SDIRK2 .04 s² of
/// the change between its stages. An attempt may err by `WorldSettings::accuracy` of the way that the change of speed and gravity move a
/// body in the step.
#pragma once
#include <algorithm>
#include <limits>
#include <vector>

#include "haptic_core/stepping/implicit_stage.h"
#include "haptic_core/stepping/step_books.h"

namespace haptic {

/// Which implicit schemes an island may take.
enum class ImplicitOrder : unsigned char {
  kFirst,           ///< implicit Euler
  kSecond,          ///< SDIRK2 where it is smooth
  kSecondMultistep  ///< BDF2 in its place where the last step was smooth as well: half the solves
};

/// Work and convergence of the implicit step of one island.
struct ImplicitReport : IslandReport {
  double units = 0;        ///< counted work (world/counted_work.h)
  double position_error = 0;  ///< that the accepted attempts foresee of themselves, summed over them [m]
  bool cut = false;        ///< the step's budget ended while it was solved
  bool rests = false;      ///< it was at rest and stays: q and the pairs keep their bits, v is 0
  bool stands = false;     ///< so it is, and v was 0
};

}  // namespace haptic

namespace haptic::stepping {

constexpr double kNone = std::numeric_limits<double>::infinity();  ///< an error: contacts change, or a stage did not converge

/// Error of position over s² times the change of acceleration: from the last step's end to this one's; between two stages.
constexpr double kErrorBdf2 = 2.0 / 9, kErrorSdirk2 = 0.0404;
/// Passes of a stage of second order: smooth motion converges in two.
constexpr int kSmoothPasses = 2;

/// A span of an island's step, while attempts divide it into parts.
struct IslandStep {
  ImplicitOrder order = ImplicitOrder::kFirst;  ///< the schemes that it may take
  bool locates = false;           ///< instants of friction inside the step
  bool carried = false;           ///< few pairs, one of which a hand or joints lead: implicit_step.cpp
  double length = 0;              ///< [s]
  double left = 0;                ///< the rest that is not done yet [s]
  double after = 0;               ///< of the world's step after it, where the island goes in spans [s]
  int budget = 0;                 ///< evaluations that it may take
  int evaluations_before = 0;     ///< the stage's, when it began

  /// Evaluations; once the step's budget is spent all but those that are implicit Euler's and keep the energy.
  int used(const ImplicitStage& stage) const noexcept {
    const int evaluations = stage.evaluations - evaluations_before;
    return stage.isSpent() ? std::max(evaluations, budget - kKeepingEnergy - kEulerPasses) : evaluations;
  }
  /// Those that attempts may still take: three keep the energy of a step that did not converge, three are implicit Euler's at least.
  int room(const ImplicitStage& stage) const noexcept { return budget - kKeepingEnergy - kEulerPasses - used(stage); }
  /// Passes that implicit Euler may take: all that is left.
  int eulerPasses(const ImplicitStage& stage) const noexcept;
  /// Whether an attempt of so many evaluations, over and over with steps of length s to the end, leaves implicit Euler its own.
  bool affords(double evaluations, double s, const ImplicitStage& stage) const noexcept;
  void goOn(double done) noexcept;  ///< `done` [s] of the step are over
  /// From a part of length s that comes next to the end of the world's step [s].
  double beyond(double s) const noexcept { return left - s + after; }

  static constexpr int kKeepingEnergy = 3, kEulerPasses = 3;  ///< see `room`
};

/// A solve of second order that the stage holds.
struct Attempt {
  SolvedPart part;        ///< length 0: there is none
  double excess = kNone;  ///< its error of position over the allowed one
  double gained = 0;      ///< largest change of speed of a tree since the state [m/s]

  double eulerError() const { return 0.5 * part.length * gained; }  ///< of position, that implicit Euler would make [m]
};

/// Room of the schemes.
struct SchemeWork {
  std::vector<double> acceleration;  ///< by velocity: of SDIRK2's first stage [m/s², rad/s²]
  std::vector<double> change;        ///< by velocity: of acceleration, of which an error follows
  std::vector<double> gained;        ///< by velocity: since the state
  std::vector<double> violation;     ///< by pair: of friction's mode, at an instant (friction_instants.h)
  std::vector<PairCache> cache;      ///< by pair: before implicit Euler's solve

  explicit SchemeWork(const Model& model);  ///< set-up: room for all velocities and pairs
};

/// Everything that implicit steps hold beside model and state: one for all islands of a world, one island after another.
struct ImplicitWork {
  ImplicitStage stage;    ///< that is being solved; its last solve
  SchemeWork schemes;     ///< their room
  StepBooks books;        ///< of the step, of all its islands
  IslandStep step;        ///< of the last island
  ImplicitReport report;  ///< of the last island
  bool begun = false;     ///< `beginIslands` was called for the islands of this time

  explicit ImplicitWork(const Model& model) : stage(model), schemes(model), books(model) {}  ///< set-up: room for the largest island
};

/// (in realtime) The stage's base and guess are the state.
void startFromState(const Model& model, const State& state, ImplicitStage& stage) noexcept;
/// (in realtime) Speed below which the stage's island is at rest in a step of length h [m/s].
double restBound(const Model& model, const State& state, const ImplicitStage& stage, double h) noexcept;
/// (in realtime) Length of the island's last step, as `State::last_step`; 0: there is none, or trees differ; negative: something
/// jumped in it.
double lastStep(const Island& island, const State& state) noexcept;

/// Where implicit Euler does nothing, and says so.
struct Unless {
  /// Contacts jumped in the last step, and in a heap they mostly go on to; but the first evaluation finds those of the start, or an impact
  /// that parts resolve: second order is worth a try.
  bool smooth = false;
  bool fails = false;  ///< it does not converge
};

/// (in realtime) Stands, or makes one step of implicit Euler over the next h [s], in at most so many passes. False: nothing is done.
bool euler(const Model& model, double h, int passes, Unless unless, State& state, ImplicitWork& work) noexcept;

/// (in realtime) BDF2 over the next s [s] of the step, after a step of length `last`.
Attempt bdf2(const Model& model, State& state, const IslandStep& step, double s, double last, ImplicitStage& stage,
             SchemeWork& work) noexcept;
/// (in realtime) SDIRK2 over the next s [s]; contacts yield as `stage.base.yielding` says. Its first stage's wrenches go into the books.
Attempt sdirk2(const Model& model, State& state, const IslandStep& step, double s, ImplicitStage& stage, SchemeWork& work,
               StepBooks& books) noexcept;
/// (in realtime) Parts of h [s] in which an impact is resolved, by the contacts of the state and of the stage; 0: they swing too fast, or
/// there are too many of them.
int partsOfImpact(const Model& model, const State& state, const ImplicitStage& stage, double h) noexcept;
/// (in realtime) Before either: how contacts yield. What sticks never does in a step that locates the instants at which it lets go.
void setModes(const State& state, bool locates, ImplicitStage& stage) noexcept;

/// (in realtime) Puts the part that the stage has solved into the state: v, q = q_b ⊕ g v, friction and the means that BDF2 goes on from;
/// and books it. `taken_up`: as `State::last_step`.
void commit(const Model& model, const SolvedPart& part, double taken_up, State& state, ImplicitWork& work) noexcept;

}  // namespace haptic::stepping
