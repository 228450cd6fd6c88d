#include "haptic_core/dynamics/free_body.h"

#include <cmath>

#include "haptic_core/dynamics/quaternion_step.h"

namespace haptic {
namespace {

// Largest turn of one expansion [rad]: the term left out is below (0.3)⁶/6! of a turn there, 1e-6 rad; larger
// parts lose accuracy, smaller ones cost time only.
constexpr double kLargestTurn = 0.3;
// A body faster than this many parts per step is beyond simulation; it is stepped with coarser parts [1].
constexpr double kMostParts = 1000;

/// Rotation vector in body axes that the body turns by in h: Ω(h) of the header, by powers of t/h.
Vector3 turn(const LinkModel& link, const Vector3& l0, double h) {
  Vector3 l[5], w[5];
  l[0] = l0;
  w[0].noalias() = h * (link.I_O_inverse * l[0]);
  for (int k = 0; k < 4; ++k) {
    Vector3 sum = l[0].cross(w[k]);
    for (int j = 1; j <= k; ++j) sum += l[j].cross(w[k - j]);
    l[k + 1] = 1. / (k + 1) * sum;
    w[k + 1].noalias() = h * (link.I_O_inverse * l[k + 1]);
  }
  const Vector3& o1 = w[0];
  const Vector3 o2 = 1. / 2 * w[1];
  const Vector3 c2 = o1.cross(o2);  // coefficient of t² of Ω × w, and so on
  const Vector3 o3 = 1. / 3 * (w[2] + 1. / 2 * c2);
  const Vector3 c3 = o1.cross(w[2]) + o2.cross(w[1]) + o3.cross(w[0]);
  const Vector3 d3 = o1.cross(c2);  // of Ω × (Ω × w)
  const Vector3 o4 = 1. / 4 * (w[3] + 1. / 2 * c3 + 1. / 12 * d3);
  const Vector3 c4 = o1.cross(w[3]) + o2.cross(w[2]) + o3.cross(w[1]) + o4.cross(w[0]);
  const Vector3 d4 = o1.cross(c3) + o2.cross(c2);
  const Vector3 o5 = 1. / 5 * (w[4] + 1. / 2 * c4 + 1. / 12 * d4);
  return o1 + (o2 + (o3 + (o4 + o5)));
}

}  // namespace

void turnFreeBody(const LinkModel& link, double h, Matrix3& R_WL, double* q, double* v) noexcept {
  Quaternion r = quaternionAt(q + 3);
  Matrix3 R = R_WL;
  const Vector3 omega(v[0], v[1], v[2]);
  Vector3 l = link.I_O * (R.transpose() * omega);
  const Vector3 L = R * l;
  const double angle2 = omega.squaredNorm() * h * h;
  const double parts = angle2 <= kLargestTurn * kLargestTurn
                           ? 1
                           : std::min(kMostParts, std::ceil(std::sqrt(angle2) / kLargestTurn));
  const double dt = h / parts;
  for (double part = 1; part <= parts; ++part) {
    r = renormalised(r * quaternionStep(turn(link, l, dt)));
    R = r.toRotationMatrix();
    l.noalias() = R.transpose() * L;
  }
  Vector3 omega_end = R * (link.I_O_inverse * l);
  // ω is what is stored, and L is made of it again in the next step: that way alone loses 2.5e-16 of L a step, always
  // in the same sense. What the stored ω misses of L is put back.
  const Vector3 miss = L - R * (link.I_O * (R.transpose() * omega_end));
  omega_end += R * (link.I_O_inverse * (R.transpose() * miss));
  for (int k = 0; k < 3; ++k) v[k] = omega_end[k];
  storeQuaternion(r, q + 3);
  R_WL = R;
}

void stepFreeBody(const LinkModel& link, const Vector3& gravity, double h, double* q, double* v) noexcept {
  Matrix3 R_WL = quaternionAt(q + 3).toRotationMatrix();
  turnFreeBody(link, h, R_WL, q, v);
  for (int k = 0; k < 3; ++k) {
    q[k] += h * (v[3 + k] + 0.5 * h * gravity[k]);
    v[3 + k] += h * gravity[k];
  }
}

}  // namespace haptic
