/// The reference of a pass: where geometry, inertia and forces are frozen.
///
/// Contact volumes know the way out of a body only near its surface. So where a pair would get deeper by more than a quarter of its width
/// between two references, the reference goes a share of the way to the iterate (depth_limit.h), as in a trust region.
#pragma once
#include "haptic_core/stepping/implicit_stage.h"

namespace haptic::stepping {

/// (in realtime) Puts what hands hold to where it is `left` [s] before the step's end: friction is told displacements, not rates.
void placeHeld(const Model& model, const State& state, double left, HeldLinks& held, StagePlaces& places) noexcept;

/// (in realtime) Moves the reference to v, or where it `may_limit` a share of the way: contacts and residual at the poses of the end of the
/// stage, of the trees that moved. v becomes the reference. Of the state it warms the pairs' caches.
void evaluate(const Model& model, State& state, double g, bool may_limit, ImplicitStage& stage) noexcept;
/// (in realtime) No contact is known: the next evaluation finds all anew.
void forgetContacts(double g, ImplicitStage& stage) noexcept;

/// (in realtime) v less the reference's, into `since_reference`.
void measureSinceReference(const Model& model, ImplicitStage& stage) noexcept;
/// (in realtime) Carries contacts, couplings and force elements from the reference to v, which ends a solve.
void carryToEnd(const Model& model, double g, ImplicitStage& stage) noexcept;

/// (in realtime) Kinetic and potential energy of a tree where it is placed [J].
double energyOf(const Model& model, int tree, const StagePlaces& places) noexcept;

}  // namespace haptic::stepping
