#include "haptic_core/dynamics/tree_step.h"

#include <algorithm>

#include "haptic_core/dynamics/articulated_body.h"
#include "haptic_core/dynamics/free_body.h"
#include "haptic_core/dynamics/runge_kutta.h"

namespace haptic {
namespace {

/// Torque about C and acceleration of C; what turns a spinning body by itself is the drift's.
inline void readFree(const LinkModel& link, const Wrench& F, const Vector3& gravity, double* pull) {
  const Vector3 a = F.force / link.mass + gravity;
  for (int k = 0; k < 3; ++k) {
    pull[k] = F.torque[k];
    pull[3 + k] = a[k];
  }
}

inline void kickFree(const LinkModel& link, const Matrix3& R, const double* pull, double dt, double* v) {
  const Vector3 torque(pull[0], pull[1], pull[2]);
  if ((torque.array() != 0).any()) {  // in flight there is none
    const Vector3 torque_L = R.transpose() * torque;
    const Vector3 alpha = R * (link.I_O_inverse * torque_L);
    for (int k = 0; k < 3; ++k) v[k] += dt * alpha[k];
  }
  for (int k = 3; k < 6; ++k) v[k] += dt * pull[k];
}

/// A free body turns and flies on without forces; X_WL.R of its `work` goes with it.
inline void coastFree(const SteppedTree& tree, double h) {
  turnFreeBody(tree.model->link(0), h, tree.work->X_WL.R, tree.q, tree.v);
  for (int k = 0; k < 3; ++k) tree.q[k] += h * tree.v[3 + k];
}

/// Share of v̇ by the wrenches in `work` (gravity and inertia belong to the drift).
void readJointed(const SteppedTree& tree, const Vector3& gravity, TreeStepScratch& scratch, double* pull) {
  const int links = tree.model->linkCount(), nv = tree.model->nv();
  LinkWork* const work = tree.work;
  bool pulled = false;
  for (int i = 0; i < links; ++i) pulled |= !work[i].F_ext.torque.isZero(0) || !work[i].F_ext.force.isZero(0);
  std::fill(pull, pull + nv, 0.0);
  if (!pulled) return;
  double* const alone = scratch.alone.data();
  Wrench* const none = scratch.wrenches.data();  // zeros
  accelerations(*tree.model, gravity, nullptr, nullptr, work, pull);
  for (int i = 0; i < links; ++i) std::swap(work[i].F_ext, none[i]);
  accelerations(*tree.model, gravity, nullptr, nullptr, work, alone);
  for (int i = 0; i < links; ++i) std::swap(work[i].F_ext, none[i]);
  for (int i = 0; i < nv; ++i) pull[i] -= alone[i];
}

/// Generalised forces of the wrenches in `work`. Takes the wrenches away.
void gatherForces(const SteppedTree& tree) {
  std::fill(tree.pull, tree.pull + tree.model->nv(), 0.0);
  for (int i = 0; i < tree.model->linkCount(); ++i) {
    LinkWork& link = tree.work[i];
    const Wrench F = link.F_ext;
    link.F_ext = Wrench{};
    addGeneralisedForce(*tree.model, tree.work, i, F, link.p_WO, tree.pull);
  }
}

inline void kickJointed(const SteppedTree& tree, const double* pull, double dt) {
  for (int i = 0; i < tree.model->nv(); ++i) tree.v[i] += dt * pull[i];
}

/// A tree moves on under gravity and its own inertia.
void coastJointed(const SteppedTree& tree, const Vector3& gravity, double h, TreeStepScratch& scratch) {
  stepRungeKutta(*tree.model, gravity, h, tree.q, tree.v, tree.work, scratch.stages.data());
}

}  // namespace

void TreeStepScratch::fit(const Articulation& articulation) {
  const auto grow = [](auto& scratch, int size) { scratch.resize(std::max<std::size_t>(scratch.size(), size)); };
  grow(stages, rungeKuttaScratch(articulation));
  grow(alone, articulation.nv());
  grow(wrenches, articulation.linkCount());
}

const JointReport* startVerlet(const SteppedTree& tree, const Vector3& gravity, double h, TreeStepScratch& scratch) noexcept {
  const JointReport* joints = nullptr;
  if (tree.motion) {
    const int nv = tree.model->nv();
    std::copy(tree.v, tree.v + nv, tree.half);
    joints = &tree.motion->step(gravity, h, tree.commands, tree.q, tree.v, tree.work, tree.pull);
    for (int i = 0; i < nv; ++i) tree.half[i] = 0.5 * (tree.half[i] + tree.v[i]);
  } else if (tree.model->isFreeBody()) {
    const LinkModel& link = tree.model->link(0);
    kickFree(link, tree.work->X_WL.R, tree.pull, h / 2, tree.v);
    coastFree(tree, h);
    std::copy(tree.v, tree.v + 6, tree.half);
    kickFree(link, tree.work->X_WL.R, tree.pull, h / 2, tree.v);
    placeTurned(link, tree.q, tree.v, *tree.work);
    return nullptr;
  } else {
    kickJointed(tree, tree.pull, h / 2);
    coastJointed(tree, gravity, h, scratch);
    std::copy(tree.v, tree.v + tree.model->nv(), tree.half);
    kickJointed(tree, tree.pull, h / 2);
  }
  forwardKinematics(*tree.model, tree.q, tree.v, tree.work);
  return joints;
}

void finishVerlet(const SteppedTree& tree, const Vector3& gravity, double h, TreeStepScratch& scratch) noexcept {
  readPull(tree, gravity, scratch);
  std::copy(tree.half, tree.half + tree.model->nv(), tree.v);
  if (tree.model->isFreeBody()) {
    LinkWork& work = *tree.work;
    kickFree(tree.model->link(0), work.X_WL.R, tree.pull, h / 2, tree.v);
    work.omega = Vector3(tree.v[0], tree.v[1], tree.v[2]);
    work.velocity = Vector3(tree.v[3], tree.v[4], tree.v[5]);
  } else {
    kickJointed(tree, tree.pull, h / 2);
    forwardVelocities(*tree.model, tree.v, tree.work);
  }
}

void readPull(const SteppedTree& tree, const Vector3& gravity, TreeStepScratch& scratch) noexcept {
  if (tree.motion) {
    gatherForces(tree);
  } else if (tree.model->isFreeBody()) {
    readFree(tree.model->link(0), tree.work->F_ext, gravity, tree.pull);
  } else {
    readJointed(tree, gravity, scratch, tree.pull);
  }
}

}  // namespace haptic
