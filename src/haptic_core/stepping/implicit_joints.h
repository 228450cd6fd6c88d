/// What joints do by themselves (limits, damping, friction, drives, mimic, rings) inside the implicit step.
///
/// A stage of length g from a base q_b ends at v with
///   r(v) − g f − Gᵀ μ = 0,   f_i on the graph of joint i (joint_law.h, for q_b and g),   φ(q_b ⊕ g v) = 0,
/// r the residual of inertia, gravity and contacts (frozen_problem.h), φ the rings and mimics, φ' = G v. A
/// Newton step p solves the linear model of r together with the graphs themselves:
///   A p + r = g f + Gᵀ μ,   f_i on its graph at v_i + p_i,   G p = −φ/g.
/// The graphs fall, so this is a step of the pass, and the one that joint_solver.h solves, over the factor of A of
/// the island. Cost: one factorisation per pass, one pass where no joint changes its piece, and with rings a solve per row.
#pragma once
#include <vector>

#include "haptic_core/dynamics/block_cholesky.h"
#include "haptic_core/dynamics/joint_solver.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// Joint laws, rings and mimics of an island's trees, in the solve of one implicit stage.
class ImplicitJoints {
 public:
  explicit ImplicitJoints(const Model& model);  ///< set-up: room for those of all trees

  /// (in realtime) Before a step: the trees of the island, by node of the matrix (−1: not in it).
  void setNodes(const std::vector<int>& node_of_tree, int nodes) noexcept;
  /// (in realtime) Before Newton: the graphs for a stage of length g from `q_base`; puts `v` inside the
  /// limits.
  void startStage(const State& state, const double* q_base, double g, double* v) noexcept;

  /// (in realtime) The Newton step p at v, both in the state's order; `matrix` holds A, assembled, and is
  /// overwritten. q, work: at the reference of the rings' gaps, of which the share `open` is left at v: the
  /// steps taken since then have closed the rest. False: A is not positive definite.
  bool solve(BlockCholesky& matrix, const LinkWork* work, const double* q, const double* v,
             const double* residual, double open, double* p) noexcept;
  /// (in realtime) After `solve`, on the factor it left: the step for another residual, of joints that stay on their pieces.
  void solveAgain(BlockCholesky& matrix, const double* v, const double* residual, double* p) noexcept;
  /// (in realtime) −(g f + Gᵀ μ)·p at a velocity on the way from v to v + p: the joints' share of R·p.
  double slope(const double* v, const double* p) const noexcept { return joints_.slope(v, p); }
  /// (in realtime) Prescribed velocities, to the last bit: rounding in v + p would move a joint that sticks.
  void settle(double* v) const noexcept { joints_.settle(v); }

  /// (in realtime) After a stage: whether no joint hit a limit, stuck or came loose in a step that began with
  /// v0.
  bool isSmooth(const double* v0) const noexcept { return joints_.isSmooth(v0); }
  /// (in realtime) Work of the joints in a step, summed over its stages: each for a time `weight`, with the
  /// forces that it ended with at v, on joints that moved at the mean of `v_way` and v; `q_way`: as JointSolver::account's q0.
  void startAccount() noexcept { work_ = {}; }
  /// (in realtime) See startAccount.
  void account(const double* q_way, const double* v_way, const double* v, double weight) noexcept {
    joints_.account(commands_, weight, q_way, v_way, v, force_.data(), work_);
  }
  /// (in realtime) Adds the sums to the ledger.
  void closeAccount(State& state) const noexcept;

  bool converged() const { return converged_; }               ///< every joint's force is on its graph, in the last stage
  const JointForce& force(int link) const { return force_[link]; }  ///< by world link: of its joint in the last stage
  /// Largest gap of a ring of any tree [m].
  double closure(const LinkWork* work) const noexcept { return joints_.closure(work); }

 private:
  const Model& model_;
  JointSolver joints_;
  bool converged_ = true;
  double g_ = 0;
  JointWork work_;
  const JointCommand* commands_ = nullptr;
  std::vector<JointForce> force_;
  std::vector<int> row_;  ///< by velocity of the world: its row in the matrix
  // By row: its velocity of the world, its node and where it stands there; prescribed diagonals; right sides and results.
  std::vector<int> velocity_, node_, local_;
  std::vector<double> diag_, product_, p_;
  int rows_ = 0;
};

}  // namespace haptic
