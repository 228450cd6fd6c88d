// ConvexPolyhedron::hull: the one file that knows Qhull.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <set>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/shapes/convex_polyhedron.h"

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

namespace haptic {
namespace {

/// A run of Qhull and its memory.
class Quickhull {
 public:
  /// Points less than `width` [m] outside of a facet count as on it.
  Quickhull(std::vector<double>& coordinates, double width) {
    errors_ = std::tmpfile();
    qh_zero(&qh_, errors_);
    char options[64];
    std::snprintf(options, sizeof options, width > 0 ? "qhull W%.17g" : "qhull", width);
    failed_ = qh_new_qhull(&qh_, 3, static_cast<int>(coordinates.size() / 3), coordinates.data(), 0, options,
                           nullptr, errors_) != 0;
  }
  ~Quickhull() {
    qh_.NOerrexit = True;
    qh_freeqhull(&qh_, !qh_ALL);
    int remaining = 0, blocks = 0;
    qh_memfreeshort(&qh_, &remaining, &blocks);
    if (errors_) std::fclose(errors_);
  }
  Quickhull(const Quickhull&) = delete;
  Quickhull& operator=(const Quickhull&) = delete;

  bool failed() const { return failed_; }
  qhT* operator->() { return &qh_; }
  qhT* get() { return &qh_; }

 private:
  qhT qh_;
  std::FILE* errors_ = nullptr;
  bool failed_ = false;
};

/// Qhull merges facets as wide as its own roundings; a loop wider than ours is cut into triangles again.
bool isFlat(const std::vector<int>& loop, const std::vector<Vector3>& points, const Vector3& normal,
            double offset, double tolerance) {
  for (int i : loop)
    if (std::abs(normal.dot(points[i]) + offset) > tolerance) return false;
  return true;
}

/// Steps of an STL's numbers, beside the largest of them, and the coarsest that we take in their place: 0.1 %, below any feature.
constexpr double kFloatStep = 1.0 / (1 << 23), kCoarsestStep = 1e-3;

/// One point of each cell of a grid, the first.
std::vector<Vector3> firstInCells(const std::vector<Vector3>& points, double cell) {
  std::set<std::array<double, 3>> taken;
  std::vector<Vector3> first;
  for (const Vector3& p : points) {
    if (taken.insert({std::round(p.x() / cell), std::round(p.y() / cell), std::round(p.z() / cell)}).second) first.push_back(p);
  }
  return first;
}

struct Facets {
  std::vector<Vector3> vertices;
  std::vector<std::vector<int>> loops;
};

/// Loops counter-clockwise seen from outside. False: the points lie in a plane.
bool facetsOf(const std::vector<Vector3>& points, double size, double width, Facets& out) {
  std::vector<double> coordinates;
  for (const Vector3& p : points) coordinates.insert(coordinates.end(), p.data(), p.data() + 3);
  Quickhull qhull(coordinates, width);
  if (qhull.failed()) return false;
  qhT* qh = qhull.get();
  std::vector<int> index_of(points.size(), -1);
  facetT* facet;
  FORALLfacets {
    setT* ordered = qh_facet3vertex(qh, facet);
    std::vector<int> loop;
    vertexT *vertex, **vertexp;
    FOREACHvertex_(ordered) loop.push_back(qh_pointid(qh, vertex->point));
    qh_settempfree(qh, &ordered);
    // Qhull lists a loop clockwise seen from outside.
    std::reverse(loop.begin(), loop.end());
    const bool flat = isFlat(loop, points, Vector3(facet->normal[0], facet->normal[1], facet->normal[2]),
                             facet->offset, 0.25 * ConvexPolyhedron::kFlatness * size);
    for (int& i : loop) {
      if (index_of[i] < 0) {
        index_of[i] = static_cast<int>(out.vertices.size());
        out.vertices.push_back(points[i]);
      }
      i = index_of[i];
    }
    if (flat) {
      out.loops.push_back(std::move(loop));
    } else {
      for (std::size_t i = 1; i + 1 < loop.size(); ++i) out.loops.push_back({loop[0], loop[i], loop[i + 1]});
    }
  }
  return true;
}

}  // namespace

ConvexPolyhedron ConvexPolyhedron::hull(const std::vector<Vector3>& points, const std::string& name) {
  if (points.size() < 4)
    throw SetupError(name, std::to_string(points.size()) + " points have no hull", "give at least 4");
  double size = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite())
      throw SetupError(name, "point " + std::to_string(i) + " is not finite", "correct its coordinates");
    size = std::max(size, points[i].cwiseAbs().maxCoeff());
  }
  // Points that stray from one plane by the steps of their numbers make facets narrower than doubles tell apart. Coarser points do not.
  for (double width = 0;; width = std::max(4 * width, kFloatStep * size)) {
    Facets facets;
    if (!facetsOf(width > 0 ? firstInCells(points, width) : points, size, width, facets))
      throw SetupError(name, "the points have no hull with volume (they lie in a plane, or nearly)", "give the body a thickness");
    try {
      return ConvexPolyhedron(std::move(facets.vertices), facets.loops, name);
    } catch (const SetupError&) {
      if (width > kCoarsestStep * size) throw;
    }
  }
}

}  // namespace haptic
