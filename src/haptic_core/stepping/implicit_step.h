/// The implicit step of an island: stable for any stiffness, damping, mass ratio and step, friction inside the solve. Which of the schemes
/// (implicit_schemes.h) is tried when, over which parts of the step.
///
/// An attempt at second order counts when its error of position is no more than it may be. One that does not is tried again by halves,
/// down to h/8, while the error falls and the budget lasts; then it counts none the less where implicit Euler would err by more. Second
/// order multiplies the impulses of impacts by up to 2.4, so where the contact set changes or a patch grows or shrinks fast, and
/// where all attempts fail, the rest of the step is done as implicit Euler. After such a step Euler comes first, and gives way where
/// its first evaluation finds the contacts of the start: in a heap they mostly go on to change. BDF2 goes on from steps that were smooth.
///
/// Bounds. The budget of an island in a step is 128 evaluations of the exact geometry of a pair over the pairs that touch, but 10 at
/// least and 64 at most, shared by all attempts and instants of friction, and four factorisations for each pass. A step that has not
/// converged by then is reported with the wrench that it leaves out of balance; as implicit Euler it then has no more energy than it
/// started with. Where the step has a budget of counted work (world/counted_work.h), an island that has spent its share begins no attempt,
/// and ends implicit Euler after two passes of one Newton step. A fold hidden in an accepted step escapes that (seen at 1e12 N/m³).
#pragma once
#include <vector>

#include "haptic_core/stepping/implicit_schemes.h"

namespace haptic::stepping {

/// (in realtime) Once before the first span that islands of a step of length h [s] do not flow over; see beginStages. The caller has set
/// the targets of `work.stage.forces.couplings`, by pointer.
void beginIslands(const Model& model, State& state, const std::vector<int>& trees, const HandWork& hands, Seams& seams, double h,
                  ImplicitWork& work) noexcept;

/// (in realtime) Work of one evaluation of an island with two Newton steps, as far as it can be told before [units].
double evaluationUnits(const Model& model, const Island& island, const State& state) noexcept;

/// (in realtime) Before the first span of an island's step of length h [s]. `most`: counted work that the step's budget has for it
/// [units]; infinite: there is no budget. The fewest evaluations that a span takes are beyond it.
void openIsland(double h, double most, ImplicitWork& work) noexcept;

/// (in realtime) Advances q, v and friction of an island by a span of h [s], `after` which so much is left of its step [s], and the
/// ledger's sums in the state. Into `work`: its report, contacts and joints at the span's end in the stage, impulses and couplings' work of
/// all spans in the books.
void advanceIsland(const Model& model, const Island& island, double h, double after, ImplicitOrder order, State& state,
                   ImplicitWork& work) noexcept;

}  // namespace haptic::stepping
