#include "haptic_core/geometry/hulls/ground.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "haptic_core/base/disjoint_sets.h"
#include "haptic_core/base/elementary.h"
#include "haptic_core/base/error.h"

namespace haptic {
namespace {

/// Share of a piece's largest coordinate by which points may lie off one plane or one line and still count as in it: a quarter of the
/// roundings that a polyhedron bears.
constexpr double kFlat = 0.25 * ConvexPolyhedron::kFlatness;
/// Share of the surface's extent by which neighbours may overlap in the view from above: roundings of files in single precision.
constexpr double kOverlap = 1e-6;
/// Least |z| of the normal of a triangle that is not upright.
constexpr double kUpright = 1e-9;

/// A piece of ground is as thick as the whole is deep: its walls are no surface that something could pass through.
class GroundPiece : public ConvexPolyhedron {
 public:
  GroundPiece(std::vector<Vector3> vertices, const std::vector<std::vector<int>>& faces, double thickness, const std::string& name)
      : ConvexPolyhedron(std::move(vertices), faces, name), thickness_(thickness) {}
  double leastWidth() const override { return thickness_; }

 private:
  double thickness_;  ///< [m]
};

using Loop = std::vector<int>;

/// Twice the area that a, b, c span in the view from above [m²].
double turn(const Vector3& a, const Vector3& b, const Vector3& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

std::uint64_t edgeKey(int from, int to) { return static_cast<std::uint64_t>(from) << 32 | static_cast<std::uint32_t>(to); }

/// Triangles that look up, joined to convex polygons where they lie in one plane.
class Surface {
 public:
  Surface(const TriangleMesh& mesh, const std::string& name) : points_(mesh.vertices), name_(name) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) add(mesh.triangles[t], static_cast<int>(t));
    if (loops_.empty()) throw SetupError(name_, "no triangle looks up", "give a surface that is seen from above, z up");
    joined_ = DisjointSets(loops_.size());
    triangles_ = static_cast<int>(loops_.size());
  }
  int triangles() const { return triangles_; }

  void join() {
    joinPlanes();
    std::vector<char> taken(loops_.size());
    for (bool any = true; any;) {
      any = false;
      std::fill(taken.begin(), taken.end(), 0);
      for (int p = 0; p < static_cast<int>(loops_.size()); ++p) any = (joined_.root(p) == p && !taken[p] && joinOne(p, taken)) || any;
    }
  }
  /// Loops without corners that lie on a line between their neighbours.
  std::vector<Loop> polygons() {
    std::vector<Loop> out;
    for (std::size_t p = 0; p < loops_.size(); ++p) {
      if (joined_.root(static_cast<int>(p)) == static_cast<int>(p)) out.push_back(cornersOf(loops_[p]));
    }
    return out;
  }

 private:
  void add(const std::array<int, 3>& t, int number) {
    const Vector3 &a = points_[t[0]], &b = points_[t[1]], &c = points_[t[2]];
    const Vector3 area = (b - a).cross(c - a);
    if (!area.allFinite()) throw SetupError(name_, triangle(number) + " has a corner that is not finite", "export it again");
    const double size = area.norm();
    if (!(std::abs(area.z()) > kUpright * size)) return;
    if (area.z() < 0) {
      throw SetupError(name_, triangle(number) + " looks down",
                       "ground is a surface seen from above: turn it over, cut off what looks down, or let the mesh collide as it is");
    }
    const int p = static_cast<int>(loops_.size());
    loops_.push_back({t[0], t[1], t[2]});
    normals_.push_back(area / size);
    for (int i = 0; i < 3; ++i) polygon_at_.emplace(edgeKey(t[i], t[(i + 1) % 3]), p);
  }
  static std::string triangle(int number) { return "triangle " + std::to_string(number); }

  /// The polygon beyond an edge; −1: none.
  int beyond(int from, int to) {
    const auto found = polygon_at_.find(edgeKey(to, from));
    return found == polygon_at_.end() ? -1 : joined_.root(found->second);
  }
  double tolerance(const Loop& loop) const {
    double size = 0;
    for (const int v : loop) size = std::max(size, points_[v].cwiseAbs().maxCoeff());
    return kFlat * size;
  }
  bool inPlane(int plane, const Loop& loop) const {
    const Vector3 &n = normals_[plane], &o = points_[loops_[plane][0]];
    const double most = tolerance(loop);
    return std::all_of(loop.begin(), loop.end(), [&](int v) { return std::abs(n.dot(points_[v] - o)) <= most; });
  }
  bool isConvex(const Loop& loop) const {
    const double most = tolerance(loop);
    const std::size_t n = loop.size();
    double angle = 0;  // of all turns: once around
    for (std::size_t i = 0; i < n; ++i) {
      const Vector3 &a = points_[loop[i]], &b = points_[loop[(i + 1) % n]], &c = points_[loop[(i + 2) % n]];
      const double twice = turn(a, b, c), length = (c - a).head<2>().norm();
      const Vector2 ab = (b - a).head<2>(), bc = (c - b).head<2>();
      if (twice < -most * length || !(length > 0)) return false;
      angle += elementary::atan2(std::max(0.0, twice), ab.dot(bc));
    }
    return angle < 3 * M_PI;
  }
  Loop cornersOf(const Loop& loop) const {
    const double most = tolerance(loop);
    Loop out = loop;
    for (std::size_t i = 0; i < out.size() && out.size() > 3;) {
      const std::size_t n = out.size();
      const Vector3 &a = points_[out[(i + n - 1) % n]], &b = points_[out[i]], &c = points_[out[(i + 1) % n]];
      const bool corner = turn(a, b, c) > most * (c - a).head<2>().norm();
      if (corner) ++i;
      else out.erase(out.begin() + i);
    }
    return out;
  }

  /// All of a plane at once, where it is convex as a whole.
  void joinPlanes() {
    std::vector<int> group(loops_.size(), -1);
    for (int seed = 0; seed < static_cast<int>(loops_.size()); ++seed) {
      if (group[seed] >= 0) continue;
      std::vector<int> members{seed};
      group[seed] = seed;
      for (std::size_t m = 0; m < members.size(); ++m) {
        const Loop loop = loops_[members[m]];
        for (int i = 0; i < 3; ++i) {
          const int q = beyond(loop[i], loop[(i + 1) % 3]);
          if (q < 0 || group[q] >= 0 || !inPlane(seed, loops_[q])) continue;
          group[q] = seed;
          members.push_back(q);
        }
      }
      if (members.size() > 1) joinAll(members, group, seed);
    }
  }
  void joinAll(const std::vector<int>& members, const std::vector<int>& group, int seed) {
    std::map<int, int> next;  // along the outline
    std::size_t edges = 0;
    for (const int p : members) {
      for (int i = 0; i < 3; ++i) {
        const int from = loops_[p][i], to = loops_[p][(i + 1) % 3], q = beyond(from, to);
        if (q >= 0 && group[q] == seed) continue;
        next[from] = to;
        ++edges;
      }
    }
    Loop outline;
    for (int v = next.begin()->first; outline.size() < edges; v = next[v]) outline.push_back(v);
    const bool one_loop = edges == next.size() && next[outline.back()] == outline[0] &&
                          std::find(outline.begin() + 1, outline.end(), outline[0]) == outline.end();
    if (!one_loop || !isConvex(outline)) return;
    for (const int p : members) joined_.mergeInto(seed, p);
    loops_[seed] = outline;
  }

  /// Joins polygon p with the neighbour with which it shares most, if they are convex together.
  bool joinOne(int p, std::vector<char>& taken) {
    std::map<int, double> shared;  // length by neighbour
    const Loop& loop = loops_[p];
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const int from = loop[i], to = loop[(i + 1) % loop.size()], q = beyond(from, to);
      if (q < 0 || q == p || taken[q]) continue;
      shared[q] += (points_[to] - points_[from]).norm();
    }
    std::vector<std::pair<double, int>> order;
    for (const auto& [q, length] : shared) {
      if (inPlane(p, loops_[q])) order.emplace_back(-length, q);
    }
    std::sort(order.begin(), order.end());
    for (const auto& entry : order) {
      Loop common;
      if (!unite(loop, loops_[entry.second], common) || !isConvex(common)) continue;
      joined_.mergeInto(p, entry.second);
      loops_[p] = common;
      taken[p] = taken[entry.second] = 1;
      return true;
    }
    return false;
  }
  /// The outline of two loops that share one run of edges.
  static bool unite(const Loop& p, const Loop& q, Loop& out) {
    std::map<int, std::size_t> in_q;
    for (std::size_t i = 0; i < q.size(); ++i) in_q[q[i]] = i;
    const auto isShared = [&](std::size_t i) {
      const auto from = in_q.find(p[i]), to = in_q.find(p[(i + 1) % p.size()]);
      return from != in_q.end() && to != in_q.end() && (to->second + 1) % q.size() == from->second;
    };
    std::size_t start = p.size(), shared = 0, runs = 0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      if (!isShared(i)) continue;
      ++shared;
      if (isShared((i + p.size() - 1) % p.size())) continue;
      ++runs;
      start = i;
    }
    if (runs != 1 || shared == p.size()) return false;
    // p from the end of the run to its start, then q from there.
    for (std::size_t k = shared; k <= p.size(); ++k) out.push_back(p[(start + k) % p.size()]);
    const std::size_t from = in_q[p[start]];
    for (std::size_t k = 1; k < q.size() - shared; ++k) out.push_back(q[(from + k) % q.size()]);
    return true;
  }

  const std::vector<Vector3>& points_;
  std::string name_;
  std::vector<Loop> loops_;        ///< counter-clockwise seen from above; of roots valid
  std::vector<Vector3> normals_;   ///< of the triangles
  DisjointSets joined_;            ///< of triangles; loops are those of roots
  std::unordered_map<std::uint64_t, int> polygon_at_;  ///< by directed edge the triangle on its left
  int triangles_ = 0;
};

std::shared_ptr<const ConvexShape> prism(const std::vector<Vector3>& points, const Loop& loop, double base, double thickness,
                                         const std::string& name) {
  const int n = static_cast<int>(loop.size());
  std::vector<Vector3> vertices;
  for (const int v : loop) vertices.push_back(points[v]);
  for (const int v : loop) vertices.emplace_back(points[v].x(), points[v].y(), base);
  std::vector<Loop> faces(2);
  for (int i = 0; i < n; ++i) {
    faces[0].push_back(i);
    faces[1].push_back(2 * n - 1 - i);
    const int next = (i + 1) % n;
    faces.push_back({n + i, n + next, next, i});
  }
  return std::make_shared<GroundPiece>(std::move(vertices), faces, thickness, name);
}

/// Whether two convex outlines overlap by more than `most` [m] in the view from above.
bool overlap(const std::vector<Vector3>& points, const Loop& a, const Loop& b, double most) {
  const auto apartAlong = [&](const Loop& own, const Loop& other) {
    for (std::size_t i = 0; i < own.size(); ++i) {
      const Vector3 &from = points[own[i]], &to = points[own[(i + 1) % own.size()]];
      const double length = (to - from).head<2>().norm();
      if (std::all_of(other.begin(), other.end(), [&](int v) { return turn(from, to, points[v]) <= most * length; })) return true;
    }
    return false;
  };
  return !apartAlong(a, b) && !apartAlong(b, a);
}

/// Looks at outlines whose boxes overlap only, along x.
void refuseLayers(const std::vector<Vector3>& points, const std::vector<Loop>& polygons, const std::string& name) {
  struct Span {
    double from, to, low, high;  ///< along x and y [m]
    int polygon;
  };
  std::vector<Span> spans;
  double extent = 0;
  for (std::size_t p = 0; p < polygons.size(); ++p) {
    Span span{INFINITY, -INFINITY, INFINITY, -INFINITY, static_cast<int>(p)};
    for (const int v : polygons[p]) {
      span.from = std::min(span.from, points[v].x()), span.to = std::max(span.to, points[v].x());
      span.low = std::min(span.low, points[v].y()), span.high = std::max(span.high, points[v].y());
      extent = std::max(extent, points[v].head<2>().cwiseAbs().maxCoeff());
    }
    spans.push_back(span);
  }
  std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) { return a.from < b.from; });
  const double most = kOverlap * extent;
  for (std::size_t i = 0; i < spans.size(); ++i) {
    for (std::size_t j = i + 1; j < spans.size() && spans[j].from < spans[i].to - most; ++j) {
      if (spans[i].low > spans[j].high - most || spans[j].low > spans[i].high - most) continue;
      const Loop &a = polygons[spans[i].polygon], &b = polygons[spans[j].polygon];
      if (!overlap(points, a, b, most)) continue;
      const Vector3& where = points[a[0]];
      throw SetupError(name, "parts of the surface lie over one another near x " + std::to_string(where.x()) + ", y " +
                                 std::to_string(where.y()),
                       "give what lies above a <collision> of its own");
    }
  }
}

}  // namespace

TriangleMesh surfaceOf(const HeightGrid& grid, const std::string& name) {
  if (grid.rows < 2 || grid.columns < 2) {
    throw SetupError(name, std::to_string(grid.rows) + " × " + std::to_string(grid.columns) + " heights make no surface",
                     "give at least 2 × 2");
  }
  if (!(grid.size.minCoeff() > 0 && grid.size.allFinite())) throw SetupError(name, "size is not > 0", "give size=\"x y\" in metres");
  TriangleMesh mesh;
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.columns; ++c) {
      const double z = grid.heights[static_cast<std::size_t>(r) * grid.columns + c];
      if (!std::isfinite(z)) {
        throw SetupError(name, "height " + std::to_string(c + 1) + " of row " + std::to_string(r + 1) + " is not finite", "correct it");
      }
      mesh.vertices.emplace_back(grid.size.x() * (c / (grid.columns - 1.0) - 0.5), grid.size.y() * (0.5 - r / (grid.rows - 1.0)), z);
    }
  }
  for (int r = 0; r + 1 < grid.rows; ++r) {
    for (int c = 0; c + 1 < grid.columns; ++c) {
      const int above = r * grid.columns + c, below = above + grid.columns;  // at +y, at −y
      mesh.triangles.push_back({below, below + 1, above + 1});
      mesh.triangles.push_back({below, above + 1, above});
    }
  }
  return mesh;
}

std::vector<std::shared_ptr<const ConvexShape>> groundPieces(const TriangleMesh& mesh, double thickness, const std::string& name,
                                                             GroundReport& report) {
  if (!(thickness > 0 && std::isfinite(thickness))) throw SetupError(name, "thickness is not > 0", "give it in metres");
  Surface surface(mesh, name);
  surface.join();
  const std::vector<Loop> polygons = surface.polygons();
  if (polygons.size() > kMostPieces) {
    throw SetupError(name, "is made of " + std::to_string(polygons.size()) + " pieces; " + std::to_string(kMostPieces) + " are allowed",
                     "make the surface coarser, or divide it");
  }
  refuseLayers(mesh.vertices, polygons, name);
  report = {surface.triangles(), static_cast<int>(polygons.size()), INFINITY, -INFINITY, 0};
  for (const Loop& loop : polygons) {
    for (const int v : loop) {
      report.lowest = std::min(report.lowest, mesh.vertices[v].z());
      report.highest = std::max(report.highest, mesh.vertices[v].z());
    }
  }
  report.base = report.lowest - thickness;
  std::vector<std::shared_ptr<const ConvexShape>> pieces;
  for (const Loop& loop : polygons) pieces.push_back(prism(mesh.vertices, loop, report.base, thickness, name));
  return pieces;
}

}  // namespace haptic
