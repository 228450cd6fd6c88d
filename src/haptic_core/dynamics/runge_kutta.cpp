#include "haptic_core/dynamics/runge_kutta.h"

#include "haptic_core/dynamics/free_body.h"
#include "haptic_core/dynamics/free_momentum.h"

namespace haptic {
namespace {

constexpr int kMostStages = 6;

/// Stage s starts from q + h Σ a[s][j] k_j; the step is q + h Σ b[s] k_s.
struct Tableau {
  int stages;
  double a[kMostStages][kMostStages - 1];
  double b[kMostStages];
};

constexpr Tableau kMerson = {
    5,
    {{}, {1. / 3}, {1. / 6, 1. / 6}, {1. / 8, 0, 3. / 8}, {1. / 2, 0, -3. / 2, 2}, {}},
    {1. / 6, 0, 0, 2. / 3, 1. / 6, 0}};
constexpr Tableau kDormandPrince = {6,
                                    {{},
                                     {1. / 5},
                                     {3. / 40, 9. / 40},
                                     {44. / 45, -56. / 15, 32. / 9},
                                     {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
                                     {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656}},
                                    {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84}};

Quaternion load(const double* p) {
  return Quaternion(p[0], p[1], p[2], p[3]);
}

void store(const Quaternion& r, double* p) {
  p[0] = r.w();
  p[1] = r.x();
  p[2] = r.y();
  p[3] = r.z();
}

/// ½ (0, ω) r, for ω in the axes that r turns into.
Quaternion derivative(const Vector3& omega, const Quaternion& r) {
  const Vector3 half = 0.5 * omega;
  return Quaternion(0, half.x(), half.y(), half.z()) * r;
}

void derivatives(const Articulation& articulation, const double* q, const double* v, double* qdot) {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& link = articulation.link(i);
    const double* vi = v + link.v;
    double* di = qdot + link.q;
    switch (link.type) {
      case JointType::kFixed:
        break;
      case JointType::kRevolute:
      case JointType::kPrismatic:
        di[0] = vi[0];
        break;
      case JointType::kPlanar:
        for (int k = 0; k < 3; ++k) di[k] = vi[k];
        break;
      case JointType::kSpherical:
        store(derivative(Vector3(vi[0], vi[1], vi[2]), load(q + link.q)), di);
        break;
      case JointType::kFloating:
        for (int k = 0; k < 3; ++k) di[k] = vi[3 + k];
        store(derivative(Vector3(vi[0], vi[1], vi[2]), load(q + link.q + 3)), di + 3);
        break;
    }
  }
}

void renormalise(const Articulation& articulation, double* q) {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    const LinkModel& link = articulation.link(i);
    double* r = q + link.q + (link.type == JointType::kFloating ? 3 : 0);
    if (link.type == JointType::kSpherical || link.type == JointType::kFloating)
      store(load(r).normalized(), r);
  }
}

constexpr int kMomentumNumbers = 10;  // per link, used by roots: mass (0: not kept), centre, momentum

/// Notes the momentum of what floats freely at the start of the step.
void noteMomentum(const Articulation& articulation, const LinkWork* work, const double* tau, double* notes) {
  for (int i = 0; i < articulation.linkCount(); ++i) {
    double* note = notes + kMomentumNumbers * i;
    note[0] = 0;
    if (articulation.root(i) != i || !movesFreely(articulation, work, tau, i)) continue;
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
  return (kMostStages + 1) * (articulation.nq() + articulation.nv()) + (6 + kMomentumNumbers) * articulation.linkCount();
}

void stepRungeKutta(const Articulation& articulation, const Vector3& gravity, const double* tau, double h,
                    double* q, double* v, LinkWork* work, double* scratch, TreeFormula formula) noexcept {
  if (articulation.isFreeBody() && !tau) {
    stepFreeBody(articulation.link(0), work[0].F_ext, gravity, h, q, v);
    return;
  }
  const int nq = articulation.nq(), nv = articulation.nv(), width = nq + nv, links = articulation.linkCount();
  double* const slopes = scratch;  // one (q̇, v̇) per stage
  double* const stage = scratch + kMostStages * width;
  double* const wrenches = stage + width;
  double* const momenta = wrenches + 6 * links;
  for (int i = 0; i < links; ++i) Eigen::Map<Vector6>(wrenches + 6 * i) = work[i].F_ext.vector();
  const Tableau& tableau = formula == TreeFormula::kMerson ? kMerson : kDormandPrince;
  for (int s = 0; s < tableau.stages; ++s) {
    for (int k = 0; k < nq; ++k) stage[k] = q[k];
    for (int k = 0; k < nv; ++k) stage[nq + k] = v[k];
    for (int j = 0; j < s; ++j) {
      const double weight = h * tableau.a[s][j];
      if (weight != 0)
        for (int k = 0; k < width; ++k) stage[k] += weight * slopes[j * width + k];
    }
    double* const slope = slopes + s * width;
    derivatives(articulation, stage, stage + nq, slope);
    forwardKinematics(articulation, stage, stage + nq, work);
    for (int i = 0; i < links; ++i) {
      work[i].F_ext.torque = Eigen::Map<Vector3>(wrenches + 6 * i);
      work[i].F_ext.force = Eigen::Map<Vector3>(wrenches + 6 * i + 3);
    }
    if (s == 0) noteMomentum(articulation, work, tau, momenta);
    accelerations(articulation, gravity, tau, nullptr, work, slope + nq);
  }
  for (int s = 0; s < tableau.stages; ++s) {
    for (int k = 0; k < nq; ++k) q[k] += h * tableau.b[s] * slopes[s * width + k];
    for (int k = 0; k < nv; ++k) v[k] += h * tableau.b[s] * slopes[s * width + nq + k];
  }
  renormalise(articulation, q);
  restoreMomentum(articulation, momenta, gravity, h, q, v, work);
}

}  // namespace haptic
