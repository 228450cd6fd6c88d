#include "haptic_core/geometry/volume/solid_moments.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/volume/circular_segment.h"
#include "haptic_core/geometry/volume/gauss_legendre.h"

namespace haptic {
namespace {

/// Points on a whole circle that is not round about u at least and at most: so many integrate the polynomials, and so many the worst.
constexpr int kLeastPoints = 8, kMostPoints = 64;
/// -2 ln of an integral's relative error.
constexpr double kCircleDigits = 74;
/// How many points a whole circle needs. The integrand is periodic, and singular at -u: with α of the circle and γ from its middle
/// to -u the error falls like qᴺ, q = tan(α/2)/tan(γ/2) or its inverse.
int circlePoints(double height, double cosine) {
  const double q2 = (1 - height) * (1 - cosine) / ((1 + height) * (1 + cosine));
  return static_cast<int>(std::min<double>(kMostPoints, kLeastPoints + kCircleDigits / std::abs(elementary::log(q2))));
}

/// A face's normal this close to ±u is u's rounding.
constexpr double kSame = 1e-15;

/// Sums over the sphere of radius 1, cones from o = κ u. With s' from the pole, ρ' = √(s'(2 - s')) and ê
/// across u, a point of the sphere is y = z u + ρ' ê from o, z = b - s', b = 1 - κ, and y·N = b + κ s'. A
/// boundary element turns by dφ = w/ρ² dψ.
class SphereSums {
 public:
  SphereSums(const Vector3& u, double radius, double distance)
      : u_(u), kappa_(distance / radius), b_((radius - distance) / radius) {}

  /// A boundary point n (unit) that moves by `step`, which is weighted.
  void add(const Vector3& n, const Vector3& step) {
    const double cosine = n.dot(u_);
    const Vector3 across = n - cosine * u_;
    const double rho2 = across.squaredNorm();
    const double s = cosine > -0.5 ? rho2 / (1 + cosine) : 1 - cosine,
                 left = cosine > -0.5 ? 1 + cosine : rho2 / s;
    const double turn = u_.dot(across.cross(step)) / left, root = turn / std::sqrt(left);
    const SegmentIntegrals j(s, s < SegmentIntegrals::kSeries ? 0 : elementary::atan2(std::sqrt(rho2), cosine));
    const double b = b_, k = kappa_;
    volume_ += turn * (b + 0.5 * k * s);
    along_ += turn * (b * b - s * (0.5 * b * b + k * s / 3));
    along2_ += turn * (b * b * b + s * (0.5 * (k - 2) * b * b + s * (b * (1 - 2 * k) / 3 + 0.25 * k * s)));
    across_ += root * (b * j.j0 + k * j.j1) * across;
    mixed_ += root * (b * b * (j.j0 - j.j1) - k * j.j2) * across;
    across2_ += turn / left * (b + s * ((2 * k - b) / 3 - 0.25 * k * s)) * across * across.transpose();
  }

  /// An arc of a circle about u at the distance `s` from the pole, turning by `sweep` as `sense` says; `first`, `second`: ∫ of a
  /// point's part across u, and of its square, over the angle.
  void addParallel(double s, double sense, double sweep, const Vector3& first, const Matrix3& second) {
    const double turn = sense * s, b = b_, k = kappa_;
    const SegmentIntegrals j(s, s < SegmentIntegrals::kSeries ? 0 : elementary::acos(1 - s));
    const double root = turn / std::sqrt(2 - s);
    volume_ += turn * sweep * (b + 0.5 * k * s);
    along_ += turn * sweep * (b * b - s * (0.5 * b * b + k * s / 3));
    along2_ += turn * sweep * (b * b * b + s * (0.5 * (k - 2) * b * b + s * (b * (1 - 2 * k) / 3 + 0.25 * k * s)));
    across_ += root * (b * j.j0 + k * j.j1) * first;
    mixed_ += root * (b * b * (j.j0 - j.j1) - k * j.j2) * first;
    across2_ += turn / (2 - s) * (b + s * ((2 * k - b) / 3 - 0.25 * k * s)) * second;
  }

  /// The faces' boundaries run against the sphere's: hence the sign.
  void addTo(double radius, SolidMoments& sums) const {
    const double r3 = radius * radius * radius;
    sums.volume -= r3 / 3 * volume_;
    sums.first -= r3 * radius / 4 * (along_ * u_ + across_);
    const Matrix3 mixed = u_ * mixed_.transpose();
    sums.second -=
        r3 * radius * radius / 5 * (along2_ * u_ * u_.transpose() + mixed + mixed.transpose() + across2_);
  }

 private:
  Vector3 u_;
  double kappa_, b_;
  double volume_ = 0, along_ = 0, along2_ = 0;
  Vector3 across_ = Vector3::Zero(), mixed_ = Vector3::Zero();
  Matrix3 across2_ = Matrix3::Zero();
};

}  // namespace

void addSphericalPart(const BallCut& cut, const Vector3& u, double distance, SolidMoments& out) noexcept {
  const double radius = cut.radius();
  SphereSums sums(u, radius, distance);
  for (const CutFace& face : cut.faces()) {
    const double h = face.height / radius, a = face.radius / radius;
    const auto at = [&](double cosine, double sine, double weight) {
      const double c = a * cosine, s = a * sine;
      sums.add(h * face.normal + c * face.x + s * face.y, weight * (c * face.y - s * face.x));
    };
    if (face.height == 0 && std::abs(face.normal.dot(u)) < kSame) continue;  // along a meridian nothing turns about u
    const double side = face.normal.dot(u) > 0 ? 1 : -1, polar = (radius - side * face.height) / radius;
    const bool about_pole = (face.normal - side * u).norm() < kSame;
    if (face.whole && about_pole) {
      const Matrix3 round = M_PI * a * a * (Matrix3::Identity() - u * u.transpose());
      sums.addParallel(polar, side, kTurn, Vector3::Zero(), round);
      continue;
    }
    if (face.whole) {
      const int points = circlePoints(h, face.normal.dot(u));
      for (int i = 0; i < points; ++i) {
        const auto [sine, cosine] = elementary::sinCos(i * kTurn / points);
        at(cosine, sine, kTurn / points);
      }
      continue;
    }
    for (int i = face.first; i < face.first + face.count; ++i) {
      const CutCurve& arc = cut.curves()[i];
      if (!arc.arc || !(arc.sweep > 0)) continue;
      // An arc's end is a point of an edge, which rounding has put off this circle and not off the next arc's: by 1e-11 of the
      // radius where a circle just meets the edge. The boundary has to be closed.
      const auto bridge = [&](const Vector2& end, double sense) {
        const double distance = end.norm();
        if (!(std::abs(distance - face.radius) > kSame * radius)) return;
        const Vector2 step = sense * (1 - face.radius / distance) / radius * end;
        sums.add(face.at(end) / radius, step.x() * face.x + step.y() * face.y);
      };
      bridge(arc.p, -1);
      bridge(arc.q, 1);
      if (about_pole) {
        const auto [s0, c0] = elementary::sinCos(arc.from);
        const auto [s1, c1] = elementary::sinCos(arc.from + arc.sweep);
        const double cross = 0.5 * (s1 * s1 - s0 * s0), swing = s1 * c1 - s0 * c0;
        const Vector3 first = a * ((s1 - s0) * face.x + (c0 - c1) * face.y);
        const Matrix3 second = a * a * (0.5 * (arc.sweep + swing) * face.x * face.x.transpose() +
                                        0.5 * (arc.sweep - swing) * face.y * face.y.transpose() +
                                        cross * (face.x * face.y.transpose() + face.y * face.x.transpose()));
        sums.addParallel(polar, side, arc.sweep, first, second);
        continue;
      }
      const auto [sine, cosine] = elementary::sinCos(arc.from + 0.5 * arc.sweep);
      const Vector3 n = h * face.normal + a * cosine * face.x + a * sine * face.y;
      if (arc.sweep < kShortArc && n.dot(u) > 0) {
        integrateArc(kGauss8, arc.from, arc.sweep, at);
        continue;
      }
      const int parts = static_cast<int>(arc.sweep / kLongArc) + 1;
      for (int p = 0; p < parts; ++p)
        integrateArc(kGauss16, arc.from + p * arc.sweep / parts, arc.sweep / parts, at);
    }
  }
  sums.addTo(radius, out);
}

}  // namespace haptic
