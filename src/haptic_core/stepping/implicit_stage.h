/// A stage of an implicit step, as plain data. A stage of length g from a base (q_b, v_b, s_b) finds v with
///     R(v) = M(q)(v - v_b) + g (c(q, v) - Σ Jᵀ F(q, v, s) - gravity) = 0,   q = q_b ⊕ g v,  s = s_b + g V_t,
/// F from the contact volumes at q, from the virtual couplings and from the force elements.
///
/// Each part has one writer:
///   `base`, the guess `v`  the schemes (implicit_schemes.h), before a solve;
///   `held`                 `beginStages`, and where a stage ends within the step `placeHeld`;
///   `places`, `reference`  what moves the reference (stage_reference.h);
///   `forces`               stage_forces.h;
///   `pass`, `result`, `v`  the passes (stage_passes.h);
///   `problem`, `contacts`, `joints`, `limit`  themselves, when a pass calls them.
#pragma once
#include <limits>
#include <vector>

#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/stepping/depth_limit.h"
#include "haptic_core/stepping/frozen_problem.h"
#include "haptic_core/stepping/implicit_joints.h"
#include "haptic_core/stepping/stage_contacts.h"
#include "haptic_core/stepping/stage_forces.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic::stepping {

/// Passes of a solve that no budget takes away. Fewer: what is hit hard passes through; more: they are beyond every budget.
constexpr int kFewestPasses = 2;

/// Where a stage starts, in the state's order; only what belongs to the island is read.
struct StageBase {
  std::vector<double> q, v;            ///< positions and velocities
  std::vector<FrictionMemory> memory;  ///< by pair
  std::vector<Yielding> yielding;      ///< by pair: in the stage
  double run = 0;                      ///< how long belts have run since `memory` [s]: where that is not the base's time
  double since = 0;                    ///< from `memory` to the stage's end, where that is more than its length [s]: BDF2's; else 0
};

/// Where trees and shapes of a stage are: at its reference.
struct StagePlaces {
  std::vector<double> q;          ///< in the state's order
  std::vector<LinkWork> link;     ///< by link
  std::vector<Pose> X_WS;         ///< by shape
  bool fixed_placed = false;      ///< the links that never move are where they are
};

/// Facts of a stage at its reference, beside the frozen problem.
struct StageReference {
  std::vector<char> moved;          ///< by tree: since its reference
  std::vector<double> tree_energy;  ///< by tree: kinetic and potential at its reference [J]
  bool first = true;                ///< no reference yet: the one before is the base
};

/// What one pass of a stage hands to the next.
struct PassMemory {
  StageTolerance tolerance;      ///< of the last pass
  double changed = 0;            ///< largest change of speed in it [m/s]
  std::vector<double> calm;      ///< v of the reference that had the least energy so far, less supply
  double calm_energy = 0;        ///< of the island there [J]
};

/// How the last solve ended, beside v.
struct StageResult {
  bool limited = false;     ///< a reference lay short of its iterate
  double error = 0;         ///< of v [m/s]
  double wrench_error = 0;  ///< that it leaves out of balance [N], moments over the body's size
};

/// Everything that implicit stages hold beside model and state: one for all islands of a world, one island after another.
struct ImplicitStage {
  Island island;              ///< that is solved; its arrays stay the caller's
  double mass = 0;            ///< of the island [kg]
  int links = 0;              ///< of the island
  bool has_joints = false;    ///< the island's joints do something by themselves
  bool jointed = false;       ///< a tree of the island is more than a free body
  StageBase base;             ///< where the stage starts
  std::vector<double> v;      ///< guess and result
  HeldLinks held;             ///< what hands lead
  StagePlaces places;         ///< of everything
  StageReference reference;   ///< of the last pass
  PassMemory pass;            ///< of the last pass
  StageResult result;         ///< of the last solve
  /// Since `beginStages`: of contacts; Newton steps and matrices, of the part that took most in each pass.
  int evaluations = 0, iterations = 0, factorisations = 0;
  double units = 0;           ///< counted work for the island (world/counted_work.h)
  double most_units = std::numeric_limits<double>::infinity();  ///< that the step's budget has for it
  StageForces forces;         ///< couplings and force elements
  ImplicitJoints joints;      ///< of the island
  FrozenProblem problem;      ///< of a pass
  StageContacts contacts;     ///< as the last solve left them
  DepthLimit limit;           ///< how far the reference may go
  std::vector<double> since_reference;        ///< v less the reference's, where a solve has ended
  std::vector<double> residual, difference;   ///< room: of the equations; of velocities

  explicit ImplicitStage(const Model& model);  ///< set-up: room for the largest island
  /// The budget of the step lasts no longer: a solve ends after kFewestPasses of one Newton step each.
  bool isSpent() const noexcept { return units >= most_units; }
  /// Largest speed of any tree of the island [m/s]; rotations count at the reach of the body.
  double speed(const std::vector<double>& velocity) const noexcept { return problem.speed(velocity.data()); }
};

/// (in realtime) Before the islands of a step of length h [s]: the links of `trees`, and once those that never move, at the state's
/// q, v. What hands hold has been put where the step ends; `hands`, `seams` and the state, whose pairs the contacts ask, stay the
/// caller's.
void beginStages(const Model& model, State& state, const std::vector<int>& trees, const HandWork& hands, Seams& seams, double h,
                 ImplicitStage& stage) noexcept;
/// (in realtime) The trees that move and the pairs that may touch, until the next call. The arrays stay the caller's.
void select(const Model& model, const Island& island, ImplicitStage& stage) noexcept;

/// (in realtime) Kinematics of a tree and its shapes from `places.q`.
void placeInStage(const Model& model, int tree, const std::vector<double>& velocity, StagePlaces& places) noexcept;

/// (in realtime) Visits the island's velocities, by their index in the world.
template <class Visit>
void eachVelocity(const Model& model, const Island& island, Visit&& visit) noexcept {
  for (int n = 0; n < island.tree_count; ++n) {
    const ModelTree& tree = model.trees[island.trees[n]];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) visit(i);
  }
}

}  // namespace haptic::stepping
