/// The implicit contact step: end-of-step geometry, friction included, solved by Newton's method in generalised
/// velocities. Stable for any stiffness, damping, mass ratio and step.
///
/// One stage of length g from a base (q_b, v_b, s_b) finds v with
///     R(v) = M(q)(v - v_b) + g (c(q, v) - Σ Jᵀ F(q, v, s) - gravity) = 0,   q = q_b ⊕ g v,  s = s_b + g V_t,
/// F from the contact volumes at q. Newton's matrix M + g D + g² K is symmetric positive definite (K, D of
/// located_force.h) and sparse over the contact graph (block_cholesky.h).
///   implicit Euler  one stage, g = h.
///   SDIRK2          two stages, g = γ h, γ = 1 - 1/√2 (Alexander 1977: second order, L-stable, stiffly accurate):
///                   v_b = v0 + (1-γ) h a1, q_b = q0 ⊕ (1-γ) h v1, s_b = s0 + (1-γ)/γ (s1 - s0).
/// SDIRK2 multiplies the impulses of impacts by up to 2.4, so a step in which the contact set or a friction mode
/// changes, or where the acceleration jumps, is done again as implicit Euler.
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
#include "haptic_core/geometry/broad_phase.h"
#include "haptic_core/geometry/contact_workspace.h"
#include "haptic_core/world/implicit_joints.h"
#include "haptic_core/world/joint_normals.h"
#include "haptic_core/world/plan.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// A contact as the last evaluation found it.
struct ImplicitContact {
  int pair = 0;  ///< index in WorldState::pairs
  int shape_a = 0, shape_b = 0;
  Pose X_WP;
  ContactVolume volume;
  LocatedForce force;
  Matrix6 G_P;         ///< g D + g² K, in P's axes
  double elastic = 0;  ///< ½ k ∫d² dA [J], when the ledger is kept
};

struct ImplicitReport {
  int iterations = 0;   ///< Newton steps, line searches not counted
  int evaluations = 0;  ///< of all contacts
  double residual = 0;  ///< rms speed of the last Newton step [m/s]
  bool converged = true;
  bool fell_back = false;  ///< SDIRK2 was replaced by implicit Euler in this step
};

class ImplicitStep {
 public:
  ImplicitStep(const Plan& plan, const WorldSettings& settings);

  /// (in realtime) Advances q, v and friction by h [s] over the pairs in `state`. `held_by[link] ≥ 0` marks links
  /// that a hand moves: they keep the pose and velocity in `state`. `applied[link]`: wrench on the link about its
  /// frame's origin, in W, constant over the step (the pull of a virtual coupling).
  const ImplicitReport& advance(WorldState& state, const std::vector<int>& held_by,
                                const std::vector<Wrench>& applied, double h) noexcept;

  const ImplicitJoints& joints() const { return joints_; }
  const LoadedVector<ImplicitContact>& contacts() const { return contacts_; }
  const std::vector<LinkWork>& work() const { return work_; }
  const ImplicitReport& report() const { return report_; }

 private:
  void placeFixed();
  void findNodes(const std::vector<int>& held_by) noexcept;
  void setBase(const double* q, const double* v) noexcept;
  void implicitEuler(double h) noexcept;
  bool sdirk2(double h) noexcept;
  bool sameContacts() const noexcept;
  bool solveStage(double g) noexcept;
  bool newton(double g, int max_iterations) noexcept;
  void evaluate(const std::vector<double>& v, double g) noexcept;
  void evaluatePair(int index, double g) noexcept;
  bool assemble() noexcept;
  void assembleContact(const ImplicitContact& contact) noexcept;
  void assembleTreeContact(const ImplicitContact& contact) noexcept;
  Matrix6 freeJacobian(int link, const Pose& X_WP) const noexcept;
  void treeJacobian(int link, const Pose& X_WP, double* J) noexcept;
  bool findDirection() noexcept;
  double slope(const std::vector<double>& v) const noexcept;
  double lineSearch(double g, double phi_0) noexcept;
  double speed(const std::vector<double>& v) const noexcept;
  double farthest() const noexcept;
  void commit(double g) noexcept;

  const Plan& plan_;
  WorldSettings settings_;
  WorldState* state_ = nullptr;
  ImplicitReport report_;
  ImplicitJoints joints_;
  double softness_ = 1;  ///< factor on all stiffness: 1, less during continuation

  const std::vector<Wrench>* applied_ = nullptr;
  std::vector<int> held_by_;

  // Nodes: the trees that move by themselves. Vectors of velocities are in the state's order.
  int nodes_ = 0;
  std::vector<int> node_of_tree_, tree_of_node_, node_size_;
  std::vector<double> q_base_, v_base_, q_, v_, trial_, residual_, step_, v_dot_, acceleration_, rows_;
  std::vector<FrictionMemory> memory_base_;  ///< by pair
  std::vector<LinkWork> work_;
  std::vector<Pose> X_WS_;
  LoadedVector<ImplicitContact> contacts_;
  LoadedVector<BlockCholesky::Edge> edges_;
  BlockCholesky matrix_;
  ContactWorkspace workspace_;
  JointNormals joint_normals_;
  std::vector<double> mass_matrix_, jacobian_a_, jacobian_b_, weighted_, block_;
};

}  // namespace haptic
