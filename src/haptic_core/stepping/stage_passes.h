/// One stage of an implicit step: passes, each with geometry frozen where the last one ended.
///
/// A stage of length g from a base (q_b, v_b, s_b) finds v with
///     R(v) = M(q)(v - v_b) + g (c(q, v) - Σ Jᵀ F(q, v, s) - gravity) = 0,   q = q_b ⊕ g v,  s = s_b + g V_t,
/// F from the contact volumes at q, from the virtual couplings and from the force elements.
///
/// A pass evaluates contacts and inertia once, at a reference velocity v_r, and solves the problem that has the
/// exact force and stiffness there (frozen_problem.h). Its solution is the reference of the next pass, which looks again at
/// changed contacts (stage_contacts.h); without any there is no next pass. At rest, and wherever patches change
/// little within a step, the stage costs one evaluation and one factorisation.
///
/// Contact volumes know the way out of a body only near its surface. So where a pair would get deeper by more than a quarter of its width
/// between two references, the reference goes a share of the way to the iterate (`limited`), as in a trust region. The step stays whole:
/// a body that tips over or lands does so within it.
///
/// End. With Δ the change of the last pass and ρ its share of that of the pass before, Δ ρ/(1-ρ) is left. It ends at
/// `tolerance` times the step's own error: as a speed |v - v_b|, of which implicit Euler errs by half, and a hundredth of
/// g |gravity|; and -R·p of the last pass, an energy, at the same share of that of these speeds.
/// After the last pass that is allowed the remaining error is reported, and `keepEnergy` (stage_energy.h) keeps it from adding energy.
#pragma once
#include "haptic_core/stepping/stage_reference.h"

namespace haptic::stepping {

/// (in realtime) Before the first pass of a stage of length `g` [s] whose end lies `left` [s] before the step's: no contact is known.
void startStage(const Model& model, const State& state, double g, double left, ImplicitStage& stage) noexcept;
/// (in realtime) Passes, of which the first has been evaluated. False when not converged.
bool iterate(const Model& model, State& state, double g, int most_passes, ImplicitStage& stage) noexcept;

/// (in realtime) Solves a stage of length `g` [s] whose end lies `left` [s] before the step's, from `stage.base`. `stage.v` is the guess
/// and the result. Of the state it reads what trees obey and what pairs are, and warms the pairs' caches. Gives up where `goesOn()` is
/// false after the first evaluation, whose contacts it may look at. False when not converged: v is the last iterate, `stage.result` says
/// how far.
template <class GoesOn>
bool solveStage(const Model& model, State& state, double g, double left, int most_passes, ImplicitStage& stage, GoesOn&& goesOn) noexcept {
  startStage(model, state, g, left, stage);
  evaluate(model, state, g, true, stage);
  return goesOn() && iterate(model, state, g, most_passes, stage);
}

/// (in realtime) Speed below which a solve of length g goes on rounding [m/s]: of the speeds themselves, and of coordinates.
double finest(const Model& model, const ImplicitStage& stage, double g) noexcept;

}  // namespace haptic::stepping
