/// Which dampers velocity Verlet cannot take at the velocity before.
#pragma once
#include <algorithm>
#include <cmath>

#include "haptic_core/base/spatial.h"

namespace haptic {

/// Strength h b A/m of a damper from which it solves for the velocity at the end (test/comparators/settled_damper.h) [1]. Without,
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

}  // namespace haptic
