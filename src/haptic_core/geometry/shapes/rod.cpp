#include "haptic_core/geometry/shapes/rod.h"

#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {
namespace {

/// Sides of the polyhedron that is drawn: its surface is within 0.5 % of the radius.
constexpr int kSides = 32;

/// A capsule's corners and faces. Each end, the lower one first: rings of `kSides` corners every 90°/`kRings` from the tube on, then its
/// pole.
class CapsuleNet {
 public:
  CapsuleNet(double radius, double half) {
    for (const double end : {-1.0, 1.0}) {
      for (int ring = 0; ring < kRings; ++ring) {
        const elementary::SineCosine up = elementary::sinCos(ring * M_PI / 2 / kRings);
        for (int i = 0; i < kSides; ++i) {
          const auto [sine, cosine] = elementary::sinCos(2 * M_PI * i / kSides);
          corners.emplace_back(radius * up.cosine * cosine, radius * up.cosine * sine, end * (half + radius * up.sine));
        }
      }
      corners.emplace_back(0, 0, end * (half + radius));
    }
    for (int i = 0; i < kSides; ++i) {
      const int next = (i + 1) % kSides;
      faces.push_back({at(0, 0, i), at(0, 0, next), at(1, 0, next), at(1, 0, i)});
      for (int ring = 0; ring + 1 < kRings; ++ring) {
        faces.push_back({at(1, ring, i), at(1, ring, next), at(1, ring + 1, next), at(1, ring + 1, i)});
        faces.push_back({at(0, ring + 1, i), at(0, ring + 1, next), at(0, ring, next), at(0, ring, i)});
      }
      faces.push_back({at(1, kRings - 1, i), at(1, kRings - 1, next), at(1, kRings, 0)});
      faces.push_back({at(0, kRings - 1, next), at(0, kRings - 1, i), at(0, kRings, 0)});
    }
  }

  std::vector<Vector3> corners;
  std::vector<std::vector<int>> faces;  ///< counter-clockwise from outside

 private:
  static constexpr int kRings = kSides / 8;
  static int at(int end, int ring, int i) { return end * (kRings * kSides + 1) + ring * kSides + i; }
};

/// A polyhedron of the rod's volume.
ConvexPolyhedron hullOf(double radius, double half, bool capsule, const std::string& name) {
  if (!capsule) return makeCylinder(radius, 2 * half, kSides, RoundFit::kEqualVolume, name);
  CapsuleNet net(radius, half);
  const double volume = M_PI * radius * radius * (2 * half + 4.0 / 3 * radius);
  const double grow = elementary::cbrt(volume / ConvexPolyhedron(net.corners, net.faces, name).volume());
  for (Vector3& p : net.corners) p *= grow;
  return ConvexPolyhedron(net.corners, net.faces, name);
}

}  // namespace

Rod::Rod(double radius, double length, Ends ends, const std::string& name)
    : ConvexShape(ShapeKind::kRod, name), r_(radius), half_(0.5 * length), ends_(ends) {
  checkLength(radius, "radius", name);
  checkLength(length, "length", name);
  const double r2 = radius * radius, tube = M_PI * r2 * length, ball = isCapsule() ? 4 * M_PI / 3 * r2 * radius : 0;
  const double volume = tube + ball;
  if (!(tube > 0) || !std::isfinite(volume)) {
    throw SetupError(name, "the volume of radius " + std::to_string(radius) + " m is no number", "give coordinates in metres");
  }
  // A half ball's centre of mass is 3/8 R beyond the axis' end, about which it has 2/5 R² a diameter.
  const double about_axis = 0.5 * tube * r2 + 0.4 * ball * r2;
  const double across = tube * (r2 / 4 + length * length / 12) +
                        ball * (0.4 * r2 + half_ * half_ + 0.75 * radius * half_);
  spins_ = true;
  properties_ = {volume, volume, Vector3::Zero(), Vector3(across, across, about_axis).asDiagonal()};
  const double top = half_ + rounding();
  radius_ = isCapsule() ? top : elementary::hypot(radius, half_);
  aabb_ = {Vector3(-radius, -radius, -top), Vector3(radius, radius, top)};
  hull_ = std::make_shared<const ConvexPolyhedron>(hullOf(radius, half_, isCapsule(), name));
}

void Rod::eachNumber(NumberVisitor& visitor) const {
  visitor.visit(r_), visitor.visit(half_), visitor.visit(rounding());
}

double Rod::surface() const {
  return 2 * M_PI * r_ * (2 * half_ + (isCapsule() ? 2 * r_ : r_));
}

ConvexShape::Box Rod::aabb(const Pose& X_WS) const {
  const Vector3 axis = X_WS.R.col(2);
  Vector3 reach;
  for (int i = 0; i < 3; ++i) {
    reach[i] = half_ * std::abs(axis[i]) + r_ * (isCapsule() ? 1 : std::sqrt(std::max(0.0, 1 - axis[i] * axis[i])));
  }
  return {X_WS.p - reach, X_WS.p + reach};
}

OwnTurns Rod::ownTurns(const ContactPlace& place) const {
  const double beyond = std::abs(place.centroid.z()) - half_;
  if (!isCapsule() || !(beyond > 0)) return ConvexShape::ownTurns(place);
  // A ball's cap has the radius √6 σ. V lies within the round end where its centroid is that far beyond the tube; half as far the end
  // has no share yet.
  const double reach = std::sqrt(6 * std::max(0.0, place.variance(2, 2)));
  const double share = std::clamp(2 * beyond / reach - 1, 0.0, 1.0);
  return {Vector3(0, 0, std::copysign(half_, place.centroid.z())), Vector3(share, share, 1).asDiagonal()};
}

Vector3 Rod::core(const Vector3& direction) const {
  Vector3 point(0, 0, direction.z() >= 0 ? half_ : -half_);
  if (!isCapsule()) {
    const double across = direction.head<2>().norm();
    if (across > 0) point.head<2>() = r_ / across * direction.head<2>();
  }
  return point;
}

}  // namespace haptic
