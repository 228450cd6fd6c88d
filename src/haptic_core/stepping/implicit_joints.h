/// What joints do by themselves (limits, damping, friction, drives, mimic, rings) inside the implicit step.
///
/// A stage of length g from a base q_b ends at v with
///   r(v) − g f − Gᵀ μ = 0,   f_i on the graph of joint i (joint_law.h, for q_b and g),   φ(q_b ⊕ g v) = 0,
/// r the residual of inertia, gravity and contacts (implicit_step.h), φ the rings and mimics, φ' = G v. A
/// Newton step p solves the linear model of r together with the graphs themselves:
///   A p + r = g f + Gᵀ μ,   f_i on its graph at v_i + p_i,   G p = −φ/g.
/// The graphs fall, so this is the step of a convex problem: the pieces are found by the search of
/// joint_laws.h, on the factor of A of all trees in contact. A straight piece adds g·slope to A's diagonal;
/// on a vertical one (stuck, at a limit) the step is prescribed and the force read off A p + r. Then S = G
/// A⁻¹ Gᵀ gives μ. A joint that sticks does so to the last bit; a limit ends the step on the limit; a drive
/// is as stiff as its gains say and stable for all of them. Cost: one factorisation per pass, one pass where
/// no joint changes its piece, and `rows` solves with rings.
#pragma once
#include <vector>

#include "haptic_core/dynamics/block_cholesky.h"
#include "haptic_core/dynamics/joint_laws.h"
#include "haptic_core/dynamics/pivoted_cholesky.h"
#include "haptic_core/dynamics/ring.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// Joint laws, rings and mimics of all trees, in the solve of one implicit stage.
class ImplicitJoints {
 public:
  explicit ImplicitJoints(const Model& model);  ///< set-up: room for all of them

  /// No joint does anything by itself: nothing below is needed.
  bool empty() const { return laws_.empty() && rows_ == 0; }
  int rows() const { return rows_; }  ///< of rings and mimics

  /// (in realtime) Before a step: which trees move, by node of the matrix (−1: none).
  void setNodes(const std::vector<int>& node_of_tree, int nodes) noexcept;
  /// (in realtime) Before Newton: the graphs for a stage of length g from `q_base`; puts `v` inside the
  /// limits.
  void startStage(const State& state, const double* q_base, double g, double* v) noexcept;

  /// (in realtime) The Newton step p at v, both in the state's order; `matrix` holds A, assembled, and is
  /// overwritten. q, work: at the reference of the rings' gaps, of which the share `open` is left at v: the
  /// steps taken since then have closed the rest. False: A is not positive definite.
  bool solve(BlockCholesky& matrix, const LinkWork* work, const double* q, const double* v,
             const double* residual, double open, double* p) noexcept;
  /// (in realtime) −(g f + Gᵀ μ)·p at a velocity on the way from v to v + p: what the joints add to R·p.
  double slope(const double* v, const double* p) const noexcept;
  /// (in realtime) Prescribed velocities, to the last bit: rounding in v + p would move a joint that sticks.
  void settle(double* v) const noexcept { laws_.settle(v); }

  /// (in realtime) After a stage: whether no joint hit a limit, stuck or came loose in a step that began with
  /// v0.
  bool isSmooth(const double* v0) const noexcept;
  /// (in realtime) Work of the joints in a step, summed over its stages: each for a time `weight`, with the
  /// forces that it ended with at v, on joints that moved at the mean of `v_way` and v.
  void startAccount() noexcept { work_ = {}; }
  /// (in realtime) See startAccount.
  void account(const double* v_way, const double* v, double weight) noexcept;
  /// (in realtime) Adds the sums to the ledger.
  void closeAccount(State& state) const noexcept;

  bool converged() const { return converged_; }               ///< every joint's force is on its graph
  double driveForce(int link) const { return drive_[link]; }  ///< by world link [N·m] or [N]
  double closure(const LinkWork* work) const noexcept;        ///< largest gap of a ring [m]

 private:
  /// Where a degree stands in the matrix.
  struct Place {
    int tree = 0, local = 0;   ///< its index in the tree's velocities
    int node = -1, row = -1;
  };
  struct TreeRings {
    int tree;
    Rings rings;
    int row;        ///< first of its rows
    double* G;      ///< rows × nv of the tree
    int first = 0;  ///< row of its first degree in the matrix
  };
  void setUp(BlockCholesky& matrix, const double* v, const double* residual) noexcept;
  void evaluateRings(const LinkWork* work, const double* q, double open) noexcept;
  void closeRings(BlockCholesky& matrix) noexcept;
  void readForces() noexcept;

  const Model& model_;
  JointLaws laws_;
  std::vector<Place> law_place_, damped_place_;  ///< of laws_.laws() and laws_.damped()
  std::vector<TreeRings> rings_;
  int rows_ = 0;
  bool converged_ = true;
  double g_ = 0;
  JointWork work_;
  const JointCommand* commands_ = nullptr;
  std::vector<int> row_;  ///< by velocity of the world: its row in the matrix; −1: it does not move by itself
  std::vector<int> velocity_;  ///< by row: velocity of the world
  int matrix_rows_ = 0;
  // Of one solve, by row of the matrix, by row of the rings.
  std::vector<double> rhs_, p_, force_, G_, Y_, phi_, mu_, rate_, drive_;
  std::vector<double> law_force_;  ///< by law, of the last solve
  PivotedCholesky S_;
};

}  // namespace haptic
