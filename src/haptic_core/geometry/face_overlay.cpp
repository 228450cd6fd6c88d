#include "haptic_core/geometry/face_overlay.h"

namespace haptic {
namespace {

/// Least cosine between a face's normal and the contact's: beyond it the faces beside count as much.
constexpr double kNearlyParallel = 0.9;

/// The face whose outward normal looks most along `direction`; -1: none nearly.
int faceAlong(const ConvexPolyhedron& shape, const Vector3& direction) {
  int found = -1;
  double most = kNearlyParallel;
  for (int f = 0; f < shape.faceCount(); ++f) {
    const double along = shape.faces()[f].normal.dot(direction);
    if (along > most) most = along, found = f;
  }
  return found;
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
  if (!first.polyhedron() || !second.polyhedron()) return false;
  const ConvexPolyhedron &A = *first.polyhedron(), &B = *second.polyhedron();
  const Vector3 n = X_AP.R.col(2);
  const int above = faceAlong(A, n), below = faceAlong(B, X_AB.R.transpose() * -n);
  if (above < 0 || below < 0) return false;
  const ConvexPolyhedron::Face &U = A.faces()[above], &L = B.faces()[below];
  if (U.count + L.count > kMostCorners) return false;
  const Pose X_PA = X_AP.inverse(), X_PB = X_PA * X_AB;
  // A's loop is counter-clockwise seen from B, which is from where P's z points.
  Polygon polygon;
  for (int i = 0; i < U.count; ++i) {
    const Vector3 p = X_PA * A.vertices()[A.loopVertex(U.first + i)];
    polygon.x[i] = p.x(), polygon.y[i] = p.y();
  }
  polygon.corners = U.count;
  const LinearField upper = heightOf(X_PA.R * U.normal, X_PA * A.vertices()[A.loopVertex(U.first)]),
                    lower = heightOf(X_PB.R * L.normal, X_PB * B.vertices()[B.loopVertex(L.first)]);
  Vector3 to = X_PB * B.vertices()[B.loopVertex(L.first)];
  for (int i = L.count - 1; i >= 0 && polygon.corners >= 3; --i) {  // B's loop runs the other way
    const Vector3 from = to;
    to = X_PB * B.vertices()[B.loopVertex(L.first + i)];
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
