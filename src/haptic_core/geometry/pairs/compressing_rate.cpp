#include "haptic_core/geometry/pairs/compressing_rate.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

/// Smaller tilts count as none: rounding makes some 1e-16 of an eigenvalue of S that is 0 [1].
constexpr double kLeastTilt = 1e-6;

/// Sums over own turns of both bodies.
struct OwnRates {
  Matrix2 slopes = Matrix2::Zero();   ///< S [1]
  Vector2 crossed = Vector2::Zero();  ///< Σ ρ_e s_e [m]

  /// `X_PS`: the shape in the patch's frame; `outward`: the patch's z is the normal out of the shape, else into it.
  void add(const ConvexShape& shape, const Pose& X_PS, bool outward, const Matrix3& variance_P) {
    if (!shape.spins()) return;
    const Matrix3 into_S = X_PS.R.transpose();
    const Vector3 n = into_S.col(2), p_SP = -(into_S * X_PS.p);
    const OwnTurns turns = shape.ownTurns({outward ? n : Vector3(-n), p_SP, into_S * variance_P * X_PS.R});
    const Vector3 approach = n.cross(p_SP - turns.about);  // at P, by a unit turn about each axis of the frame
    Eigen::Matrix<double, 3, 2> slope;                     // likewise
    slope << into_S.col(1), -into_S.col(0);
    slopes += slope.transpose() * turns.axes * slope;
    crossed += slope.transpose() * (turns.axes * approach);
  }
};

/// What becomes of slopes along an eigenvector of S.
struct Kept {
  double share;  ///< [1]
  double turns;  ///< (1 - share)/μ, also where μ is 0 [1]
};

/// `tilt2`: square of the mean thickness over the spread of V [1].
Kept keptOf(double mu, double tilt2) {
  const double bound = (1 - mu) * tilt2;
  if (!(mu < bound)) return {0, 1 / mu};
  const double m = mu / bound;
  return {(1 - m) * (1 - m), (2 - m) / bound};
}

}  // namespace

CompressingRate compressingRate(const ConvexShape& A, const ConvexShape& B, const Pose& X_AB, const ContactVolume& contact) noexcept {
  CompressingRate out;
  const double spread = contact.V2.trace();
  if (!(A.spins() || B.spins()) || contact.status != ContactVolume::Status::kOverlap || !(spread > 0)) return out;
  Matrix3 variance_P = Matrix3::Zero();
  variance_P.topLeftCorner<2, 2>() = contact.V2 / contact.volume;
  const Pose X_PA = contact.X_AP.inverse();
  OwnRates rates;
  rates.add(A, X_PA, true, variance_P);
  rates.add(B, X_PA * X_AB, false, variance_P);
  const Matrix2& S = rates.slopes;
  const double mean_thickness = contact.volume / contact.A0,
               tilt2 = std::max(kLeastTilt * kLeastTilt, mean_thickness * mean_thickness * contact.volume / spread);
  // A function F of S is (F(μ1) + F(μ2))/2 + (F(μ1) - F(μ2))/2 (S - mean)/half.
  const double mean = 0.5 * S.trace(), difference = 0.5 * (S(0, 0) - S(1, 1));
  const double half = std::sqrt(difference * difference + S(0, 1) * S(0, 1));
  const Kept more = keptOf(mean + half, tilt2), less = keptOf(std::max(0.0, mean - half), tilt2);
  Matrix2 direction = Matrix2::Zero();
  if (half > 0) direction = (S - mean * Matrix2::Identity()) / half;
  const auto of_S = [&](double at_more, double at_less) -> Matrix2 {
    return 0.5 * (at_more + at_less) * Matrix2::Identity() + 0.5 * (at_more - at_less) * direction;
  };
  out.all = false;
  out.slope = of_S(more.share, less.share);
  out.lever = -of_S(more.turns, less.turns) * rates.crossed;
  return out;
}

}  // namespace haptic
