#include "haptic_core/dynamics/runge_kutta.h"

#include <cmath>

#include "haptic_core/dynamics/free_momentum.h"
#include "haptic_core/dynamics/quaternion_step.h"

namespace haptic {
namespace {

/// Merson's tableau: stage s starts from q + h Σ kA[s][j] k_j; the step is q + h Σ kB[s] k_s.
constexpr int kStages = 5;
constexpr double kA[kStages][kStages - 1] = {{}, {1. / 3}, {1. / 6, 1. / 6}, {1. / 8, 0, 3. / 8}, {1. / 2, 0, -3. / 2, 2}};
constexpr double kB[kStages] = {1. / 6, 0, 0, 2. / 3, 1. / 6};

/// ½ (0, ω) r, for ω in the axes that r turns into.
Quaternion derivative(const Vector3& omega, const Quaternion& r) {
  const Vector3 half = 0.5 * omega;
  return Quaternion(0, half.x(), half.y(), half.z()) * r;
}

void derivatives(const Articulation& articulation, const double* q, const double* v, double* qdot) {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& link = articulation.link(i);
    for (int k = 0; k < link.slides; ++k) qdot[link.q + k] = v[link.v_slide + k];
    const int turned = link.q + link.slides;
    const double* const omega = v + link.v_turn;
    if (link.turns == 1) {
      qdot[turned] = omega[0];
    } else if (link.turns == 3) {
      storeQuaternion(derivative(Vector3(omega[0], omega[1], omega[2]), quaternionAt(q + turned)), qdot + turned);
    }
  }
}

void renormalise(const Articulation& articulation, double* q) {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& link = articulation.link(i);
    double* const r = q + link.q + link.slides;
    if (link.turns == 3) storeQuaternion(quaternionAt(r).normalized(), r);
  }
}

constexpr int kMomentumNumbers = 10;  // per link, used by roots: mass (0: not kept), centre, momentum

/// Notes the momentum of what floats freely at the start of the step.
void noteMomentum(const Articulation& articulation, const LinkWork* work, double* notes) {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    double* note = notes + kMomentumNumbers * i;
    note[0] = 0;
    if (articulation.root(i) != i || !floatsWithOthers(articulation, i)) continue;
    const FreeMomentum free = freeMomentum(articulation, work, i);
    note[0] = free.mass;
    Eigen::Map<Vector3>(note + 1) = free.p_WC;
    Eigen::Map<Vector6>(note + 4) = free.H_C.vector();
  }
}

/// Puts it right at the end.
void restoreMomentum(const Articulation& articulation, const double* notes, const Vector3& gravity, double h, double* q,
                     double* v, LinkWork* work) {
  bool placed = false;
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const double* note = notes + kMomentumNumbers * i;
    if (note[0] == 0) continue;
    if (!placed) forwardKinematics(articulation, q, v, work);
    placed = true;
    FreeMomentum before;
    before.mass = note[0];
    before.p_WC = Eigen::Map<const Vector3>(note + 1);
    before.H_C = {Vector3(note[4], note[5], note[6]), Vector3(note[7], note[8], note[9])};
    keepMomentum(articulation, work, before, i, gravity, h, q, v);
  }
}

}  // namespace

int rungeKuttaScratch(const Articulation& articulation) {
  return (kStages + 1) * (articulation.nq() + articulation.nv()) + articulation.nv() + kMomentumNumbers * articulation.linkCount();
}

bool stepRungeKutta(const Articulation& articulation, const Vector3& gravity, double h, double* q, double* v,
                    LinkWork* work, double* scratch, StageJoints* joints) noexcept {
  const int nq = articulation.nq(), nv = articulation.nv(), width = nq + nv;
  double* const slopes = scratch;  // one (q̇, v̇) per stage
  double* const stage = scratch + kStages * width;
  double* const tau = stage + width;
  double* const momenta = tau + nv;
  const bool keeps_momentum = !joints || !joints->haveRings();
  const auto start = [&] {
    for (int k = 0; k < nq; ++k) stage[k] = q[k];
    for (int k = 0; k < nv; ++k) stage[nq + k] = v[k];
  };
  const auto advance = [&](double weight, int slope) {
    for (int k = 0; weight != 0 && k < width; ++k) stage[k] += weight * slopes[slope * width + k];
  };
  const auto takeBack = [&] {
    forwardKinematics(articulation, q, v, work);
    return false;
  };
  for (int s = 0; s < kStages; ++s) {
    start();
    for (int j = 0; j < s; ++j) advance(h * kA[s][j], j);
    if (joints && !joints->at(stage, stage + nq, h * kB[s], tau)) return s > 0 && takeBack();
    double* const slope = slopes + s * width;
    derivatives(articulation, stage, stage + nq, slope);
    if (s > 0 || !joints) forwardKinematics(articulation, stage, stage + nq, work);
    if (s == 0 && keeps_momentum) noteMomentum(articulation, work, momenta);
    if (joints) {
      joints->accelerate(gravity, stage, stage + nq, tau, work, slope + nq);
    } else {
      accelerations(articulation, gravity, nullptr, nullptr, work, slope + nq);
    }
    if (s == 0 && joints && !joints->areResolved(work)) return false;
  }
  start();
  for (int s = 0; s < kStages; ++s) advance(h * kB[s], s);
  renormalise(articulation, stage);
  if (keeps_momentum) restoreMomentum(articulation, momenta, gravity, h, stage, stage + nq, work);
  if (joints && !joints->at(stage, stage + nq, 0, tau)) return takeBack();
  for (int k = 0; k < nq; ++k) q[k] = stage[k];
  for (int k = 0; k < nv; ++k) v[k] = stage[nq + k];
  return true;
}

double rungeKuttaError(const Articulation& articulation, double h, double size, const double* scratch) noexcept {
  const int width = articulation.nq() + articulation.nv();
  const auto error = [&](int k) {
    return h / 30 * (2 * scratch[k] - 9 * scratch[2 * width + k] + 8 * scratch[3 * width + k] - scratch[4 * width + k]);
  };
  double way2 = 0, turn2 = 0;
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& link = articulation.link(i);
    for (int k = 0; k < link.slides; ++k) way2 += error(link.q + k) * error(link.q + k);
    const int turned = link.q + link.slides, numbers = link.turns == 3 ? 4 : link.turns;
    const double per_number = link.turns == 3 ? 4 : 1;  // a quaternion changes by half of the angle
    for (int k = 0; k < numbers; ++k) turn2 += per_number * error(turned + k) * error(turned + k);
  }
  return std::sqrt(way2 + size * size * turn2);
}

}  // namespace haptic
