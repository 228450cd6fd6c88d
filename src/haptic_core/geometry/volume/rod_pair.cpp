#include "haptic_core/geometry/volume/rod_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

/// Sine of the angle between the axes, and distance over the radii, that rounding of the pose may make of
/// none.
constexpr double kNone = 8 * std::numeric_limits<double>::epsilon();
/// In place of a sine or cosine of 0, so that its reciprocal times any length is beyond every end.
constexpr double kLeast = 1e-200;

/// How far a rod reaches along a direction at an angle to its axis.
double reachOf(const RodPair& pair, int rod, double cosine, double sine) {
  return pair.half[rod] * cosine + pair.radius[rod] * (pair.round[rod] ? 1 : sine);
}

}  // namespace

bool RodPair::place(const Rod& A, const Rod& B, const Pose& X_AB) noexcept {
  const Rod* const rods[2] = {&A, &B};
  for (int i = 0; i < 2; ++i)
    radius[i] = rods[i]->radius(), half[i] = rods[i]->halfLength(), round[i] = rods[i]->isCapsule();
  Vector3 axis = X_AB.R.col(2);
  if (axis.z() < 0) axis = -axis;  // a rod looks the same from both of its ends
  sine = axis.head<2>().norm(), cosine = axis.z();
  Vector2 n = Vector2(-axis.y(), axis.x()) / sine;
  if (!(sine > kNone)) {
    sine = 0, cosine = 1;
    const double between = X_AB.p.head<2>().norm();
    n = between > kNone * (radius[0] + radius[1]) ? Vector2(X_AB.p.head<2>() / between)
                                                  : Vector2(Vector2::UnitX());
  }
  R_AE.col(0) = Vector3::UnitZ();
  R_AE.col(1) << n.y(), -n.x(), 0;
  R_AE.col(2) << n.x(), n.y(), 0;
  inverse_sine = 1 / std::max(sine, kLeast), inverse_cosine = 1 / std::max(cosine, kLeast);
  centre << X_AB.p.z(), R_AE.col(1).dot(X_AB.p);
  distance = R_AE.col(2).dot(X_AB.p);
  const double rA = radius[0], rB = radius[1];
  const bool top_A = rA <= distance + rB, bottom_A = -rA >= distance - rB;
  above[0] = top_A ? 0 : rA - distance - rB, above[1] = top_A ? distance + rB - rA : 0;
  below[0] = bottom_A ? 0 : rA - rB + distance, below[1] = bottom_A ? rB - rA - distance : 0;
  low = bottom_A ? -rA : distance - rB;
  width = top_A ? (bottom_A ? 2 * rA : rA + rB - distance) : (bottom_A ? rA + rB + distance : 2 * rB);
  return width > 0;
}

RodPair::Directions RodPair::directions() const noexcept {
  const auto towards = [](const Vector3& n, double sum, double along) {
    return Direction{std::copysign(1, along) * n, sum - std::abs(along)};
  };
  return {towards(Vector3::UnitZ(), radius[0] + radius[1], distance),
          towards(Vector3::UnitY(), radius[0] + reachOf(*this, 1, sine, cosine), centre.y()),
          towards(Vector3::UnitX(), reachOf(*this, 0, 1, 0) + reachOf(*this, 1, cosine, sine), centre.x()),
          towards(Vector3(cosine, sine, 0), reachOf(*this, 0, cosine, sine) + reachOf(*this, 1, 1, 0),
                  cosine * centre.x() + sine * centre.y())};
}

double RodPair::overlapAlong(const Vector3& n) const noexcept {
  const double along = cosine * n.x() + sine * n.y(), across = cosine * n.y() - sine * n.x(), z2 = n.z() * n.z();
  const double A = reachOf(*this, 0, std::abs(n.x()), std::sqrt(n.y() * n.y() + z2));
  const double B = reachOf(*this, 1, std::abs(along), std::sqrt(across * across + z2));
  return A + B - (n.x() * centre.x() + n.y() * centre.y() + n.z() * distance);
}

double RodPair::axisDistance() const noexcept {
  const double along_B = -centre.y() * inverse_sine, along_A = centre.x() + along_B * cosine;
  if (std::abs(along_B) <= half[1] && std::abs(along_A) <= half[0]) return 0;
  double least = std::numeric_limits<double>::infinity();
  const auto beyond = [&](double along, double across, double length) {
    const double out = std::max(0.0, std::abs(along) - length);
    least = std::min(least, std::sqrt(out * out + across * across));
  };
  for (const double end : {-1.0, 1.0}) {
    beyond(centre.x() + end * half[1] * cosine, centre.y() + end * half[1] * sine, half[0]);
    const Vector2 p = Vector2(end * half[0], 0) - centre;
    beyond(p.x() * cosine + p.y() * sine, p.y() * cosine - p.x() * sine, half[1]);
  }
  return least;
}

}  // namespace haptic
