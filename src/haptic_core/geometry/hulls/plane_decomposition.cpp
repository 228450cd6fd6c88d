#include "haptic_core/geometry/hulls/plane_decomposition.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "haptic_core/base/error.h"
#include "haptic_core/geometry/hulls/thinned_hull.h"

namespace haptic {
namespace {

using Hull = std::shared_ptr<const ConvexPolyhedron>;
using Triangle = std::array<Vector3, 3>;

struct CutPlane {
  Vector3 normal;  ///< unit
  double offset;   ///< n·x of its points [m]
};

/// Points nearer to a plane than this share of the mesh's size lie on it: far above rounding, far below any
/// feature.
constexpr double kSamePlane = 1e-7;
/// Two pieces become one when their common hull is larger than both by less than this share.
constexpr double kJoinExcess = 1e-3;
/// Triangles on which planes are compared: hulls of more of them differ in volume by less than the planes do.
constexpr std::size_t kCompared = 2000;

/// A part of the mesh between cuts.
struct Part {
  std::vector<Triangle> surface;
  std::vector<CutPlane> cuts;  ///< planes of its caps, outward
  Hull hull;
  double depth = 0;  ///< of the deepest point of the surface below the hull, caps not counted [m]
  Triangle deepest;  ///< the triangle it is on
  Vector3 point;     ///< the point
};

Hull hullOf(const std::vector<Triangle>& surface, const std::string& name) {
  std::vector<Vector3> points;
  for (const Triangle& t : surface) points.insert(points.end(), t.begin(), t.end());
  const auto less = [](const Vector3& a, const Vector3& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(points.begin(), points.end(), less);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  try {
    return std::make_shared<const ConvexPolyhedron>(ConvexPolyhedron::hull(points, name));
  } catch (const SetupError&) {
    return nullptr;  // flat: it bounds no volume
  }
}

bool isCap(const ConvexPolyhedron::Face& face, const std::vector<CutPlane>& cuts, double near) {
  for (const CutPlane& cut : cuts) {
    if (face.normal.dot(cut.normal) > 1 - kSamePlane && std::abs(face.offset - cut.offset) < near) return true;
  }
  return false;
}

/// Depths at corners, middles of edges and the middle of each triangle: an edge can run below the hull with
/// both ends on it.
void measure(Part& part, double near) {
  std::vector<const ConvexPolyhedron::Face*> outside;
  for (const auto& face : part.hull->faces()) {
    if (!isCap(face, part.cuts, near)) outside.push_back(&face);
  }
  part.depth = 0;
  for (const Triangle& t : part.surface) {
    const Vector3 probes[] = {
        t[0], t[1], t[2], (t[0] + t[1]) / 2, (t[1] + t[2]) / 2, (t[2] + t[0]) / 2, (t[0] + t[1] + t[2]) / 3};
    for (const Vector3& p : probes) {
      double depth = std::numeric_limits<double>::infinity();
      for (const auto* face : outside) {
        depth = std::min(depth, face->offset - face->normal.dot(p));
        if (depth <= part.depth) break;
      }
      if (depth <= part.depth || !std::isfinite(depth)) continue;
      part.depth = depth;
      part.deepest = t;
      part.point = p;
    }
  }
}

/// The part of a triangle on the plane's inner side (n·x ≤ offset), as triangles.
void clip(const Triangle& t, const CutPlane& plane, double near, std::vector<Triangle>& kept) {
  std::vector<Vector3> polygon;
  bool inside = false;
  for (int i = 0; i < 3; ++i) {
    const Vector3 &a = t[i], &b = t[(i + 1) % 3];
    const double ha = plane.normal.dot(a) - plane.offset, hb = plane.normal.dot(b) - plane.offset;
    if (ha <= near) polygon.push_back(a);
    inside = inside || ha < -near;
    if ((ha < -near && hb > near) || (ha > near && hb < -near))
      polygon.push_back(a + ha / (ha - hb) * (b - a));
  }
  if (!inside) return;  // on the plane or beyond it
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    kept.push_back({polygon[0], polygon[i], polygon[i + 1]});
}

class Cutter {
 public:
  Cutter(const DecompositionSettings& settings, const std::string& name) : settings_(settings), name_(name) {}

  std::vector<Hull> run(const TriangleMesh& mesh, DecompositionReport& report);

 private:
  std::vector<CutPlane> candidates(const Part& part) const;
  bool split(const Part& part, Part& below, Part& above);
  bool cut(const Part& part, const CutPlane& plane, Part& below, Part& above);
  void join(std::vector<Hull>& hulls) const;

  const DecompositionSettings& settings_;
  const std::string& name_;
  double near_ = 0;
  double work_ = 0;  ///< triangles that were hulled
};

/// Planes through the deepest point, along the axes and along the surface there, and along its hollow's
/// walls.
std::vector<CutPlane> Cutter::candidates(const Part& part) const {
  std::vector<Vector3> normals = {Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()};
  const Triangle& t = part.deepest;
  const Vector3 n = (t[1] - t[0]).cross(t[2] - t[0]);
  if (n.norm() > 0) normals.push_back(n.normalized());
  for (int i = 0; i < 3; ++i) {
    const Vector3 edge = t[(i + 1) % 3] - t[i];
    const Vector3 wall = edge.cross(n);
    if (wall.norm() > 0) normals.push_back(wall.normalized());
  }
  std::vector<CutPlane> planes;
  for (const Vector3& normal : normals) {
    for (const Vector3& p : {part.point, t[0], t[1], t[2]}) {
      const double offset = normal.dot(p);
      const bool seen = std::any_of(planes.begin(), planes.end(), [&](const CutPlane& plane) {
        return std::abs(plane.normal.dot(normal)) > 1 - kSamePlane && std::abs(plane.offset - offset) < near_;
      });
      if (!seen) planes.push_back({normal, offset});
    }
  }
  return planes;
}

/// One triangle out of each so many of a part that at most kCompared are left; not always the same one, for meshes have rows.
Part thinned(const Part& part) {
  Part some;
  some.cuts = part.cuts;
  const std::size_t stride = 1 + (part.surface.size() - 1) / kCompared;
  std::uint32_t random = 1;
  for (std::size_t i = 0; i < part.surface.size(); i += stride) {
    random = 1664525u * random + 1013904223u;
    some.surface.push_back(part.surface[std::min(i + (random >> 16) % stride, part.surface.size() - 1)]);
  }
  return some;
}

bool Cutter::cut(const Part& part, const CutPlane& plane, Part& below, Part& above) {
  const CutPlane opposite{-plane.normal, -plane.offset};
  below.surface.clear();
  above.surface.clear();
  for (const Triangle& t : part.surface) {
    clip(t, plane, near_, below.surface);
    clip(t, opposite, near_, above.surface);
  }
  if (below.surface.empty() || above.surface.empty()) return false;
  work_ += static_cast<double>(below.surface.size() + above.surface.size());
  below.hull = hullOf(below.surface, name_);
  above.hull = hullOf(above.surface, name_);
  if (!below.hull || !above.hull) return false;
  below.cuts = above.cuts = part.cuts;
  below.cuts.push_back(plane);
  above.cuts.push_back(opposite);
  return true;
}

bool Cutter::split(const Part& part, Part& below, Part& above) {
  const Part compared = thinned(part);
  std::vector<std::pair<double, CutPlane>> planes;
  for (const CutPlane& plane : candidates(part)) {
    Part low, high;
    if (cut(compared, plane, low, high)) planes.emplace_back(low.hull->volume() + high.hull->volume(), plane);
  }
  std::stable_sort(planes.begin(), planes.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [volume, plane] : planes) {
    if (!cut(part, plane, below, above)) continue;  // a side of all its triangles is flat
    measure(below, near_);
    measure(above, near_);
    return true;
  }
  return false;
}

/// Whether the boxes of two hulls have a gap: what lies in it would be added by a common hull.
bool apart(const ConvexPolyhedron& a, const ConvexPolyhedron& b, double near) {
  return ((a.aabb().lower - b.aabb().upper).array() > near).any() || ((b.aabb().lower - a.aabb().upper).array() > near).any();
}

void Cutter::join(std::vector<Hull>& hulls) const {
  for (std::size_t i = 0; i < hulls.size(); ++i) {
    for (std::size_t j = i + 1; j < hulls.size();) {
      if (apart(*hulls[i], *hulls[j], near_)) {
        ++j;
        continue;
      }
      std::vector<Vector3> points = hulls[i]->vertices();
      points.insert(points.end(), hulls[j]->vertices().begin(), hulls[j]->vertices().end());
      const double volume = hulls[i]->volume() + hulls[j]->volume();
      std::optional<ConvexPolyhedron> both;
      try {
        both = ConvexPolyhedron::hull(points, name_);
      } catch (const SetupError&) {
        both.reset();  // rounding where the two meet: they stay apart
      }
      if (!both || both->volume() > (1 + kJoinExcess) * volume) {
        ++j;
        continue;
      }
      hulls[i] = std::make_shared<const ConvexPolyhedron>(*both);
      hulls.erase(hulls.begin() + j);
      j = i + 1;  // the larger piece may take in one that was refused before
    }
  }
}

std::vector<Hull> Cutter::run(const TriangleMesh& mesh, DecompositionReport& report) {
  Part whole;
  for (const auto& t : mesh.triangles) {
    whole.surface.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  }
  whole.hull = hullOf(whole.surface, name_);
  if (!whole.hull) throw SetupError(name_, "the mesh has no hull with volume", "give the body a thickness");
  near_ = kSamePlane * (whole.hull->aabb().upper - whole.hull->aabb().lower).maxCoeff();
  measure(whole, near_);
  std::vector<Part> open = {whole}, done;
  while (!open.empty()) {
    const auto worst = std::max_element(open.begin(), open.end(),
                                        [](const Part& a, const Part& b) { return a.depth < b.depth; });
    const bool spent = work_ > settings_.most_work;
    const bool full = static_cast<int>(open.size() + done.size()) >= settings_.max_pieces || spent;
    report.unfinished = report.unfinished || (spent && worst->depth > settings_.tolerance);
    if (settings_.progress) settings_.progress(static_cast<int>(open.size() + done.size()), worst->depth);
    Part below, above;
    if (worst->depth <= settings_.tolerance || full || !split(*worst, below, above)) {
      done.push_back(std::move(*worst));
      open.erase(worst);
      continue;
    }
    *worst = std::move(below);
    open.push_back(std::move(above));
  }
  std::vector<Hull> hulls;
  for (const Part& part : done) {
    // Corners on a cut stay: the neighbour has the same ones.
    const auto isOnCut = [&](const Vector3& p) {
      return std::any_of(part.cuts.begin(), part.cuts.end(),
          [&](const CutPlane& cut) { return std::abs(cut.normal.dot(p) - cut.offset) < near_; });
    };
    double inward = 0;
    hulls.push_back(thinnedHull(part.hull, kThinnedShare * settings_.tolerance, name_, inward, isOnCut));
    report.distance = std::max({report.distance, part.depth, inward});
  }
  join(hulls);
  return hulls;
}

}  // namespace

std::vector<Hull> cutIntoConvexPieces(const TriangleMesh& mesh, const DecompositionSettings& settings,
                                      const std::string& name, DecompositionReport& report) {
  return Cutter(settings, name).run(mesh, report);
}

}  // namespace haptic
