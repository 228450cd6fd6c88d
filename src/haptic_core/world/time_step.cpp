/// The explicit time steps.
///
/// Symplectic Euler: forces at (q, v), v += h M⁻¹F, q ⊕= h v. First order, one evaluation.
///
/// Velocity Verlet: v½ = v + h/2 a, q₁ = q ⊕ h v½, forces at (q₁, v½ + h/2 a), v₁ = v½ + h/2 a₁. Second order and one
/// evaluation as well, since a₁ is the next step's a. Forces jump or bend where a contact begins, ends or yields
/// inside the step; the impulse that h/2 (F₀ + F₁) then misses is computed from the located instant and added to the
/// second kick (located_force.cpp, friction.cpp, Pipeline::part), which keeps the order.
/// Between the kicks a free body moves without forces, to fifth order (dynamics/free_body.h), and a tree under gravity, to
/// fourth (dynamics/runge_kutta.h): chains whip, and their Coriolis forces are no smaller than contact forces.
///
/// Trees whose joints have laws of their own (limits, friction, drives, loops) move by TreeMotion's symplectic Euler in
/// both: their forces jump within a step, and an implicit first-order step keeps them dissipative at any gain
/// (joint_step.cpp). Under Velocity Verlet contact forces on them are those of the step's start.
#include <algorithm>

#include "haptic_core/dynamics/articulated_body.h"
#include "haptic_core/dynamics/free_body.h"
#include "haptic_core/dynamics/runge_kutta.h"
#include "haptic_core/world/features.h"
#include "haptic_core/world/pipeline.h"

namespace haptic {

/// `progress`: the share of the way to the pointers' targets that this substep covers.
void Pipeline::substep(double h, double progress) noexcept {
  if (kFullWorld && automatic_) {
    substepAutomatic(h, progress);
  } else if (kFullWorld && implicit_) {
    substepImplicit(h, progress);
  } else {
    if (settings_.integrator == Integrator::kVelocityVerlet) {
      prime(h);
      substepVerlet(h, progress);
      if (pointerCount() > 0) collectPointerWrenches();
    } else {
      substepEuler(h, progress);
    }
  }
  if (keepsLedger()) fillLedger();
  checkFinite();
}

bool Pipeline::movesByItself(const PlanTree& tree) const noexcept {
  return !tree.model->isStatic() && heldBy(tree.link) < 0;
}

/// By the explicit scheme.
bool Pipeline::isStepped(const PlanTree& tree) const noexcept {
  return movesByItself(tree) && !isImplicit(indexOf(tree));
}

/// Contacts and pulls here and now, for velocity Verlet. False: automatic choice made some tree implicit, and the attempt is void.
bool Pipeline::evaluate(const Advance& advance, double h) noexcept {
  const bool automatic = kFullWorld && automatic_;
  findPairs(automatic && anyImplicit() ? h : 0);
  if (automatic && modesMeet()) {
    makeImplicit(false);
    return false;
  }
  evaluateContacts(advance);
  if (automatic && anyTooStiff()) {
    makeImplicit(true);
    return false;
  }
  if (pointerCount() > 0) pullPointers(advance.time);
  return true;
}

/// Torque about C and acceleration of C; what turns a spinning body by itself is the drift's.
inline void Pipeline::readFree(const PlanTree& body, double* pull) const noexcept {
  const LinkWork& work = work_[body.link];
  const Vector3 a = work.F_ext.force / body.model->link(0).mass + settings_.gravity;
  for (int k = 0; k < 3; ++k) {
    pull[k] = work.F_ext.torque[k];
    pull[3 + k] = a[k];
  }
}

/// v += dt M⁻¹ pull, at the rotation in `work_`.
inline void Pipeline::kickFree(const PlanTree& body, const double* pull, double dt) noexcept {
  double* v = state_.v.data() + body.v;
  const Matrix3& R = work_[body.link].X_WL.R;
  const Vector3 torque_L = R.transpose() * Vector3(pull[0], pull[1], pull[2]);
  const Vector3 alpha = R * (body.model->link(0).I_O_inverse * torque_L);
  for (int k = 0; k < 3; ++k) {
    v[k] += dt * alpha[k];
    v[3 + k] += dt * pull[3 + k];
  }
}

/// Between the kicks a free body turns and flies on without forces, to fifth order.
inline void Pipeline::coastFree(const PlanTree& body, double h) noexcept {
  stepFreeBody(body.model->link(0), Vector3::Zero(), h, state_.q.data() + body.q, state_.v.data() + body.v);
}

void Pipeline::substepEuler(double h, double progress) noexcept {
  if (pointerCount() > 0) movePointers(progress);
  findPairs(0);
  evaluateContacts({h, 0});
  if (pointerCount() > 0) pullPointers(h);
  // What the hands feel is read from the links' wrenches, which the kinematics at the end clear.
  if (pointerCount() > 0) collectPointerWrenches();
  if (keepsLedger()) std::copy(state_.v.begin(), state_.v.end(), half_.begin());
  for (const PlanTree* body : free_movers_) {
    double pull[6];
    readFree(*body, pull);
    kickFree(*body, pull, h);
  }
  if (keepsLedger()) meanOfKick();
  for (const PlanTree* body : free_movers_) coastFree(*body, h);
  for (const PlanTree* tree : jointed_movers_) eulerTree(*tree, h);
  if (keepsLedger()) bookEuler(h);
  updateKinematics();
}

/// The velocities of free bodies over the kick, for the ledger: half_ held those before it.
void Pipeline::meanOfKick() noexcept {
  for (const PlanTree* body : free_movers_) {
    for (int i = body->v; i < body->v + 6; ++i) half_[i] = 0.5 * (half_[i] + state_.v[i]);
  }
}

void Pipeline::eulerTree(const PlanTree& tree, double h) noexcept {
  if (tree.has_laws) {
    moveJointed(tree, h, nullptr);
    return;
  }
  double* pull = v_dot_.data() + tree.v;
  double* v = state_.v.data() + tree.v;
  double* mean = half_.data() + tree.v;  // over the kick, for the ledger
  readTree(tree, pull);
  kickTree(tree, pull, h);
  for (int i = 0; keepsLedger() && i < tree.model->nv(); ++i) mean[i] = 0.5 * (mean[i] + v[i]);
  coastTree(tree, h);
}

/// What a tree does between the kicks: it moves under gravity and its own inertia, to fourth order.
void Pipeline::coastTree(const PlanTree& tree, double h) noexcept {
  LinkWork* work = work_.data() + tree.link;
  for (int i = 0; i < tree.model->linkCount(); ++i) work[i].F_ext = Wrench{};
  stepRungeKutta(*tree.model, settings_.gravity, h, state_.q.data() + tree.q, state_.v.data() + tree.v, work, coasting_.data());
}

/// What pulls at the trees whose last step was not one of velocity Verlet.
void Pipeline::prime(double h) noexcept {
  const auto unprimed = [this](const PlanTree& tree) {
    return isStepped(tree) && state_.mode[indexOf(tree)] == kUnprimed;
  };
  if (std::none_of(plan_.trees.begin(), plan_.trees.end(), unprimed)) return;
  do updateKinematics();
  while (!evaluate({0, 0.5}, h));
  for (const PlanTree& tree : plan_.trees) {
    if (!unprimed(tree)) continue;
    tree.has_laws ? gatherPull(tree, h) : readTree(tree, state_.pull.data() + tree.v);
    state_.mode[indexOf(tree)] = kPrimed;
  }
  if (keepsLedger()) notePowers(h);
}

/// False: void, see `evaluate`; the caller takes it back.
bool Pipeline::substepVerlet(double h, double progress) noexcept {
  for (const PlanTree* body : free_movers_) {
    if (isExplicit(*body)) startFree(*body, h);
  }
  for (const PlanTree* tree : jointed_movers_) {
    if (isExplicit(*tree)) startTree(*tree, h);
  }
  if (pointerCount() > 0) movePointers(progress);
  updateKinematics();
  if (!evaluate({h, 0.5}, h)) return false;
  for (const PlanTree* body : free_movers_) {
    if (isExplicit(*body)) finishFree(*body, h);
  }
  for (const PlanTree* tree : jointed_movers_) {
    if (isExplicit(*tree)) finishTree(*tree, h);
  }
  if (keepsLedger()) bookVerlet(h);
  return true;
}

/// Half a kick and the drift; leaves v½ in half_ and the predicted end velocity in v.
void Pipeline::startFree(const PlanTree& body, double h) noexcept {
  const double* pull = state_.pull.data() + body.v;
  const double *q = state_.q.data() + body.q, *v = state_.v.data() + body.v;
  kickFree(body, pull, h / 2);
  coastFree(body, h);
  work_[body.link].X_WL.R = Quaternion(q[3], q[4], q[5], q[6]).toRotationMatrix();
  std::copy(v, v + 6, half_.data() + body.v);
  kickFree(body, pull, h / 2);
}

void Pipeline::startTree(const PlanTree& tree, double h) noexcept {
  const double* pull = state_.pull.data() + tree.v;
  if (tree.has_laws) {
    moveJointed(tree, h, pull);
    return;
  }
  const double* v = state_.v.data() + tree.v;
  kickTree(tree, pull, h / 2);
  coastTree(tree, h);
  std::copy(v, v + tree.model->nv(), half_.data() + tree.v);
  kickTree(tree, pull, h / 2);
}

/// The other half of the kick, from v½, and what located events add to it.
void Pipeline::finishFree(const PlanTree& body, double h) noexcept {
  double* v = state_.v.data() + body.v;
  double* pull = state_.pull.data() + body.v;
  LinkWork& work = work_[body.link];
  readFree(body, pull);
  std::copy(half_.data() + body.v, half_.data() + body.v + 6, v);
  if (!has_kick_) {
    kickFree(body, pull, h / 2);
  } else {
    double with_events[6];
    const Wrench F = work.F_ext;
    work.F_ext += kick_[body.link] * (2 / h);
    readFree(body, with_events);
    kickFree(body, with_events, h / 2);
    work.F_ext = F;
  }
  work.omega = Vector3(v[0], v[1], v[2]);
  work.velocity = Vector3(v[3], v[4], v[5]);
}

void Pipeline::finishTree(const PlanTree& tree, double h) noexcept {
  if (tree.has_laws) {
    gatherPull(tree, h);
    return;
  }
  const int nv = tree.model->nv();
  double* v = state_.v.data() + tree.v;
  double* pull = state_.pull.data() + tree.v;
  readTree(tree, pull);
  std::copy(half_.data() + tree.v, half_.data() + tree.v + nv, v);
  if (!has_kick_) {
    kickTree(tree, pull, h / 2);
  } else {
    for (int i = 0; i < tree.model->linkCount(); ++i) work_[tree.link + i].F_ext += kick_[tree.link + i] * (2 / h);
    readTree(tree, v_dot_.data() + tree.v);
    kickTree(tree, v_dot_.data() + tree.v, h / 2);
    for (int i = 0; i < tree.model->linkCount(); ++i) work_[tree.link + i].F_ext += kick_[tree.link + i] * (-2 / h);
  }
  forwardVelocities(*tree.model, v, work_.data() + tree.link);
}

/// What the wrenches in `work_` add to v̇ (gravity and inertia are the drift's).
void Pipeline::readTree(const PlanTree& tree, double* pull) noexcept {
  if (isFree(tree)) {
    readFree(tree, pull);
    return;
  }
  LinkWork* work = work_.data() + tree.link;
  const int links = tree.model->linkCount(), nv = tree.model->nv();
  bool pulled = false;
  for (int i = 0; i < links; ++i) pulled |= !work[i].F_ext.torque.isZero(0) || !work[i].F_ext.force.isZero(0);
  std::fill(pull, pull + nv, 0.0);
  if (!pulled) return;
  double* free = alone_.data() + tree.v;
  accelerations(*tree.model, settings_.gravity, nullptr, nullptr, work, pull);
  for (int i = 0; i < links; ++i) std::swap(work[i].F_ext, no_wrench_[i]);
  accelerations(*tree.model, settings_.gravity, nullptr, nullptr, work, free);
  for (int i = 0; i < links; ++i) std::swap(work[i].F_ext, no_wrench_[i]);
  for (int i = 0; i < nv; ++i) pull[i] -= free[i];
}

void Pipeline::kickTree(const PlanTree& tree, const double* pull, double dt) noexcept {
  if (isFree(tree)) {
    kickFree(tree, pull, dt);
    return;
  }
  double* v = state_.v.data() + tree.v;
  for (int i = 0; i < tree.model->nv(); ++i) v[i] += dt * pull[i];
}

}  // namespace haptic
