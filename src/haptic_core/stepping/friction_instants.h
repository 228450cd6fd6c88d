/// The instants within a step at which friction changes between sticking and sliding: located, and the modes changed there.
///
/// Within a solve a patch keeps its limit, which makes its force continuous: μ0 while stuck, μ while sliding. Implicit Euler changes the
/// limit from one step to the next. Second order locates the instant in islands of few contacts with μ0 > μ (elsewhere it does as
/// Euler): where a stuck patch would have to hold more than μ0 N, or the slip of a sliding one comes to a stop, the step is solved again
/// up to there by SDIRK2 (regula falsi on its length), the patch changes its mode, and the rest of the step follows.
#pragma once
#include "haptic_core/stepping/implicit_schemes.h"

namespace haptic::stepping {

/// (in realtime) Whether friction may jump between two limits, in an island small enough to look for the instants.
bool mayJump(const Model& model, const Island& island, const State& state) noexcept;

/// (in realtime) Whether friction changes its mode within the stage's solve.
bool changesMode(const State& state, const ImplicitStage& stage) noexcept;

/// A part of a step that ends where friction changes.
struct UpToInstant {
  double done = -1;       ///< committed [s]; < 0: it is not smooth, errs too much, or the budget is used up
  double excess = kNone;  ///< where it errs too much: as `Attempt::excess`
};
/// (in realtime) After SDIRK2 over the next s [s], in which friction changes: solves up to the first change in (0, s], commits, and changes
/// the modes; where it changes at once, it is done with 0 s.
UpToInstant stepToInstant(const Model& model, double s, State& state, ImplicitWork& work) noexcept;

}  // namespace haptic::stepping
