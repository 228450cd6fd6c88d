/// How much of a contact's damper an explicit step can take.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/base/spatial.h"

namespace haptic {

/// Symplectic Euler evaluates dampers at the old velocity: alone they are stable up to h λ(M⁻¹D) = 2, and the
/// springs need a part of it. A Hunt–Crossley damper k c d grows with the load, so a light body pressed by a
/// hand passes that bound however small its damping at rest. kDamperLimit is the dampers' share;
/// then springs are stable up to h² λ(M⁻¹K) = 0.6. A damper that strong stops its mode within two steps: the
/// step does not resolve more.
constexpr double kDamperLimit = 1.7;

/// Largest eigenvalue of W D from above, by at most 12 %: the sixteenth root of the trace of its sixteenth
/// power. Infinite where W or D are not finite: no damper then.
inline double dampingRate(const Matrix6& W, const Matrix6& D) noexcept {
  Matrix6 P = W * D;
  const double scale = P.diagonal().cwiseAbs().maxCoeff();  // trace ≤ 6 scale: no overflow below
  if (!std::isfinite(scale)) return std::numeric_limits<double>::infinity();  // an unknown one is not stable
  if (!(scale > 0)) return 0;
  P /= scale;
  for (int i = 0; i < 3; ++i) P = (P * P).eval();
  double root = std::max(0.0, P.cwiseProduct(P.transpose()).sum());
  for (int i = 0; i < 4; ++i) root = std::sqrt(root);
  return scale * root;
}

/// Factor on the damper D [N·m·s/rad … N·s/m] in a step h, with W the mobility of the contact, each body's
/// mass shared among its contacts: then all of them together stay within the limit.
inline double damperShare(const Matrix6& W, const Matrix6& D, double h) noexcept {
  const double rate = h * dampingRate(W, D);
  return rate > kDamperLimit ? kDamperLimit / rate : 1.0;
}

}  // namespace haptic
