#include "haptic_core/geometry/volume/covered_area.h"

#include <algorithm>
#include <utility>

namespace haptic {
namespace {

/// Keeps the part of the polygon on the side of the plane through `p` that `inward` points to.
void cutPolygon(const LoadedVector<Vector3>& polygon, const Vector3& p, const Vector3& inward, LoadedVector<Vector3>& kept) {
  kept.clear();
  for (int i = 0; i < polygon.size(); ++i) {
    const Vector3 &from = polygon[i], &to = polygon[i + 1 < polygon.size() ? i + 1 : 0];
    const double h_from = inward.dot(from - p), h_to = inward.dot(to - p);
    if (h_from >= 0) kept.push_back(from);
    if ((h_from >= 0) != (h_to >= 0)) kept.push_back(from + h_from / (h_from - h_to) * (to - from));
  }
}

double areaOf(const LoadedVector<Vector3>& polygon, const Vector3& n) {
  double twice = 0;
  for (int i = 1; i + 1 < polygon.size(); ++i) {
    twice += n.dot((polygon[i] - polygon[0]).cross(polygon[i + 1] - polygon[0]));
  }
  return 0.5 * twice;
}

/// Area over half of the outline: of a strip its width, which on a wall is the depth of what stands over it.
double narrowest(const LoadedVector<Vector3>& polygon, double area) {
  double around = 0;
  for (int i = 0; i < polygon.size(); ++i) around += (polygon[i + 1 < polygon.size() ? i + 1 : 0] - polygon[i]).norm();
  return 2 * area / around;
}

/// Whether V misses a cover: all points lie beyond one edge of a cover's outline, in the face with outward normal n: most contacts do.
bool misses(const LoadedVector<Vector3>& points, const InnerFaces::Cover& cover, const Vector3& n, const Pose& X_AS) {
  const int corners = static_cast<int>(cover.outline.size());
  for (int k = 0; k < corners; ++k) {
    const Vector3 p = X_AS * cover.outline[k], inward = n.cross(X_AS * cover.outline[k + 1 < corners ? k + 1 : 0] - p);
    const double edge = inward.dot(p);
    bool beyond = true;
    for (int i = 0; i < points.size() && beyond; ++i) beyond = inward.dot(points[i]) <= edge;
    if (beyond) return true;
  }
  return false;
}

}  // namespace

CoveredArea ContactWorkspace::coveredArea(Owner owner, const InnerFaces& inner, const Pose& X_AS) noexcept {
  CoveredArea covered;
  for (int f = 0; f < faces_.size(); ++f) {
    const ContactFace& face = faces_[f];
    if (face.owner != owner || !inner.has(face.index)) continue;
    bool have_loops = false;
    for (const InnerFaces::Cover& cover : inner.covers) {
      if (cover.face != face.index || misses(vertices_, cover, face.normal, X_AS)) continue;
      if (!have_loops) buildLoopsOf(f);
      have_loops = true;
      for (const ContactLoop& loop : loops_) {
        outline_.clear();
        for (int i = 0; i < loop.count; ++i) outline_.push_back(vertices_[loop_vertices_[loop.first + i]]);
        for (std::size_t k = 0; k < cover.outline.size() && outline_.size() >= 3; ++k) {
          const Vector3 p = X_AS * cover.outline[k], q = X_AS * cover.outline[k + 1 < cover.outline.size() ? k + 1 : 0];
          cutPolygon(outline_, p, face.normal.cross(q - p), cut_outline_);
          std::swap(outline_, cut_outline_);
        }
        const double whole = std::max(0.0, areaOf(outline_, face.normal));
        if (!(whole > 0)) continue;
        covered.touched = true;
        const double area = cover.gap > 0 ? whole * cover.share(narrowest(outline_, whole)) : whole;
        covered.area += area;
        covered.vector += area * face.normal;
      }
    }
  }
  return covered;
}

CoveredArea coveredArea(ContactWorkspace& workspace, Owner owner, const InnerFaces* inner, const Pose& X_AS) noexcept {
  return inner ? workspace.coveredArea(owner, *inner, X_AS) : CoveredArea{};
}

}  // namespace haptic
