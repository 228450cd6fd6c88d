#include "haptic_core/geometry/shapes/cone.h"

#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/shapes.h"

namespace haptic {
namespace {

constexpr int kConeSides = 64;

/// Regular polygons of the discs' areas, or a point, and planes between them.
ConvexPolyhedron polygonalCone(double radius, double top, double half, const std::string& name) {
  const double angle = 2 * M_PI / kConeSides, grow = std::sqrt(angle / elementary::sin(angle));
  std::vector<Vector3> corners;
  std::vector<std::vector<int>> faces(1);
  const int tops = top > 0 ? kConeSides : 1;
  for (int i = 0; i < kConeSides; ++i) {
    const auto [sine, cosine] = elementary::sinCos(i * angle);
    corners.emplace_back(grow * radius * cosine, grow * radius * sine, -half);
    faces[0].push_back(kConeSides - 1 - i);
  }
  for (int i = 0; i < tops; ++i) {
    const auto [sine, cosine] = elementary::sinCos(i * angle);
    corners.emplace_back(grow * top * cosine, grow * top * sine, half);
  }
  if (tops > 1) faces.emplace_back();
  for (int i = 0; i < kConeSides; ++i) {
    const int next = (i + 1) % kConeSides;
    if (tops == 1) {
      faces.push_back({i, next, kConeSides});
    } else {
      faces[1].push_back(kConeSides + i);
      faces.push_back({i, next, kConeSides + next, kConeSides + i});
    }
  }
  return ConvexPolyhedron(std::move(corners), faces, name);
}

/// At density 1. With ρ the radius at the height t·length over the bottom, r² = ∫ρ² dt and so on are polynomials of the two radii.
MassProperties coneProperties(double R, double r, double length) {
  const double r2 = (R * R + R * r + r * r) / 3, r4 = (R * R * R * R + R * R * R * r + R * R * r * r + R * r * r * r + r * r * r * r) / 5;
  const double volume = M_PI * length * r2, about_axis = 0.5 * M_PI * length * r4;
  const double height = length * (R * R + 2 * R * r + 3 * r * r) / 12 / r2;
  const double heights = M_PI * length * length * length * (R * R / 30 + R * r / 10 + r * r / 5);
  const double across = 0.5 * about_axis + heights - volume * height * height;
  return {volume, volume, Vector3(0, 0, height - 0.5 * length), Matrix3(Vector3(across, across, about_axis).asDiagonal())};
}

}  // namespace

Cone::Cone(double radius, double top_radius, double length, const std::string& name)
    : SupportShape(name), r_(radius), top_(top_radius), half_(0.5 * length) {
  checkLength(radius, "radius", name);
  checkLength(length, "length", name);
  if (top_radius != 0) checkLength(top_radius, "top radius", name);
  spins_ = true;
  tessellate(polygonalCone(radius, top_radius, half_, name), coneProperties(radius, top_radius, length));
}

std::vector<Vector3> Cone::sides() const {
  std::vector<Vector3> sides{-Vector3::UnitZ(), Vector3(2 * half_, 0, r_ - top_).normalized()};
  if (top_ > 0) sides.push_back(Vector3::UnitZ());
  return sides;
}

void Cone::eachNumber(NumberVisitor& visitor) const {
  visitor.visit(static_cast<int>(kind()));
  visitor.visit(r_), visitor.visit(top_), visitor.visit(half_);
}

Vector3 Cone::core(const Vector3& direction) const {
  const double across = direction.head<2>().norm();
  const bool top = (top_ - r_) * across + 2 * half_ * direction.z() > 0;
  Vector3 point(0, 0, top ? half_ : -half_);
  if (across > 0) point.head<2>() = (top ? top_ : r_) / across * direction.head<2>();
  return point;
}

}  // namespace haptic
