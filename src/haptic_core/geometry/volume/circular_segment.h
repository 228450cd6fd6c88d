/// Integrals over the cap of a unit circle or sphere that is cut off at 1 - cos θ from its pole.
#pragma once
#include <cmath>

#include "haptic_core/base/elementary.h"

namespace haptic {

inline constexpr double kTurn = 2 * M_PI;  ///< all round [rad]

/// Integrals over a circular or spherical cap.
/// With the half chord ρ(s) = √(s (2 - s)) at the distance s from the pole, J_k = ∫ sᵏ ρ ds from 0 to s = 1 - cos θ, each
/// divided by s^(3/2): the quotient is smooth where the cap vanishes, and no digits cancel there.
struct SegmentIntegrals {
  double j0, j1, j2;  ///< J_0, J_1 and J_2, each over s^(3/2)

  /// `s` in [0, 2] and `theta` = acos(1 - s), which is read from kSeries on only.
  SegmentIntegrals(double s, double theta) {
    if (s < kSeries) {
      // ρ = √2 s^(1/2) √(1 - s/2); the coefficients c_j of √(1 - x), x = s/2 ≤ 1/16, end at 1e-17.
      constexpr double c[] = {1, -1.0 / 2, -1.0 / 8, -1.0 / 16, -5.0 / 128, -7.0 / 256, -21.0 / 1024, -33.0 / 2048,
                              -429.0 / 32768, -715.0 / 65536, -2431.0 / 262144, -4199.0 / 524288, -29393.0 / 4194304};
      const double x = 0.5 * s;
      j0 = j1 = j2 = 0;
      for (int j = s < kShort ? 6 : 12; j >= 0; --j) {
        j0 = j0 * x + c[j] / (j + 1.5);
        j1 = j1 * x + c[j] / (j + 2.5);
        j2 = j2 * x + c[j] / (j + 3.5);
      }
      j0 *= M_SQRT2;
      j1 *= M_SQRT2 * s;
      j2 *= M_SQRT2 * s * s;
      return;
    }
    const auto [sine, cosine] = elementary::sinCos(theta);
    const double scale = 1 / (s * std::sqrt(s));
    const double a = 0.5 * (theta - sine * cosine), b = sine * sine * sine / 3;
    j0 = a * scale;
    j1 = (a - b) * scale;
    j2 = (a - 2 * b + 0.125 * (theta - 0.25 * elementary::sin(4 * theta))) * scale;
  }

  static constexpr double kShort = 0.01;    ///< below it seven terms of the series are enough
  static constexpr double kSeries = 0.125;  ///< below it the series, above it the closed forms, which lose a digit there
};

}  // namespace haptic
