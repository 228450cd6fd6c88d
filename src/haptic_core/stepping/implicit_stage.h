/// One stage of an implicit step: passes of convex problems, each frozen where the last one ended.
///
/// A stage of length g from a base (q_b, v_b, s_b) finds v with
///     R(v) = M(q)(v - v_b) + g (c(q, v) - Σ Jᵀ F(q, v, s) - gravity) = 0,   q = q_b ⊕ g v,  s = s_b + g V_t,
/// F from the contact volumes at q and from the virtual couplings.
///
/// A pass evaluates contacts and inertia once, at a reference velocity v_r, and solves the convex problem that has the
/// exact force and stiffness there (frozen_problem.h). Its solution is the reference of the next pass: a pair keeps its
/// patch while what the frozen geometry leaves out is small against the tolerance (`staysValid`), and where that holds for
/// all of them, and no gap closes, there is no next pass. At rest, and wherever patches change little within a step, the
/// stage costs one evaluation and one factorisation. A pair that comes apart during the passes keeps its patch as far
/// as that may still touch: bodies that bounce between two passes would never settle.
///
/// End. With Δ the change of the last pass and ρ its share of that of the pass before, Δ ρ/(1-ρ) is left. It ends at
/// `tolerance` times the step's own error: as a speed |v - v_b|, of which implicit Euler errs by half, and a hundredth of
/// g |gravity|; and -R·p of the last pass, an energy, at the same share of that of these speeds.
/// After the last pass that is allowed, what is left is reported, and `keepEnergy` sees to it that it does no harm.
#pragma once
#include <vector>

#include "haptic_core/contact/located_force.h"
#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/geometry/contact_workspace.h"
#include "haptic_core/stepping/frozen_problem.h"
#include "haptic_core/stepping/implicit_joints.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/contact_evaluation.h"
#include "haptic_core/world/seams.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// A contact as the last evaluation found it, carried to the velocity that the stage ended with.
struct ImplicitContact {
  int pair = 0;  ///< index in State::pairs
  int shape_a = 0, shape_b = 0;
  Pose X_WP;
  ContactVolume volume;
  LocatedForce force;
  Wrench done_P;         ///< what the stage moved the bodies by, on B at P, in P's axes: `force` up to the solve's tolerance
  double elastic = 0;    ///< ½ k ∫d² dA [J]; with the ledger
  bool touching = true;  ///< within a solve: still overlaps
};

/// A spring-damper from a hand's target to a link: part of the solve, so that it may be as stiff as it likes.
struct ImplicitCoupling {
  PointerCoupling law;
  int link = -1;        ///< -1: no target yet, or the hand prescribes the motion
  Pose X_WL;            ///< target at the end of the step
  Twist V_WL;           ///< of the target
  Wrench F_W;           ///< on the link, about its frame's origin: at the end of the stage
  double power = 0;     ///< of it on the link [W]
};

class ImplicitStage {
 public:
  explicit ImplicitStage(const Model& model);

  /// (in realtime) Before the islands of a step of length h [s]: all links at the state's q, v. `held_by[link] ≥ 0`: a hand
  /// moves it, and has put it where the step ends; `moved`: by pointer, its motion over the step, kept by the caller.
  void begin(State& state, const std::vector<int>& held_by, const std::vector<Twist>& moved, double h) noexcept;
  /// (in realtime) The trees that move and the pairs that may touch, until the next call. The arrays stay the caller's.
  void select(const Island& island) noexcept;

  /// (in realtime) Solves a stage of length `g` [s] whose end lies `left` [s] before the step's. v is the guess and the
  /// result. False when not converged: v is the last iterate, `error` says how far.
  bool solve(double g, double left, int most_passes) noexcept {
    return solve(g, left, most_passes, [] { return true; });
  }
  /// (in realtime) The same; gives up where `goesOn()` is false after the first evaluation, whose contacts it may look at.
  template <class GoesOn>
  bool solve(double g, double left, int most_passes, GoesOn&& goesOn) noexcept {
    start(g, left);
    evaluate(g);
    return goesOn() && iterate(g, most_passes);
  }
  /// (in realtime) After an implicit Euler stage from the state's q, v that did not converge: looks at the exact energy of
  /// v and, where it is above that of the start, goes back to the last reference that was not, or slows the island down
  /// until it is not. At most kMostRetreats evaluations.
  void keepEnergy(double g) noexcept;

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
  int iterations() const { return problem_.iterations; }          ///< Newton steps since `begin`
  int factorisations() const { return problem_.factorisations; }  ///< since `begin`
  int evaluations = 0;      ///< of contacts, since `begin`
  double error = 0;         ///< of v, as the last solve left it [m/s]
  double wrench_error = 0;  ///< that it leaves out of balance [N], moments over the body's size

  /// Largest speed of any tree of the island [m/s]; rotations count at the reach of the body.
  double speed(const std::vector<double>& velocity) const noexcept { return problem_.speed(velocity.data()); }

 private:
  void start(double g, double left) noexcept;
  void placeHeld() noexcept;
  bool iterate(double g, int most_passes) noexcept;
  double finest(double g) const noexcept;
  double energyOf(int tree) const noexcept;
  double energy() const noexcept;
  double startEnergy() noexcept;
  void setVelocity(const std::vector<double>& from, double share) noexcept;
  double change(const std::vector<double>& since) noexcept;
  double farthest() const noexcept;
  void evaluate(double g) noexcept;
  bool holds(double g) const noexcept;
  void place(int tree, const std::vector<double>& velocity) noexcept;
  void evaluatePair(int index, double g) noexcept;
  bool staysValid(int slot, double g) const noexcept;
  void lookAhead(int pair, const Pose& X_AB, const Vector3& n, double g) noexcept;
  bool lookAtFaces(int pair, const Pose& X_AB, const Vector3& n, double g) noexcept;
  FrozenContact* nearContact(int pair) noexcept;
  void leave(int slot) noexcept;
  void part(int slot) noexcept;
  void keepAside(int pair, const FrozenContact& contact) noexcept;
  void pull(ImplicitCoupling& coupling) noexcept;
  void finish(double g) noexcept;
  void orderContacts() noexcept;
  int nodeOf(int link) const { return problem_.nodeOf(link); }
  int treeOf(int shape) const { return model_.links[model_.shapes[shape].link].articulation; }

  const Model& model_;
  const WorldSettings& settings_;
  State* state_ = nullptr;
  Island island_;
  ImplicitJoints joints_;
  FrozenProblem problem_;
  bool has_joints_ = false, island_jointed_ = false;
  double tolerance_ = 0, energy_tolerance_ = 0;  ///< of the last pass [m/s, J]
  double mass_ = 0;      ///< of the island [kg]
  double left_ = 0;      ///< from the stage's end to the step's [s]

  std::vector<int> held_by_;                    ///< by link
  const Twist* held_way_ = nullptr;              ///< by pointer: what a hand holds, over the step [rad, m]
  double step_ = 0, held_left_ = 0;             ///< of what hands hold: how far from the step's end it is placed [s]
  std::vector<char> moved_;                     ///< by tree: since its reference
  std::vector<double> q_, before_, residual_, v_dot_, calm_;
  std::vector<double> tree_energy_;             ///< by tree: kinetic and potential at its reference [J]
  double calm_energy_ = 0;                      ///< of the island at v = calm_, the reference of least energy so far [J]
  std::vector<LinkWork> work_;
  std::vector<int> first_shape_;                ///< by tree, with the end of the last
  std::vector<Pose> X_WS_;
  LoadedVector<ImplicitContact> contacts_;      ///< within a solve: parallel to the problem's
  std::vector<int> slot_, near_;                ///< by pair: index in contacts_ of its patch, of what is near; or -1
  std::vector<double> gap_;                     ///< by pair that does not touch: proven at its last evaluation [m]
  double reach_ = 0;                            ///< gap that may close within the pass: way of the last one [m]
  bool rough_ = false;                          ///< a patch of this pass has not the exact force: not the last pass
  ContactWorkspace workspace_;
  Seams seams_;
};

}  // namespace haptic
