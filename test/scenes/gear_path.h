/// Where a hand leads a ball over the gear of urdf/scenes/gear.urdf: along its teeth, or along a circle through them.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"
#include "haptic_core/world/world.h"

namespace haptic::scenes {

constexpr double kGearBall = 0.002;      ///< radius of the ball [m]
constexpr double kDrawnRadius = 0.052;   ///< of the circle [m]

/// k [N/m³] at which the ball, pressed with `press` [N], sinks by d = press/stiffness: k·V = press with the cap's volume
/// V = π d² (R - d/3).
inline double gearFoundation(double stiffness, double press) {
  const double d = press / stiffness;
  return press / (M_PI * d * d * (kGearBall - d / 3));
}

/// Distance of a point from a convex polygon given by its corners in order; negative inside.
inline double distanceTo(const std::vector<Vector2>& polygon, const Vector2& p) {
  double outside = INFINITY, inside = -INFINITY;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2 a = polygon[i], b = polygon[(i + 1) % polygon.size()], along = b - a;
    const double s = std::min(1.0, std::max(0.0, (p - a).dot(along) / along.squaredNorm()));
    outside = std::min(outside, (p - a - s * along).norm());
    inside = std::max(inside, Vector2(along.y(), -along.x()).normalized().dot(p - a));  // counter-clockwise: outward
  }
  return inside <= 0 ? inside : outside;
}

/// Cross-sections of the gear's pieces (prisms along z) in the world.
inline std::vector<std::vector<Vector2>> sections(const WorldDef& world) {
  std::vector<std::vector<Vector2>> all;
  for (const CollisionDef& collision : world.articulations[0].links[0].collisions) {
    std::vector<Vector2> points;
    for (const Vector3& v : collision.shape->polyhedron()->vertices()) {
      const Vector3 p = world.articulations[0].X_WA * (collision.X_LS * v);
      if (p.z() > 0) points.push_back(p.head<2>());
    }
    Vector2 middle = Vector2::Zero();
    for (const Vector2& p : points) middle += p / static_cast<double>(points.size());
    std::sort(points.begin(), points.end(), [&](const Vector2& a, const Vector2& b) {
      return elementary::atan2(a.y() - middle.y(), a.x() - middle.x()) < elementary::atan2(b.y() - middle.y(), b.x() - middle.x());
    });
    all.push_back(points);
  }
  return all;
}

/// Distance of the ball's centre from its path on a rigid gear [m]; negative: it has sunk in.
inline double clearance(const std::vector<std::vector<Vector2>>& gear, const Vector2& p) {
  double distance = INFINITY;
  for (const auto& piece : gear) distance = std::min(distance, distanceTo(piece, p));
  return distance - kGearBall;
}

/// Where the hand's goal runs, a key every quarter of a millimetre.
enum class Lead { kTraced, kDrawn };

inline std::vector<Vector2> goals(const std::vector<std::vector<Vector2>>& gear, Lead lead, double from, double to,
                           double inward) {
  constexpr int kParts = 4000;
  std::vector<Vector2> out;
  for (int i = 0; i <= kParts; ++i) {
    const double angle = from + (to - from) * i / kParts;
    const Vector2 along(elementary::cos(angle), elementary::sin(angle));
    Vector2 goal = (kDrawnRadius - inward) * along;
    if (lead == Lead::kTraced) {
      // The rigid path from outside: the largest radius without clearance. Its normal by differences of the clearance.
      double free = 0.06, solid = 0.03;
      for (double r = free; r > solid; r -= 1e-4) {
        if (clearance(gear, r * along) > 0) continue;
        solid = r;
        free = r + 1e-4;
      }
      for (int k = 0; k < 30; ++k) (clearance(gear, 0.5 * (free + solid) * along) > 0 ? free : solid) = 0.5 * (free + solid);
      const Vector2 p = free * along;
      const double e = 1e-5;
      const Vector2 slope(clearance(gear, p + Vector2(e, 0)) - clearance(gear, p - Vector2(e, 0)),
                          clearance(gear, p + Vector2(0, e)) - clearance(gear, p - Vector2(0, e)));
      goal = p - inward * slope.normalized();
    }
    if (out.empty() || i == kParts || (goal - out.back()).norm() > 2.5e-4) out.push_back(goal);
  }
  return out;
}

}  // namespace haptic::scenes
