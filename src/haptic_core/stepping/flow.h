/// Trees that nothing touches, by themselves: an attempt of an island, and all of a world in which nothing can touch or pull.
///
/// A free body goes exactly under gravity; a tree of joints and loops to fourth order while its laws are smooth; both by velocity Verlet
/// (dynamics/tree_step.h) under applied wrenches. Where limits, friction or drives jump within a step, an implicit first-order step of the
/// tree keeps them dissipative at any gain (dynamics/tree_motion.h).
#pragma once
#include "haptic_core/world/model.h"
#include "haptic_core/world/report.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"

namespace haptic::stepping {

/// (in realtime) A tree in the arrays of state and work.
SteppedTree inPlace(const Model& model, const ModelTree& tree, State& state, Work& work) noexcept;

/// (in realtime) What the laws of joints took and gave in a step; null: there are none.
void book(const JointReport* joints, State& state, StepReport& report) noexcept;

/// (in realtime) Moves one tree by h [s].
void flow(const Model& model, int tree, double h, State& state, Work& work, StepReport& report) noexcept;

/// (in realtime) Keeps for the next step the acceleration of a tree that has flowed for h [s] from the velocities `v_start`.
void keepFlow(const Model& model, int tree, double h, const std::vector<double>& v_start, State& state) noexcept;

/// (in realtime) All trees of a world in which nothing can touch or pull (Model::allFlows).
void flowAll(const Model& model, double h, State& state, Work& work, StepReport& report) noexcept;

}  // namespace haptic::stepping
