/// One stage of an implicit step: Newton's method in generalised velocities, contacts at the end of the stage.
///
/// A stage of length g from a base (q_b, v_b, s_b) finds v with
///     R(v) = M(q)(v - v_b) + g (c(q, v) - Σ Jᵀ F(q, v, s) - gravity) = 0,   q = q_b ⊕ g v,  s = s_b + g V_t,
/// F from the contact volumes at q and from the virtual couplings. Newton's matrix M + g D + g² K is symmetric positive
/// definite (K, D of located_force.h) and sparse over the contact graph (block_cholesky.h).
///
/// What joints do by themselves (limits, friction, drives, loops) enters every Newton step (implicit_joints.h).
///
/// Line search. R has no potential, so the step α p is judged by φ(α) = R(v + α p)·p, which rises from φ(0) < 0
/// through zero at the best α when M + gD + g²K is right. Where fifteen iterations do not converge, the stiffness is
/// raised in steps of ten from where it equals the inertia: each solution is the start of the next.
#pragma once
#include <memory>
#include <vector>

#include "haptic_core/contact/located_force.h"
#include "haptic_core/dynamics/block_cholesky.h"
#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/geometry/contact_workspace.h"
#include "haptic_core/stepping/implicit_joints.h"
#include "haptic_core/world/seams.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// A contact as the last evaluation found it.
struct ImplicitContact {
  int pair = 0;  ///< index in State::pairs
  int shape_a = 0, shape_b = 0;
  Pose X_WP;
  ContactVolume volume;
  LocatedForce force;
  Matrix6 G_P;         ///< g D + g² K, in P's axes
  double stiffness = 0;  ///< k as the evaluation took it [N/m³]
  double elastic = 0;    ///< ½ k ∫d² dA [J]; see measureElastic
};

/// A spring-damper from a hand's target to a link: part of the solve, so that it may be as stiff as it likes.
struct ImplicitCoupling {
  PointerCoupling law;
  int link = -1;        ///< -1: no target yet, or the hand prescribes the motion
  Pose X_WL;            ///< target at the end of the step
  Twist V_WL;           ///< of the target
  Wrench F_W;           ///< on the link, about its frame's origin: of the last evaluation
  double power = 0;     ///< of it on the link [W]
};

class ImplicitStage {
 public:
  explicit ImplicitStage(const Model& model);

  /// (in realtime) Before the islands of a step: all links at the state's q, v. `held_by[link] ≥ 0`: a hand moves it.
  void begin(State& state, const std::vector<int>& held_by) noexcept;
  /// (in realtime) The trees that move and the pairs that may touch, until the next call. The arrays stay the caller's.
  void select(const Island& island) noexcept;

  /// (in realtime) Solves a stage of length `g` [s] whose end lies `left` [s] before the step's. v is the guess and the
  /// result. False when not converged: v is the last iterate, `residual` says how far.
  bool solve(double g, double left) noexcept;

  /// (in realtime) Fills `elastic` of the contacts at the last evaluation, for the ledger: Newton's iterates do without.
  void measureElastic() noexcept;

  // The base of the stage, in the state's order; only what belongs to the island is read.
  std::vector<double> q_base, v_base, v;
  std::vector<FrictionMemory> memory_base;  ///< by pair
  std::vector<Yielding> yielding;           ///< by pair
  std::vector<ImplicitCoupling> couplings;  ///< by pointer

  const Island& island() const { return island_; }
  ImplicitJoints& joints() { return joints_; }
  const ImplicitJoints& joints() const { return joints_; }
  bool hasJoints() const { return has_joints_; }  ///< the island's joints do something by themselves
  const LoadedVector<ImplicitContact>& contacts() const { return contacts_; }
  int iterations = 0;   ///< Newton steps since `begin`, line searches not counted
  int evaluations = 0;  ///< of all contacts
  double residual = 0;  ///< speed of the last Newton step [m/s]

  /// Largest speed of any tree of the island [m/s]; rotations count at the reach of the body.
  double speed(const std::vector<double>& velocity) const noexcept;

 private:
  void start(double g) noexcept;
  bool newton(double g, int max_iterations) noexcept;
  bool findDirection() noexcept;
  double slope(const std::vector<double>& velocity) const noexcept;
  void move(double alpha, const std::vector<double>& from, std::vector<double>& to) noexcept;
  double slidingNoise(double g) const noexcept;
  double normalStep() const noexcept;
  bool converges(double g, double last) const noexcept;
  void evaluate(const std::vector<double>& velocity, double g) noexcept;
  void place(int tree, const std::vector<double>& velocity) noexcept;
  void evaluatePair(int index, double g) noexcept;
  void findVolume(int pair, ContactVolume& volume) noexcept;
  void pull(ImplicitCoupling& coupling) noexcept;
  bool assemble(double g) noexcept;
  void assembleMass(int node) noexcept;
  void assembleContact(const ImplicitContact& contact) noexcept;
  void assembleCoupling(const ImplicitCoupling& coupling, double g) noexcept;
  void assembleTrees(int link_a, int link_b, const Pose& X_WP, const Matrix6& G_P) noexcept;
  Matrix6 freeJacobian(int link, const Pose& X_WP) const noexcept;
  void treeJacobian(int link, const Pose& X_WP, double* J) noexcept;
  double lineSearch(double g, double phi_0) noexcept;
  double farthest() const noexcept;
  int nodeOf(int link) const { return node_of_tree_[model_.links[link].articulation]; }
  bool isFree(int link) const { return model_.trees[model_.links[link].articulation].model->isFreeBody(); }

  const Model& model_;
  const WorldSettings& settings_;
  State* state_ = nullptr;
  Island island_;
  ImplicitJoints joints_;
  bool has_joints_ = false;
  double softness_ = 1;  ///< factor on all stiffness: 1, less during continuation
  double left_ = 0;      ///< from the stage's end to the step's [s]

  std::vector<int> held_by_;                    ///< by link
  std::vector<int> node_of_tree_, node_size_;   ///< nodes: the island's trees, in order
  std::vector<double> q_, trial_, residual_, step_, v_dot_, rows_;
  std::vector<LinkWork> work_;
  std::vector<int> first_shape_;                ///< by tree, with the end of the last
  std::vector<Pose> X_WS_;
  LoadedVector<ImplicitContact> contacts_;
  int in_workspace_ = -1;                       ///< contact whose V the workspace still holds
  LoadedVector<BlockCholesky::Edge> edges_;
  BlockCholesky matrix_;
  ContactWorkspace workspace_;
  Seams seams_;
  std::vector<double> mass_matrix_, jacobian_a_, jacobian_b_, weighted_, block_;
};

}  // namespace haptic
