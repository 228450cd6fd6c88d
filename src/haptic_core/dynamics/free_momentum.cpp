#include "haptic_core/dynamics/free_momentum.h"

namespace haptic {

FreeMomentum freeMomentum(const Articulation& articulation, const LinkWork* work, int root) noexcept {
  FreeMomentum free;
  const Vector3& p_W0 = work[root].p_WO;  // near by, so that a tree far from W's origin loses nothing
  Vector3 first = Vector3::Zero();
  for (int i = root; i < articulation.linkCount(); ++i) {
    if (articulation.root(i) != root) continue;
    const double m = articulation.link(i).mass;
    free.mass += m;
    first += m * (work[i].p_WC() - p_W0);
  }
  const Vector3 centre = first / free.mass;
  free.p_WC = p_W0 + centre;
  for (int i = root; i < articulation.linkCount(); ++i) {
    if (articulation.root(i) != root) continue;
    const LinkModel& link = articulation.link(i);
    const LinkWork& w = work[i];
    const Vector3 r = w.p_WC() - p_W0 - centre;
    const Vector3 P = link.mass * (w.velocity + w.omega.cross(w.p_OC));
    const Matrix3 I = w.X_WL.R * link.I_C * w.X_WL.R.transpose();
    free.H_C.force += P;
    free.H_C.torque += I * w.omega + r.cross(P);
    free.I_C += I + link.mass * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
  }
  return free;
}

bool floatsWithOthers(const Articulation& articulation, int root) noexcept {
  if (!articulation.link(root).floating) return false;
  for (int i = root + 1; i < articulation.linkCount(); ++i) {
    if (articulation.root(i) == root) return true;
  }
  return false;
}

void keepMomentum(const Articulation& articulation, const LinkWork* work, const FreeMomentum& before,
                  int root, const Vector3& gravity, double h, double* q, double* v) noexcept {
  const FreeMomentum now = freeMomentum(articulation, work, root);
  const LinkModel& link = articulation.link(root);
  const Vector3 P = before.H_C.force + h * before.mass * gravity;
  const Vector3 p_WC = before.p_WC + h / before.mass * before.H_C.force + 0.5 * h * h * gravity;
  const Vector3 turn = now.I_C.ldlt().solve(before.H_C.torque - now.H_C.torque);
  const Vector3 shift = (P - now.H_C.force) / now.mass + turn.cross(work[root].p_WO - now.p_WC);
  for (int k = 0; k < 3; ++k) {
    q[link.q + k] += p_WC[k] - now.p_WC[k];
    v[link.v + k] += turn[k];
    v[link.v + 3 + k] += shift[k];
  }
}

}  // namespace haptic
