/// Elementary functions with the same bits on every processor.
///
/// The C library picks its sin, cos, atan2, exp, log and pow by processor when it is loaded: variants with
/// fused multiply-add round differently. A compiler computes `std::cos(0.3)` by itself, by other means again.
/// All arithmetic that can enter a hash therefore calls these functions, which use + - × / √ alone (correctly
/// rounded everywhere), and never those of <cmath>.
///
/// Method: that of fdlibm (K. C. Ng, Sun Microsystems, 1993): reduction of the argument to a small interval,
/// held in two doubles, and a minimax polynomial there. Large angles: M. Payne, R. Hanek, Radian reduction
/// for trigonometric functions, SIGNUM Newsletter 18, 1983. Deviations: coefficients of our own (Remez
/// exchange in 160 bits, rounded one by one), and the last sum is carried in two doubles in all of them.
///
/// Error: below 0.8 units in the last place, each function, over its whole range (subnormal results of exp:
/// below 1); compared with functions of 113 bits in elementary_test.cpp. Special values (±0, ±∞, NaN, outside
/// of the domain) as in C's annex F. No global state: errno and floating-point exceptions mean nothing. Cost:
/// 5 to 20 ns.
#pragma once

namespace haptic::elementary {

/// Sine and cosine of one angle.
struct SineCosine {
  double sine, cosine;  ///< sin x, cos x
};

SineCosine sinCos(double x) noexcept;       ///< (in realtime) of x [rad]; the cost of one and a half
double sin(double x) noexcept;              ///< (in realtime) of x [rad]
double cos(double x) noexcept;              ///< (in realtime) of x [rad]
double asin(double x) noexcept;             ///< (in realtime) in [-π/2, π/2] [rad]; NaN outside of [-1, 1]
double acos(double x) noexcept;             ///< (in realtime) in [0, π] [rad]; NaN outside of [-1, 1]
double atan2(double y, double x) noexcept;  ///< (in realtime) angle of the point (x, y), in [-π, π] [rad]
double exp(double x) noexcept;              ///< (in realtime) eˣ
double expm1(double x) noexcept;            ///< (in realtime) eˣ - 1, without cancellation about 0
double log(double x) noexcept;              ///< (in realtime) natural logarithm; -∞ at 0, NaN below
double asinh(double x) noexcept;            ///< (in realtime) ln(x + √(x² + 1))
double cbrt(double x) noexcept;             ///< (in realtime) ∛x
double hypot(double x, double y) noexcept;  ///< (in realtime) √(x² + y²) without overflow on the way

}  // namespace haptic::elementary
