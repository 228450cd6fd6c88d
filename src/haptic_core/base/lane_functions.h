/// Elementary functions of four numbers at once, on the intervals that quadrature needs: sums and products of lanes alone, so the same
/// bits in every build. Error: 4 units in the last place; elementary.h has them to one unit and over all numbers.
#pragma once
#include "haptic_core/base/lanes.h"

namespace haptic {

/// Sine and cosine of four numbers, of a circle or a hyperbola.
struct LaneSineCosine {
  Lanes sine, cosine;  ///< of the same number in each lane
};

/// c[0] + c[1] z + …, each coefficient four times, as sums take it from memory.
template <int kCount>
struct LanePolynomial {
  alignas(32) double c[kCount][4];  ///< by rising powers

  /// Of these coefficients.
  constexpr explicit LanePolynomial(const double (&of)[kCount]) : c() {
    for (int i = 0; i < kCount; ++i) c[i][0] = c[i][1] = c[i][2] = c[i][3] = of[i];
  }
  /// By Horner's scheme.
  Lanes operator()(const Lanes& z) const {
    Lanes p = loadLanes(c[kCount - 1]);
    for (int i = kCount - 2; i >= 0; --i) p = p * z + loadLanes(c[i]);
    return p;
  }
};

// Taylor's series of sin, cos and sinh, without the first term and the power of the second.
inline constexpr LanePolynomial<8> kSineSeries({-1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800, 1.0 / 6227020800.0,
                                                -1.0 / 1307674368000.0, 1.0 / 355687428096000.0});  ///< of sin x
inline constexpr LanePolynomial<8> kCosineSeries({-1.0 / 2, 1.0 / 24, -1.0 / 720, 1.0 / 40320, -1.0 / 3628800.0, 1.0 / 479001600.0,
                                                  -1.0 / 87178291200.0, 1.0 / 20922789888000.0});  ///< of cos x
inline constexpr LanePolynomial<6> kHyperbolicSeries({1.0 / 6, 1.0 / 120, 1.0 / 5040, 1.0 / 362880, 1.0 / 39916800,
                                                      1.0 / 6227020800.0});  ///< of sinh x

/// sin x and cos x for 0 ≤ x ≤ π/2 [rad]: of x/2 by Taylor's series, then doubled. The sine's error is relative, the cosine's absolute.
inline LaneSineCosine quarterSineCosine(const Lanes& x) {
  // The next terms are (π/4)¹⁸/19! of x and (π/4)¹⁸/18!: 1e-19 and 2e-18.
  const Lanes half = lanes(0.5) * x, z = half * half;
  const Lanes sine = half + half * z * kSineSeries(z), cosine = lanes(1) + z * kCosineSeries(z);
  return {lanes(2) * sine * cosine, (cosine - sine) * (cosine + sine)};
}

/// sinh x and cosh x for 0 ≤ x ≤ 4: sinh x/8 by Taylor's series, then doubled three times.
inline LaneSineCosine hyperbolicSineCosine(const Lanes& x) {
  // The next term is 0.5¹⁴/15!: 5e-17.
  const Lanes eighth = lanes(0.125) * x, z = eighth * eighth;
  Lanes sine = eighth + eighth * z * kHyperbolicSeries(z), cosine = squareRoot(lanes(1) + sine * sine);
  for (int i = 0; i < 3; ++i) {
    const Lanes twice = lanes(2) * sine;
    sine = twice * cosine, cosine = lanes(1) + lanes(0.5) * twice * twice;
  }
  return {sine, cosine};
}

}  // namespace haptic
