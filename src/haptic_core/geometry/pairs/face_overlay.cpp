#include "haptic_core/geometry/pairs/face_overlay.h"

#include <cmath>

#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"

namespace haptic {
namespace {

/// Least cosine between a face's normal and the contact's: beyond it the faces beside count as much.
constexpr double kNearlyParallel = 0.9;

/// Corners of the octagon that stands for a cylinder's end, of its area, over the radius: 2^(-1/4) √(π/2).
constexpr int kOctagon = 8;
constexpr double kOctagonReach = 1.0539073652554058, kOctagonSide = kOctagonReach * M_SQRT1_2;
constexpr double kOctagonX[kOctagon] = {kOctagonReach, kOctagonSide, 0, -kOctagonSide, -kOctagonReach, -kOctagonSide, 0, kOctagonSide};
constexpr double kOctagonY[kOctagon] = {0, kOctagonSide, kOctagonReach, kOctagonSide, 0, -kOctagonSide, -kOctagonReach, -kOctagonSide};

/// A polyhedron's face, a cylinder's end, or a half-space's surface, which has no corners.
struct FlatSide {
  const ConvexPolyhedron* polyhedron = nullptr;  ///< null: not one of its faces
  const Rod* rod = nullptr;                      ///< null: not one of its ends
  Vector3 normal = Vector3::UnitZ(), point = Vector3::Zero();  ///< outward; on it [m]
  int first = 0, count = 0;                      ///< its corners; none: a half-space

  /// Counter-clockwise, seen from outside.
  Vector3 corner(int i) const {
    if (polyhedron) return polyhedron->vertices()[polyhedron->loopVertex(first + i)];
    return {rod->radius() * kOctagonX[i], rod->radius() * normal.z() * kOctagonY[i], normal.z() * rod->halfLength()};
  }
};

bool hasFlatSides(const ConvexShape& shape) {
  return shape.polyhedron() || shape.halfSpace() || (shape.rod() && !shape.rod()->isCapsule());
}

/// The side whose outward normal looks most along `direction`; false: none nearly.
bool sideAlong(const ConvexShape& shape, const Vector3& direction, FlatSide& side) {
  double most = kNearlyParallel;
  if (shape.halfSpace()) return direction.z() > most;
  if (shape.rod() && std::abs(direction.z()) > most) {
    side.rod = shape.rod();
    side.normal.z() = direction.z() > 0 ? 1 : -1;
    side.count = kOctagon;
  } else if (shape.polyhedron()) {
    side.polyhedron = shape.polyhedron();
    for (const ConvexPolyhedron::Face& face : side.polyhedron->faces()) {
      const double along = face.normal.dot(direction);
      if (along > most) most = along, side.normal = face.normal, side.first = face.first, side.count = face.count;
    }
  }
  if (side.count == 0) return false;
  side.point = side.corner(0);
  return true;
}

/// Height along P's z of a face's plane, which holds the point p [P's frame].
LinearField heightOf(const Vector3& normal_P, const Vector3& p) {
  return {normal_P.dot(p) / normal_P.z(), -normal_P.x() / normal_P.z(), -normal_P.y() / normal_P.z()};
}

}  // namespace

void FaceOverlay::clip(const LinearField& positive, Polygon& polygon) noexcept {
  const Polygon from = polygon;
  polygon.corners = 0;
  const auto keep = [&](double x, double y) {
    polygon.x[polygon.corners] = x;
    polygon.y[polygon.corners++] = y;
  };
  for (int i = 0; i < from.corners; ++i) {
    const int j = i + 1 < from.corners ? i + 1 : 0;
    const double f = positive.at(from.x[i], from.y[i]), g = positive.at(from.x[j], from.y[j]);
    if (f > 0) keep(from.x[i], from.y[i]);
    if ((f > 0) != (g > 0) && polygon.corners < kMostCorners + 2) {
      const double t = f / (f - g);
      keep(from.x[i] + t * (from.x[j] - from.x[i]), from.y[i] + t * (from.y[j] - from.y[i]));
    }
    if (polygon.corners >= kMostCorners + 2) break;  // rounding made the polygon concave
  }
}

bool FaceOverlay::needsClipping(const LinearField& field, bool& nothing) const noexcept {
  int positive = 0;
  for (int i = 0; i < corners_; ++i) positive += field.at(x_[i], y_[i]) > 0;
  nothing |= positive == 0;
  return positive < corners_;
}

bool FaceOverlay::find(const ConvexShape& first, const ConvexShape& second, const Pose& X_AB, const Pose& X_AP) noexcept {
  corners_ = 0;
  if (!hasFlatSides(first) || !hasFlatSides(second)) return false;
  const Vector3 n = X_AP.R.col(2);
  FlatSide U, L;
  if (!sideAlong(first, n, U) || !sideAlong(second, X_AB.R.transpose() * -n, L)) return false;
  if (U.count + L.count > kMostCorners) return false;
  const Pose X_PA = X_AP.inverse(), X_PB = X_PA * X_AB;
  // A's loop is counter-clockwise seen from B, which is from where P's z points; B's runs the other way.
  Polygon polygon;
  const auto start = [&polygon](const Vector3& p) { polygon.x[polygon.corners] = p.x(), polygon.y[polygon.corners++] = p.y(); };
  for (int i = 0; i < U.count; ++i) start(X_PA * U.corner(i));
  if (U.count == 0) {
    for (int i = L.count - 1; i >= 0; --i) start(X_PB * L.corner(i));
  }
  const LinearField upper = heightOf(X_PA.R * U.normal, X_PA * U.point), lower = heightOf(X_PB.R * L.normal, X_PB * L.point);
  Vector3 to = X_PB * L.point;
  for (int i = L.count - 1; U.count > 0 && i >= 0 && polygon.corners >= 3; --i) {
    const Vector3 from = to;
    to = X_PB * L.corner(i);
    const double ux = to.x() - from.x(), uy = to.y() - from.y();
    clip({uy * from.x() - ux * from.y(), -uy, ux}, polygon);
  }
  if (polygon.corners < 3 || polygon.corners > kMostCorners) return false;
  corners_ = polygon.corners;
  std::copy_n(polygon.x, corners_, x_);
  std::copy_n(polygon.y, corners_, y_);
  thickness_ = {upper.c - lower.c, upper.cx - lower.cx, upper.cy - lower.cy};
  if (area() > 0) return true;
  corners_ = 0;
  return false;
}

void FaceOverlay::centre(Pose& X_AP) noexcept {
  double x = 0, y = 0;
  for (int i = 0; i < corners_; ++i) x += x_[i] / corners_, y += y_[i] / corners_;
  shift(-x, -y);
  X_AP.p += X_AP.R * Vector3(x, y, 0);
}

void FaceOverlay::shift(double x, double y) noexcept {
  for (int i = 0; i < corners_; ++i) x_[i] += x, y_[i] += y;
  thickness_.c = thickness_.at(-x, -y);
}

double FaceOverlay::area() const {
  double twice = 0;
  for (int i = 1; i + 1 < corners_; ++i) {
    twice += (x_[i] - x_[0]) * (y_[i + 1] - y_[0]) - (y_[i] - y_[0]) * (x_[i + 1] - x_[0]);
  }
  return 0.5 * twice;
}

}  // namespace haptic
