/// Gauss's rules on [-1, 1], half of their symmetric nodes and weights: exact for polynomials of degree 7, 15, 23 and 31.
#pragma once
#include <cmath>

#include "haptic_core/base/elementary.h"

namespace haptic {

/// Two nodes of a Gauss rule, at ±`at`, with the same weight.
struct GaussPoint {
  double at, weight;  ///< in [0, 1]; the weights of a rule add up to 1, half of its interval
};

/// Four nodes: exact up to degree 7.
inline constexpr GaussPoint kGauss4[] = {{0.8611363115940526, 0.34785484513745385}, {0.33998104358485626, 0.6521451548625461}};
/// Eight nodes: exact up to degree 15.
inline constexpr GaussPoint kGauss8[] = {{0.9602898564975363, 0.10122853629037626},
                                         {0.7966664774136267, 0.22238103445337448},
                                         {0.525532409916329, 0.31370664587788727},
                                         {0.1834346424956498, 0.362683783378362}};
/// Twelve nodes: exact up to degree 23.
inline constexpr GaussPoint kGauss12[] = {{0.9815606342467192, 0.04717533638651183}, {0.9041172563704749, 0.10693932599531843},
                                          {0.7699026741943047, 0.16007832854334622}, {0.5873179542866175, 0.20316742672306592},
                                          {0.3678314989981802, 0.2334925365383548},  {0.1252334085114689, 0.24914704581340277}};
/// Sixteen nodes: exact up to degree 31.
inline constexpr GaussPoint kGauss16[] = {
    {0.9894009349916499, 0.027152459411754096}, {0.9445750230732326, 0.062253523938647894},
    {0.8656312023878318, 0.09515851168249279},  {0.755404408355003, 0.12462897125553388},
    {0.6178762444026438, 0.14959598881657674},  {0.45801677765722737, 0.16915651939500254},
    {0.2816035507792589, 0.18260341504492358},  {0.09501250983763744, 0.1894506104550685}};

/// Longest arcs for the rules of 16, 12 and 8 points [rad]: trigonometric polynomials of degree 5 to 1e-16. Of half a turn 16 points leave
/// 4e-17 of them.
inline constexpr double kLongArc = 2.1, kMiddlingArc = 1.5, kShortArc = 0.5;

/// ∫ from a to b: visits (place, weight).
template <int kHalf, class Visit>
inline void integrate(const GaussPoint (&rule)[kHalf], double a, double b, Visit&& visit) {
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  for (const GaussPoint& g : rule) {
    visit(middle - half * g.at, half * g.weight);
    visit(middle + half * g.at, half * g.weight);
  }
}

/// ∫ over the arc from angle `from` over `sweep`: visits (cosine, sine, weight). Two points share one sine and cosine.
template <int kHalf, class Visit>
inline void integrateArc(const GaussPoint (&rule)[kHalf], double from, double sweep, Visit&& visit) {
  const double half = 0.5 * sweep;
  const auto [s, c] = elementary::sinCos(from + half);
  for (const GaussPoint& g : rule) {
    const auto [sine, cosine] = elementary::sinCos(half * g.at);
    const double weight = half * g.weight;
    visit(c * cosine + s * sine, s * cosine - c * sine, weight);
    visit(c * cosine - s * sine, s * cosine + c * sine, weight);
  }
}

}  // namespace haptic
