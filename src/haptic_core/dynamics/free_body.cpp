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

/// Rotation vector in body axes that the body turns by in h: Ω(h) of the header, by powers of t/h. l and w first by their
/// derivatives, a_k = k! l_k and b_k = k! w_k: one sum and one product each, nothing in between.
Vector3 turn(const LinkModel& link, const Vector3& a0, double h) {
  const Matrix3 I = h * link.I_O_inverse;
  const Vector3 b0 = I * a0;
  const Vector3 a1 = a0.cross(b0), b1 = I * a1;
  const Vector3 a2 = a1.cross(b0) + a0.cross(b1), b2 = I * a2;
  const Vector3 a3 = (2 * a1.cross(b1) + a2.cross(b0)) + a0.cross(b2), b3 = I * a3;
  const Vector3 a4 = (3 * (a1.cross(b2) + a2.cross(b1)) + a3.cross(b0)) + a0.cross(b3), b4 = I * a4;
  const Vector3 w[5] = {b0, b1, 1. / 2 * b2, 1. / 6 * b3, 1. / 24 * b4};
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
