#include "haptic_core/world/contact_detail.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/volume/contact_volume.h"
#include "haptic_core/world/contact_evaluation.h"

namespace haptic {
namespace {

/// The curve in which the surfaces of A and B cross, as V's edges go round A's faces; of several the one about the largest area. V's parts
/// of A and of B end there, so that its projection encloses ∫ n·dS over A's part: the area of the patch, also where a deep body leans over.
void seamOf(const ContactWorkspace& workspace, const ContactVolume& volume, std::vector<int>& next, std::vector<Vector2>& points) {
  next.assign(static_cast<std::size_t>(workspace.vertices().size()), -1);
  for (const ContactEdge& edge : workspace.edges()) {
    if (workspace.faces()[edge.left].owner == workspace.faces()[edge.right].owner) continue;
    const bool forwards = workspace.faces()[edge.left].owner == Owner::kA;
    next[forwards ? edge.from : edge.to] = forwards ? edge.to : edge.from;
  }
  double largest = 0;
  for (std::size_t start = 0; start < next.size(); ++start) {
    std::vector<Vector2> loop;
    double area = 0;
    for (int v = static_cast<int>(start); next[v] >= 0;) {
      loop.push_back((volume.X_AP.R.transpose() * (workspace.vertices()[v] - volume.X_AP.p)).head<2>());
      const int after = next[v];
      next[v] = -1;
      v = after;
    }
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vector2 &p = loop[i], &q = loop[i + 1 < loop.size() ? i + 1 : 0];
      area += 0.5 * (p.x() * q.y() - p.y() * q.x());
    }
    if (area > largest) largest = area, points = loop;
  }
}

/// Corners of a polygon with the ellipse's area about its centre.
void ellipseOf(const ContactVolume& volume, std::vector<Vector2>& points) {
  const Vector2 centre = volume.A1 / volume.A0;
  const Matrix2 spread = volume.A2 / volume.A0 - centre * centre.transpose();
  const double mean = 0.5 * spread.trace(), half_difference = 0.5 * (spread(0, 0) - spread(1, 1));
  const double radius = elementary::hypot(half_difference, spread(1, 0));  // of Mohr's circle
  const auto [along_y, along_x] = elementary::sinCos(0.5 * elementary::atan2(spread(1, 0), half_difference));
  Matrix2 axes;  // of the lesser and of the greater deviation
  axes << along_y, along_x, -along_x, along_y;
  constexpr double kStep = 6.283185307179586 / PatchOutline::kRoundCorners;  // [rad]
  // Half axes are twice the deviations; π a b becomes the area, and n/2 sin(2π/n) a b that of the polygon.
  const Vector2 half = 2 * Vector2(mean - radius, mean + radius).cwiseMax(0).cwiseSqrt();
  const double polygon = 0.5 * PatchOutline::kRoundCorners * elementary::sin(kStep) * half.x() * half.y();
  const double scale = polygon > 0 ? std::sqrt(volume.A0 / polygon) : 0;
  for (int i = 0; i < PatchOutline::kRoundCorners; ++i) {
    const auto [sine, cosine] = elementary::sinCos(kStep * i);
    points.push_back(centre + axes * Vector2(scale * half.x() * cosine, scale * half.y() * sine));
  }
}

}  // namespace

Vector3 centreOfPressure(const ContactReport& contact) noexcept {
  const Vector3 n = contact.X_WP.R.col(2);
  const double normal = contact.F_BP_W.force.dot(n);
  if (!(normal > 0)) return contact.X_WP.p;
  return contact.X_WP.p + n.cross(contact.F_BP_W.torque) / normal;
}

Vector3 slipOf(const Model& model, const ContactReport& contact, const LinkWork* link) noexcept {
  const Vector3 n = contact.X_WP.R.col(2), at = centreOfPressure(contact);
  const Twist belt = beltTwist(model, contact.shape_a, contact.shape_b, link, contact.X_WP).rotated(contact.X_WP.R);
  const Vector3 v = link[contact.link_b].twistAt(at).linear - link[contact.link_a].twistAt(at).linear +
                    belt.shifted(at - contact.X_WP.p).linear;
  return v - n.dot(v) * n;
}

PatchOutline::PatchOutline(const Model& model) : model_(model) { model.reserve(workspace_); }

const std::vector<Vector3>& PatchOutline::of(const ContactReport& contact, const Pose& X_WA, const Pose& X_WB) {
  points_.clear(), corners_.clear();
  const ModelShape &a = model_.shapes[contact.shape_a], &b = model_.shapes[contact.shape_b];
  const Pose X_WS = X_WA * a.X_LS;
  PairCache cache;
  ContactVolume volume;
  ContactRequest request;
  request.normal = X_WS.R.transpose() * contact.X_WP.R.col(2);
  cache.normal = request.normal;
  contactVolume(*a.shape, *b.shape, relativePose(X_WS, X_WB * b.X_LS), cache, workspace_, volume, request);
  if (volume.status != ContactVolume::Status::kOverlap) return corners_;
  if (workspace_.round().filled) {
    ellipseOf(volume, points_);
  } else {
    seamOf(workspace_, volume, next_, points_);
  }
  const Pose X_WP = X_WS * volume.X_AP;
  for (const Vector2& point : points_) corners_.push_back(X_WP * Vector3(point.x(), point.y(), 0));
  return corners_;
}

}  // namespace haptic
