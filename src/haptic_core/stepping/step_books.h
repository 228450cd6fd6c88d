/// The books of an implicit step: what each stage did, and the impulses, works and energies that follow from it.
///
/// A part of a step is committed from the solve that the stage holds. Impulses over its length h are those by which its scheme moved the
/// bodies, and work is the mean wrench times the way of this part: both are means w before + (1 - w) now, w = 1 - g/h,
///   implicit Euler  w = 0: of its end;
///   BDF2            before: the mean of the last step, w = 1/3 where steps are equal;
///   SDIRK2          before: its first stage.
/// What hands lead goes its own way of the step. The end's force in place of the mean errs by half a step of its change, of which a hand
/// feels every change of schemes: `shaken.force_err_max_rel`. Force elements and joints are booked by powers at both ends.
#pragma once
#include <cmath>
#include <vector>

#include "haptic_core/stepping/implicit_stage.h"

namespace haptic::stepping {

constexpr double kGamma = 1 - M_SQRT1_2;  ///< of SDIRK2: length of a stage over that of the step

/// Of which the forces of a part of a step are the mean: w before + (1 - w) now, w = 1 - g/length.
enum class Mean : unsigned char {
  kOfEnd,    ///< implicit Euler, w = 0
  kOfSteps,  ///< BDF2: before is the mean of the last step, so that work and impulse are those by which the bodies moved
  kOfStages  ///< SDIRK2: before is the first stage
};

/// A part of a step that the stage has solved: v = v_base + g a at its end.
struct SolvedPart {
  double g = 0, length = 0;     ///< of its last stage; of all; 0: there is none [s]
  Mean mean = Mean::kOfSteps;   ///< what its forces are
  double position_error = 0;    ///< that it foresees of itself [m]

  double before() const { return 1 - g / length; }  ///< w of Mean [1]
};

/// Wrenches and velocities at the end of a stage; of contacts, only what belongs to the island.
struct StageWrenches {
  std::vector<ContactMeans> pair;  ///< by pair: of the patch that touches; `done` of other patches of the pair adds up
  std::vector<Wrench> coupling;    ///< by pointer: on its link, about the link's origin, in W's axes
  std::vector<Twist> V_coupled;    ///< by pointer: of the link's origin
  ForcePower forces;               ///< of the island's force elements

  explicit StageWrenches(const Model& model);  ///< set-up: room for all pairs and pointers
};

/// Books of a world's implicit steps: sums over the parts of a step, of one island after another.
struct StepBooks {
  double length = 0;                     ///< of the last island's step [s]
  std::vector<Wrench> impulse;           ///< by pair: of the step so far, on its B, about W's origin
  std::vector<Pose> place;               ///< by pair: X_WP of the patch that pressed last
  std::vector<Twist> V_led;              ///< by pair: about W's origin, see ImplicitContact
  std::vector<double> event;             ///< by pair: share of the step after which its friction changed its mode last; 1: it did not
  std::vector<Wrench> coupling_impulse;  ///< by pointer: of the step so far, about its link's origin
  std::vector<double> coupling_work;     ///< by pointer: on its link in the step so far [J]
  StageWrenches first, last;             ///< of SDIRK2's first stage; of the last stage that was gathered
  ForcePower forces_before;              ///< of the island's force elements, at the end of the last part
  double given = 0;                      ///< energy that dampers and friction of contacts gave in parts of the step [J]

  explicit StepBooks(const Model& model);  ///< set-up: room for all pairs and pointers
};

/// (in realtime) Before the islands of a step: nothing has been done to these pairs and to couplings.
void openBooks(const std::vector<int>& pairs, StepBooks& books) noexcept;

/// (in realtime) Wrenches and velocities of the stage's last solve, into `found` of the books, with the places of its patches.
void gather(const ImplicitStage& stage, StageWrenches& found, StepBooks& books) noexcept;

/// (in realtime) Books the part that the stage has solved, over its length: impulses and energies, and puts friction at its end into the
/// state. (The last Newton step was not evaluated: forces and friction are those of the evaluation before it.) `first_part`: of this step.
void bookPart(const Model& model, const ImplicitStage& stage, const SolvedPart& part, bool first_part, State& state,
              StepBooks& books) noexcept;

/// (in realtime) Books a step of length h [s] in which the island stood.
void bookStanding(const Model& model, const ImplicitStage& stage, double h, State& state, StepBooks& books) noexcept;

double sumOf(const std::vector<double>& values) noexcept;  ///< (in realtime) in their order

/// Mean wrench of a contact of the last island over its step, on B at X_WP.p, in W's axes: its impulse over h.
inline Wrench meanWrench(const StepBooks& books, const ImplicitContact& contact) noexcept {
  return (books.impulse[contact.pair] * (1 / books.length)).shifted(contact.X_WP.p);
}
/// Mean wrench of a pointer's coupling on its link over the step, about the link's origin, in W's axes.
inline Wrench meanCoupling(const StepBooks& books, int pointer) noexcept { return books.coupling_impulse[pointer] * (1 / books.length); }

/// (in realtime) Visits (pair, X_WP, mean wrench as above) of the pairs of the stage's island that pressed and touch no more.
template <class Visit>
void eachParted(const ImplicitStage& stage, const StepBooks& books, Visit&& visit) noexcept {
  const Island& island = stage.island;
  const LoadedVector<ImplicitContact>& contacts = stage.contacts.all();
  int next = 0;
  for (int i = 0; i < island.pair_count; ++i) {
    const int pair = island.pairs[i];
    if (next < contacts.size() && contacts[next].pair == pair) {
      ++next;
    } else if (!books.impulse[pair].vector().isZero(0)) {
      visit(pair, books.place[pair], (books.impulse[pair] * (1 / books.length)).shifted(books.place[pair].p));
    }
  }
}

}  // namespace haptic::stepping
