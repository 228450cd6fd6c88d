/// One pass of a stage: the implicit step with all geometry frozen at a reference.
///
/// With δ = v - v_r, r the residual of inertia, gravity and wrenches at the reference and M the inertia there, it finds the root of
///     R(v) = r + M δ + Σ Jᵀ (C J δ - g F_r) - g Σ Jᵀ f(J δ) - g Σ Jᵀ F(V_r + J δ),
/// F_r and C value and derivative of force elements and couplings, f their forces along a line within a limit (frozen_contact.h), F the
/// wrenches of frozen patches (frozen_patch.h). If friction kept its limit, R would be the gradient of a strictly convex
/// function: M and C are positive, f and F fall with the twist. The joints' own laws come in as in
/// implicit_joints.h, convex as well. The limit follows the normal force N, and adds a part that is not symmetric. Newton's method:
///     (A + Σ Jᵀ b nᵀ G J) p = -R,   A = M + Σ JᵀCJ + Σ JᵀGJ,  C with the line's part where it is within its limit,
/// with G = -g ∂F/∂V while the limit stays, nᵀ G its row of the normal force, and b = ∂F/∂N of sliding patches. A is symmetric positive
/// definite and sparse over the graph of contacts (block_cholesky.h); the rest takes some more solves on its factor (`followLoad`).
/// Then the root of φ(α) = R(v + α p)·p, on the frozen forces alone. No geometry is asked in here. While the limit was that of
/// the last Newton step, a heap of 100 cubes took half as many factorisations again, and two bodies that meet at 1e12 N/m³ none
/// were enough for.
///
/// Friction that turned over within a Newton step came to rest in it. Either side of the turn slides, and answers by little; between
/// them lies the slip at which it sticks, μN/(g² k_t A0/m) narrow as a speed, and answers with all of k_t: Newton's method jumps across
/// it, and line searches end in one such range after another. So the next step takes it for stuck, with the force that it then would
/// have; where it has to hold more than its limit, it slides again (a primal-dual active set: Hintermüller, Ito, Kunisch, SIAM J.
/// Optim. 13, 2002). Without it a heap of 100 at 1e10 N/m³ takes 15 factorisations a step for 9.5.
///
/// An island joins bodies that are near; those that its patches do not join are problems of their own (parts), with their own matrix,
/// line searches and number of steps: a body that bounces somewhere in a pile costs the rest of it nothing.
///
/// Source: A. Castro, F. Permenter, X. Han, An unconstrained convex formulation of compliant contact, 2021 (arXiv
/// 2110.10107). Different here: Coulomb's limit is that of the normal force, so nothing that slides floats; the patches
/// are refrozen (stage_reference.h) instead of being taken from the start of the step.
#pragma once
#include <limits>
#include <vector>

#include "haptic_core/base/gmres.h"
#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/geometry/volume/loaded_vector.h"
#include "haptic_core/stepping/frozen_contact.h"
#include "haptic_core/stepping/frozen_matrix.h"
#include "haptic_core/stepping/implicit_joints.h"
#include "haptic_core/stepping/island_parts.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/model.h"

namespace haptic {

/// How the solve of a pass, or of a part of its island, ended.
struct PassEnd {
  bool solved = true;                 ///< false: a matrix could not be factored
  int iterations = 0;                 ///< Newton steps, of the part that took most
  int factorisations = 0;             ///< likewise
  double units = 0;                   ///< counted work (world/counted_work.h)
  double decrement = 0;               ///< -R·p at its start [J]
  double imbalance = 0;               ///< largest wrench out of balance at its start [N], moments over the body's size
  double remainder = 0;               ///< estimated size of another Newton step, and of what friction beyond its limit moves [m/s]
  double energy_remainder = 0;        ///< estimated gain of that step [J]
};

/// The problem of one pass over one island, and its solver.
class FrozenProblem {
 public:
  explicit FrozenProblem(const Model& model);  ///< set-up: room for every contact and tree of the model

  /// (in realtime) The trees that move. `work`: their links at the reference; it stays the caller's.
  void select(const Island& island, LinkWork* work, ImplicitJoints* joints) noexcept;
  /// (in realtime) The reference of a tree: v_r, r, and M from its links as they stand.
  void freezeTree(int tree, const double* v, const double* residual) noexcept;

  /// (in realtime) At most `most` Newton steps of each part from v, until one is smaller than a fifth of what all have changed, or
  /// than `finest` [m/s], or goes all the way to the root, with the force on none of several bodies wrong by a fiftieth of the step
  /// or `enough` [m/s]. q: positions at the reference. Parts of which no tree has `moved` since the last call stay, and so does
  /// what remains of them.
  PassEnd solve(double g, int most, double finest, double enough, const std::vector<char>& moved, const double* q, double* v) noexcept;

  LoadedVector<FrozenContact> contacts;    ///< of the island, filled by StageContacts
  LoadedVector<FrozenForce> forces;        ///< of the island, filled by stage_forces.h

  void forget() noexcept;               ///< (in realtime) the arrays of the last island are no longer there

  /// (in realtime) Of a link's point [m] by u; zero for links that the island does not move.
  Twist linkTwist(int link, const Vector3& p_W, const double* u) const noexcept;
  /// (in realtime) J u of a contact in P's axes; `u` in the order of the state.
  Vector6 twistOf(const FrozenContact& c, const double* u) const noexcept;
  /// (in realtime) Of B's point over A's by u, in W.
  Twist twistOf(const FrozenForce& c, const double* u) const noexcept;
  double massNorm2(const double* u) const noexcept;  ///< (in realtime) uᵀ M u of the island [J]
  /// (in realtime) Largest speed of a tree of the island [m/s]; rotations count at the reach of the body.
  double speed(const double* velocity) const noexcept;
  /// (in realtime) The same of one tree [m/s].
  double speedOf(int tree, const double* velocity) const noexcept;
  double massOf(int link) const noexcept {       ///< of a link that the island moves [kg]; else infinite
    return nodeOf(link) >= 0 ? model_.links[link].mass : std::numeric_limits<double>::infinity();
  }
  const std::vector<double>& reference() const { return v_reference_; }  ///< v_r, in the state's order
  /// Of the tree of a link; -1: the island does not move it.
  int nodeOf(int link) const { return node_of_tree_[model_.links[link].articulation]; }
  bool moves(int link) const { return link >= 0 && nodeOf(link) >= 0; }  ///< the island moves it; link −1: W

 private:
  void select(int part) noexcept;
  PassEnd solvePart(double g, int most, double finest, double enough, const double* q, double* v) noexcept;
  template <class Visit>
  void eachContact(Visit&& visit) noexcept {
    for (int i = 0; i < part_.contact_count; ++i) visit(contacts[part_.contacts[i]]);
  }
  template <class Visit>
  void eachForce(Visit&& visit) noexcept {
    for (int i = 0; i < part_.force_count; ++i) visit(forces[part_.forces[i]]);
  }
  void addForce(int link, const Wrench& F_W, const Vector3& p_W, double* rows) const noexcept;
  void addContact(const FrozenContact& c, const Vector6& F_BP_P, double* rows) const noexcept;
  void addBetween(const FrozenForce& c, const Wrench& F_W, double* rows) const noexcept;
  void smoothPart(double g, const double* v) noexcept;
  void inertialPart(const double* v) noexcept;
  void linearForces(double g) noexcept;
  double imbalance(double g) const noexcept;
  bool anyPulls() noexcept;
  double speedBeyondLimit(double g) noexcept;
  double missedSpeed(int link_a, int link_b, double missed, double g) const noexcept;
  bool findStep(double g, const double* q, const double* v, double open) noexcept;
  void followLoad(double g, const double* v) noexcept;
  void stepUnder(const double* y, const double* v, std::vector<double>& step) noexcept;
  void missedLoad(const double* v, const double* y, double* left) noexcept;
  void stepFor(const std::vector<double>& residual, const double* v, std::vector<double>& step) noexcept;
  double search(double g, const double* v, double& left) noexcept;
  double dot(const std::vector<double>& a, const std::vector<double>& b) const noexcept;
  template <class Visit>
  void eachVelocity(Visit&& visit) const noexcept;
  double curvature() noexcept;
  double slopeAt(double g, double alpha, double along, double curvature, const double* v) noexcept;
  const ModelTree& treeAt(int n) const { return model_.trees[part_.trees[n]]; }

  const Model& model_;
  Island island_;
  LinkWork* work_ = nullptr;
  ImplicitJoints* joints_ = nullptr;    ///< null: no joint of the island does anything by itself
  std::vector<int> node_of_tree_;
  IslandParts parts_;
  IslandPart part_;                     ///< that is being solved
  std::vector<TreePair> joined_;        ///< by contact, then by force
  std::vector<double> remainder_, energy_remainder_;  ///< by the part's first tree, of its last solve
  std::vector<double> v_reference_, r_reference_, smooth_, residual_, step_, loaded_, trial_, rows_;
  std::vector<double> slid_load_;       ///< by patch of the part that slides: y of `followLoad` [N·s]
  FrozenMatrix matrix_;
  Gmres load_solver_;
};

}  // namespace haptic
