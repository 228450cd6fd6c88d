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
// Square of the share of a turn that is rounding of its greatest number: (2⁻⁵³)². The term that is left out is half as large.
constexpr double kRounding2 = 0x1p-106;

/// Rotation vector in body axes that the body turns by in h: Ω(h) of the header, by powers of t/h. l and w first by their
/// derivatives, a_k = k! l_k and b_k = k! w_k: one sum and one product each, nothing in between. A body that turns about a principal axis,
/// and one that hardly turns, has nothing but b0: all other terms fall with b1.
/// `I_inverse`: h times the inverse of the inertia; `a0`: the angular momentum.
inline Lanes turn(const LaneMatrix& I_inverse, const Lanes& a0) {
  const Lanes b0 = I_inverse * a0;
  const Lanes a1 = cross(a0, b0), b1 = I_inverse * a1;
  if (dot(b1, b1) <= kRounding2 * dot(b0, b0)) return b0;
  const Lanes a2 = cross(a1, b0) + cross(a0, b1), b2 = I_inverse * a2;
  const Lanes a3 = (lanes(2) * cross(a1, b1) + cross(a2, b0)) + cross(a0, b2), b3 = I_inverse * a3;
  const Lanes a4 = (lanes(3) * (cross(a1, b2) + cross(a2, b1)) + cross(a3, b0)) + cross(a0, b3), b4 = I_inverse * a4;
  const Lanes w[5] = {b0, b1, lanes(1. / 2) * b2, lanes(1. / 6) * b3, lanes(1. / 24) * b4};
  const Lanes& o1 = w[0];
  const Lanes o2 = lanes(1. / 2) * w[1];
  const Lanes c2 = cross(o1, o2);  // coefficient of t² of Ω × w, and so on
  const Lanes o3 = lanes(1. / 3) * (w[2] + lanes(1. / 2) * c2);
  const Lanes c3 = (cross(o1, w[2]) + cross(o2, w[1])) + cross(o3, w[0]);
  const Lanes d3 = cross(o1, c2);  // of Ω × (Ω × w)
  const Lanes o4 = lanes(1. / 4) * (w[3] + (lanes(1. / 2) * c3 + lanes(1. / 12) * d3));
  const Lanes c4 = (cross(o1, w[3]) + cross(o2, w[2])) + (cross(o3, w[1]) + cross(o4, w[0]));
  const Lanes d4 = cross(o1, c3) + cross(o2, c2);
  const Lanes o5 = lanes(1. / 5) * (w[4] + (lanes(1. / 2) * c4 + lanes(1. / 12) * d4));
  return o1 + (o2 + (o3 + (o4 + o5)));
}

}  // namespace

void turnFreeBody(const LinkModel& link, double h, Matrix3& R_WL, double* q, double* v) noexcept {
  const LaneMatrix I(link.I_O), I_inverse(link.I_O_inverse);
  LaneQuaternion r{q[3], laneVector(q[4], q[5], q[6])};
  LaneRotation R = rotation(r);
  const Lanes omega = laneVector(v[0], v[1], v[2]);
  Lanes l = I * (R.back * omega);
  const Lanes L = R.there * l;
  const double angle2 = dot(omega, omega) * h * h;
  const double parts = angle2 <= kLargestTurn * kLargestTurn
                           ? 1
                           : std::min(kMostParts, std::ceil(std::sqrt(angle2) / kLargestTurn));
  const LaneMatrix over_part = lanes(h / parts) * I_inverse;
  for (double part = 1; part <= parts; ++part) {
    r = renormalised(r * quaternionStep(turn(over_part, l)));
    R = rotation(r);
    l = R.back * L;
  }
  Lanes omega_end = R.there * (I_inverse * l);
  // ω is stored, and the next step makes L of it again. The rounding of that way loses 2.5e-16 of L a step, always
  // in the same sense, so the difference is put back.
  const Lanes miss = L - R.there * (I * (R.back * omega_end));
  omega_end += R.there * (I_inverse * (R.back * miss));
  storeVector(omega_end, v);
  q[3] = r.w;
  storeVector(r.u, q + 4);
  for (int k = 0; k < 3; ++k) storeVector(R.there.column[k], R_WL.data() + 3 * k);
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
