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
/// After the last pass that is allowed the remaining error is reported, and `keepEnergy` keeps it from adding energy.
#pragma once
#include <vector>

#include "haptic_core/dynamics/kinematics.h"
#include "haptic_core/stepping/depth_limit.h"
#include "haptic_core/stepping/frozen_problem.h"
#include "haptic_core/stepping/implicit_joints.h"
#include "haptic_core/stepping/stage_contacts.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/islands.h"
#include "haptic_core/world/link_forces.h"
#include "haptic_core/world/model.h"
#include "haptic_core/world/state.h"

namespace haptic {

/// A spring-damper from a hand's target to a link: part of the solve, so that it may be as stiff as it likes.
struct ImplicitCoupling {
  PointerCoupling law;  ///< with nothing left to derive
  int link = -1;        ///< -1: no target yet, or the hand prescribes the motion
  Pose X_WL;            ///< target at the end of the step
  Twist V_WL;           ///< of the target
  Wrench F_W;           ///< on the link, about its frame's origin: at the end of the stage
  double power = 0;     ///< of it on the link [W]
};

/// Solves implicit stages: one object for all islands of a world, one island after another.
class ImplicitStage {
 public:
  explicit ImplicitStage(const Model& model);  ///< set-up: room for the largest island

  /// (in realtime) Before the islands of a step of length h [s]: the links of `trees`, and once those that never move, at the state's
  /// q, v. What hands hold has been put where the step ends; `hands` and `seams` stay the caller's.
  void begin(State& state, const std::vector<int>& trees, const HandWork& hands, Seams& seams, double h) noexcept;
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
  /// v and, where it is above that of the start and what hands supply meanwhile, goes back to the last reference that was not, or slows
  /// the island down until it is not. Three evaluations at most. The energy that is then lost [J]; negative: a hand supplied it.
  double keepEnergy(double g) noexcept;

  // The base of the stage, in the state's order; only what belongs to the island is read.
  std::vector<double> q_base, v_base, v;    ///< base positions and velocities; guess and result
  std::vector<FrictionMemory> memory_base;  ///< by pair
  std::vector<Yielding> yielding;           ///< by pair
  std::vector<ImplicitCoupling> couplings;  ///< by pointer

  bool limited = false;                     ///< a reference of the last solve lay short of its iterate
  double run = 0;                           ///< how long belts have run since `memory_base` [s]: where that is not the base's time

  const Island& island() const { return island_; }          ///< of the last `select`
  ImplicitJoints& joints() { return joints_; }              ///< of the island
  const ImplicitJoints& joints() const { return joints_; }  ///< of the island
  bool hasJoints() const { return has_joints_; }  ///< the island's joints do something by themselves
  /// As the last solve left them.
  const LoadedVector<ImplicitContact>& contacts() const { return contacts_.all(); }
  const LoadedVector<Brush>& brushes() const { return contacts_.brushes(); }  ///< what pressed in the last solve beside them
  bool hasForces() const { return has_forces_; }  ///< force elements act on the island
  /// Of the island's force elements: as the last `select` found them, and since then as the last solve left them.
  const ForcePower& forcePower() const { return force_power_; }
  double handsPower() const { return contacts_.handsPower(); }  ///< what hands that lead a link put into all of these [W]
  int iterations() const { return problem_.iterations; }          ///< Newton steps since `begin`
  int factorisations() const { return problem_.factorisations; }  ///< since `begin`
  int evaluations = 0;      ///< of contacts, since `begin`
  double error = 0;         ///< of v, as the last solve left it [m/s]
  double wrench_error = 0;  ///< that it leaves out of balance [N], moments over the body's size

  /// Largest speed of any tree of the island [m/s]; rotations count at the reach of the body.
  double speed(const std::vector<double>& velocity) const noexcept { return problem_.speed(velocity.data()); }
  /// Speed below which a solve of length g goes on rounding [m/s]: of the speeds themselves, and of coordinates.
  double finest(double g) const noexcept;

 private:
  void start(double g, double left) noexcept;
  void placeHeld() noexcept;
  bool iterate(double g, int most_passes) noexcept;
  double energyOf(int tree) const noexcept;
  double energy() const noexcept;
  double supply(double g) const noexcept;
  double startEnergy() noexcept;
  void setVelocity(const std::vector<double>& from, double share, double g) noexcept;
  double change(const std::vector<double>& since) noexcept;
  void sinceReference() noexcept;
  double farthest() const noexcept;
  void evaluate(double g, bool may_limit = true) noexcept;
  void move(double g) noexcept;
  bool mayGetDeep(double g) noexcept;
  bool holds() const noexcept;
  void selectForces() noexcept;
  void freezeForces(double g) noexcept;
  void bookForces(double g, bool moves_on) noexcept;
  bool forcesBend() const noexcept;
  Twist ledTwist(int link, const Vector3& p_W) const noexcept;
  void place(int tree, const std::vector<double>& velocity) noexcept;
  void pull(ImplicitCoupling& coupling) noexcept;
  void finish(double g) noexcept;

  const Model& model_;
  const WorldSettings& settings_;
  State* state_ = nullptr;
  Island island_;
  ImplicitJoints joints_;
  FrozenProblem problem_;
  StageContacts contacts_;
  DepthLimit limit_;
  bool has_joints_ = false, island_jointed_ = false, has_forces_ = false;
  std::vector<LinkForce> force_;         ///< by element of the model: at its reference
  ForcePower force_power_;
  double stored_ = 0;                    ///< energy of the springs of the island's force elements at their references [J]
  bool fixed_placed_ = false;            ///< the links that never move are where they are
  StageTolerance tolerance_;             ///< of the last pass
  double changed_ = 0;   ///< largest change of speed in it [m/s]
  double mass_ = 0;      ///< of the island [kg]
  double left_ = 0;      ///< from the stage's end to the step's [s]

  std::vector<int> held_by_;                    ///< by link
  const Twist* held_way_ = nullptr;              ///< by lead: motion of the held link over the step [rad, m]
  double step_ = 0, held_left_ = 0;             ///< of held links: how far from the step's end they are placed [s]
  std::vector<char> moved_;                     ///< by tree: since its reference
  std::vector<double> q_, before_, residual_, v_dot_, calm_;
  std::vector<double> tree_energy_;             ///< by tree: kinetic and potential at its reference [J]
  double calm_energy_ = 0;                      ///< of the island at v = calm_, less supply: the least of a reference so far [J]
  std::vector<LinkWork> work_;
  std::vector<int> first_shape_;                ///< by tree, with the end of the last
  std::vector<Pose> X_WS_;                       ///< by shape: at the reference
  bool first_ = true;                            ///< no reference yet: the one before is the base
};

}  // namespace haptic
