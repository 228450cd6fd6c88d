#include "haptic_core/geometry/pairs/internal_faces.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/disjoint_sets.h"
#include "haptic_core/geometry/search/box_tree.h"

namespace haptic {
namespace {

using Polygon = std::vector<Vector3>;

/// Piece in the body's frame.
struct Placed {
  std::vector<Polygon> loops;
  std::vector<Vector3> normals;
  std::vector<double> offsets;
  ConvexPolyhedron::Box box;
  double size;
  double seam;  ///< widest gap to a neighbour [m]

  explicit Placed(const PlacedPiece& piece)
      : box(piece.shape->aabb(piece.X_BS)), size(piece.shape->boundingRadius()),
        seam(std::max(kJoint * size, kSeam * std::min(size, piece.shape->leastWidth()))) {
    const ConvexPolyhedron* hull = piece.shape->polyhedron();
    if (!hull) return;
    for (const auto& face : hull->faces()) {
      Polygon loop;
      for (int h = face.first; h < face.first + face.count; ++h)
        loop.push_back(piece.X_BS * hull->vertices()[hull->loopVertex(h)]);
      normals.push_back(piece.X_BS.R * face.normal);
      offsets.push_back(face.offset + normals.back().dot(piece.X_BS.p));
      loops.push_back(std::move(loop));
    }
  }
};

ConvexPolyhedron::Box widened(const ConvexPolyhedron::Box& box, double by) {
  return {box.lower.array() - by, box.upper.array() + by};
}

/// For each piece those after it whose boxes come as near as seams are wide, ascending.
std::vector<std::vector<int>> touching(const std::vector<Placed>& placed) {
  std::vector<ConvexPolyhedron::Box> boxes;
  for (const Placed& piece : placed) boxes.push_back(widened(piece.box, std::isfinite(piece.seam) ? piece.seam : 0));
  const BoxTree tree(boxes);
  std::vector<std::vector<int>> near(placed.size());
  for (std::size_t i = 0; i < placed.size(); ++i) {
    tree.eachOverlap(boxes[i], [&](int j) {
      if (j > static_cast<int>(i)) near[i].push_back(j);
    });
    std::sort(near[i].begin(), near[i].end());
  }
  return near;
}

double areaOf(const Polygon& polygon, const Vector3& n) {
  double twice = 0;
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    twice += n.dot((polygon[i] - polygon[0]).cross(polygon[i + 1] - polygon[0]));
  return 0.5 * twice;
}

/// The part of `polygon` within `other`, both in one plane; `other` runs counter-clockwise about `n`.
Polygon within(Polygon polygon, const Polygon& other, const Vector3& n) {
  for (std::size_t k = 0; k < other.size() && polygon.size() >= 3; ++k) {
    const Vector3 inward = n.cross(other[(k + 1) % other.size()] - other[k]);
    Polygon kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vector3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double hp = inward.dot(p - other[k]), hq = inward.dot(q - other[k]);
      if (hp >= 0) kept.push_back(p);
      if ((hp >= 0) != (hq >= 0)) kept.push_back(p + hp / (hp - hq) * (q - p));
    }
    polygon.swap(kept);
  }
  return polygon;
}

/// Without corners that lie within `gap` of the one before: clipping along an edge leaves some at roundings of one another, and the
/// direction of an edge between them is none.
Polygon withoutDoubles(const Polygon& polygon, double gap) {
  Polygon out;
  for (const Vector3& p : polygon) {
    if (out.empty() || (p - out.back()).norm() > gap) out.push_back(p);
  }
  while (out.size() > 1 && (out.back() - out.front()).norm() <= gap) out.pop_back();
  return out;
}

/// A part of a piece's face that a neighbour covers; `polygon` lies in the body's frame.
void addCover(const PlacedPiece& piece, std::size_t faces, std::size_t face, Polygon polygon, double gap, InnerFaces& inner) {
  inner.bits.resize((faces + 63) / 64, 0);
  inner.bits[face >> 6] |= std::uint64_t{1} << (face & 63);
  for (Vector3& p : polygon) p = piece.X_BS.R.transpose() * (p - piece.X_BS.p);
  inner.covers.push_back({static_cast<int>(face), std::move(polygon), gap});
}

/// Covers of two pieces by one another; true when there are any. `none`: a gap that is rounding.
bool coverShared(const Placed& a, const Placed& b, double none, const PlacedPiece& piece_a, const PlacedPiece& piece_b,
                 InnerFaces& inner_a, InnerFaces& inner_b) {
  bool any = false;
  for (std::size_t f = 0; f < a.loops.size(); ++f)
    for (std::size_t g = 0; g < b.loops.size(); ++g) {
      const double tilt = (a.normals[f] + b.normals[g]).norm(), most = std::max(none, std::min(a.seam, b.seam));
      const auto over = [&](const Vector3& p) { return std::abs(b.normals[g].dot(p) - b.offsets[g]); };  // of a point of face f
      if (tilt > kSeam || over(a.loops[f][0]) > most + 2 * tilt * a.size) continue;
      const double smaller = std::min(areaOf(a.loops[f], a.normals[f]), areaOf(b.loops[g], b.normals[g]));
      Polygon shared = withoutDoubles(within(a.loops[f], b.loops[g], b.normals[g]), none);
      if (areaOf(shared, a.normals[f]) <= kShared * smaller) continue;
      double gap = 0;
      for (const Vector3& p : shared) gap = std::max(gap, over(p));
      if (gap > most) continue;
      const double felt = gap > none ? gap : 0;
      addCover(piece_a, a.loops.size(), f, shared, felt, inner_a);
      std::reverse(shared.begin(), shared.end());
      addCover(piece_b, b.loops.size(), g, shared, felt, inner_b);
      any = true;
    }
  return any;
}

/// Faces of all pieces in one row, and which of them continue one another.
class Surfaces {
 public:
  explicit Surfaces(const std::vector<Placed>& placed) : first_{0} {
    for (const Placed& piece : placed) first_.push_back(first_.back() + static_cast<int>(piece.loops.size()));
    joined_ = DisjointSets(first_.back());
    goes_on_.resize(first_.back(), 0);
  }
  /// Joins faces of two neighbours that lie in one plane and look the same way.
  void join(const std::vector<Placed>& placed, double gap, int i, int j) {
    const Placed &a = placed[i], &b = placed[j];
    for (std::size_t f = 0; f < a.loops.size(); ++f)
      for (std::size_t g = 0; g < b.loops.size(); ++g) {
        if ((a.normals[f] - b.normals[g]).norm() > kJoint || std::abs(a.offsets[f] - b.offsets[g]) > gap) continue;
        const int x = first_[i] + static_cast<int>(f), y = first_[j] + static_cast<int>(g);
        goes_on_[x] = goes_on_[y] = 1;
        joined_.mergeInto(x, y);
      }
  }
  std::vector<std::vector<int>> numbers(const std::vector<std::pair<int, int>>& neighbours);

 private:
  std::vector<int> first_;     ///< by piece, with the end of the last
  DisjointSets joined_;        ///< of faces
  std::vector<char> goes_on_;  ///< a neighbour continues it
};

/// The least number that no surface has that a piece with this one meets, on itself or on a neighbour.
std::vector<std::vector<int>> Surfaces::numbers(const std::vector<std::pair<int, int>>& neighbours) {
  const int pieces = static_cast<int>(first_.size()) - 1, faces = first_.back();
  std::vector<std::vector<int>> meets(pieces), surface(pieces), pieces_of(faces);
  for (const auto& [i, j] : neighbours) meets[i].push_back(j), meets[j].push_back(i);
  for (int i = 0; i < pieces; ++i) {
    for (int face = first_[i]; face < first_[i + 1]; ++face) {
      if (!goes_on_[face]) continue;
      surface[i].resize(first_[i + 1] - first_[i], -1);
      pieces_of[joined_.root(face)].push_back(i);
    }
  }
  std::vector<int> number(faces, -1), taken_by;
  const auto take = [&](int piece, int root) {
    for (int face = first_[piece]; face < first_[piece + 1]; ++face) {
      const int taken = goes_on_[face] ? number[joined_.root(face)] : -1;
      if (taken < 0) continue;
      if (taken >= static_cast<int>(taken_by.size())) taken_by.resize(taken + 1, -1);
      taken_by[taken] = root;
    }
  };
  for (int root = 0; root < faces; ++root) {
    if (pieces_of[root].empty()) continue;
    for (const int piece : pieces_of[root]) {
      take(piece, root);
      for (const int other : meets[piece]) take(other, root);
    }
    int& own = number[root];
    for (own = 0; own < static_cast<int>(taken_by.size()) && taken_by[own] == root;) ++own;
  }
  for (int i = 0; i < pieces; ++i) {
    for (int face = first_[i]; face < first_[i + 1]; ++face) {
      if (goes_on_[face]) surface[i][face - first_[i]] = number[joined_.root(face)];
    }
  }
  return surface;
}

}  // namespace

InternalFaces internalFaces(const std::vector<PlacedPiece>& pieces) {
  std::vector<Placed> placed;
  placed.reserve(pieces.size());
  for (const PlacedPiece& piece : pieces) placed.emplace_back(piece);
  InternalFaces out;
  out.inner.resize(pieces.size());
  Surfaces surfaces(placed);
  const std::vector<std::vector<int>> near = touching(placed);
  for (std::size_t i = 0; i < placed.size(); ++i)
    for (const int j : near[i]) {
      const double gap = kJoint * std::max(placed[i].size, placed[j].size);
      if (!coverShared(placed[i], placed[j], gap, pieces[i], pieces[j], out.inner[i], out.inner[j])) continue;
      surfaces.join(placed, gap, static_cast<int>(i), j);
      out.neighbours.emplace_back(static_cast<int>(i), j);
    }
  out.surface = surfaces.numbers(out.neighbours);
  return out;
}

}  // namespace haptic
