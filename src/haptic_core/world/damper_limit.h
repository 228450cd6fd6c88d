/// How much of a contact's damper an explicit step can take, and which dampers are strong for it.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/base/spatial.h"

namespace haptic {

/// A damper at the velocity before is stable up to h λ(M⁻¹D) = 2 alone, and the springs need a part of it. A Hunt–Crossley damper k c d
/// grows with the load, so a light body pressed by a hand passes that bound however small its damping at rest. kDamperLimit is the dampers'
/// share; then springs are stable up to h² λ(M⁻¹K) = 0.6. A damper that strong stops its mode within two steps: the step does not resolve
/// more.
constexpr double kDamperLimit = 1.7;

/// Strength h b A/m of a damper from which velocity Verlet solves for the velocity at the end (stepping/settled_damper.h) [1]. Without,
/// rocking on the friction's lever multiplies it by up to four, and one is the limit.
constexpr double kStrongDamper = 0.15;

/// Largest eigenvalue of the block of a symmetric D at (i, i): whichever way P's axes lie in their plane.
inline double largestOfPlane(const Matrix6& D, int i) noexcept {
  const double half = 0.5 * (D(i, i) - D(i + 1, i + 1)), off = D(i, i + 1);
  return 0.5 * (D(i, i) + D(i + 1, i + 1)) + std::sqrt(half * half + off * off);
}

/// Whether the damper D of a patch of `area` [m²] is strong in a step h for bodies of this reduced mass, shared among `parts` contacts.
inline bool isStrong(const Matrix6& D, double area, int parts, double h, double reduced_mass) noexcept {
  const double stiffest = std::max({D(5, 5), largestOfPlane(D, 3), largestOfPlane(D, 0) / area});
  return !(parts * h * stiffest < kStrongDamper * reduced_mass);
}

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
