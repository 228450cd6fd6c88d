/// Explicit steps: trees that flow because nothing touches them, and velocity Verlet with contacts, a comparator of whole worlds.
///
/// Velocity Verlet: v½ = v + h/2 a, q₁ = q ⊕ h v½, forces at (q₁, v½ + h/2 a), v₁ = v½ + h/2 a₁. Second order and one
/// evaluation as well, since a₁ is the next step's a. Forces jump or bend where a contact begins, ends or yields
/// inside the step; the impulse that h/2 (F₀ + F₁) then misses is computed from the located instant and added to the
/// second kick (located_force.cpp, friction.cpp, explicit_contacts.cpp), which keeps the order.
///
/// Trees whose joints have laws of their own (limits, friction, drives, loops) move by TreeMotion: to fourth order while nothing pulls
/// and the laws are smooth; else their forces jump within a step, and an implicit first-order step keeps them dissipative at any gain, with
/// the contact forces of the step's start. The step of a tree is in dynamics/tree_step.h.
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/step_parts.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {

/// (in realtime) Half a kick → coast → hands → placement → pairs → contacts → half a kick, of all trees (Attempts::kVerlet).
void velocityVerlet(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept;

/// (in realtime) A tree that touches nothing: a free body exactly under gravity, a tree of joints to fourth order while its laws are
/// smooth; by velocity Verlet under wrenches.
void flow(const Model& model, int tree, double h, State& state, Work& work, StepReport& report) noexcept;

/// (in realtime) Keeps for the next step the acceleration of a tree that has flowed for h [s] from the velocities `v_start`.
void keepFlow(const Model& model, int tree, double h, const std::vector<double>& v_start, State& state) noexcept;

/// (in realtime) All trees of a world in which nothing can touch or pull (Model::allFlows).
void flowAll(const Model& model, const StepPart& part, State& state, Work& work, Report& report) noexcept;

/// (in realtime) What contacts and hands do to a tree now is kept in the state for the next step of velocity Verlet.
void keepPull(const Model& model, const ModelTree& tree, State& state, Work& work) noexcept;

/// (in realtime) What pulled at a tree at the end of the last step holds no longer, nor its acceleration.
void forgetPull(State& state, int tree) noexcept;
/// (in realtime) The same of all trees.
void forgetPull(State& state) noexcept;

}  // namespace haptic::stepping
