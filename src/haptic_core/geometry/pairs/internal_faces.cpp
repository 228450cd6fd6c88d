#include "haptic_core/geometry/pairs/internal_faces.h"

#include <algorithm>
#include <cmath>

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

  explicit Placed(const PlacedPiece& piece)
      : box(piece.shape->aabb(piece.X_BS)), size(piece.shape->boundingRadius()) {
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

bool touching(const Placed& a, const Placed& b, double gap) {
  return (a.box.lower.array() - gap <= b.box.upper.array()).all() &&
         (b.box.lower.array() - gap <= a.box.upper.array()).all();
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

/// A part of a piece's face that a neighbour covers; `polygon` lies in the body's frame.
void addCover(const PlacedPiece& piece, std::size_t faces, std::size_t face, Polygon polygon, InnerFaces& inner) {
  inner.bits.resize((faces + 63) / 64, 0);
  inner.bits[face >> 6] |= std::uint64_t{1} << (face & 63);
  for (Vector3& p : polygon) p = piece.X_BS.R.transpose() * (p - piece.X_BS.p);
  inner.covers.push_back({static_cast<int>(face), std::move(polygon)});
}

/// Covers of two pieces by one another; true when there are any.
bool coverShared(const Placed& a, const Placed& b, double gap, const PlacedPiece& piece_a, const PlacedPiece& piece_b,
                 InnerFaces& inner_a, InnerFaces& inner_b) {
  bool any = false;
  for (std::size_t f = 0; f < a.loops.size(); ++f)
    for (std::size_t g = 0; g < b.loops.size(); ++g) {
      if ((a.normals[f] + b.normals[g]).norm() > kJoint || std::abs(a.offsets[f] + b.offsets[g]) > gap)
        continue;
      const double smaller = std::min(areaOf(a.loops[f], a.normals[f]), areaOf(b.loops[g], b.normals[g]));
      Polygon shared = within(a.loops[f], b.loops[g], b.normals[g]);
      if (areaOf(shared, a.normals[f]) <= kShared * smaller) continue;
      addCover(piece_a, a.loops.size(), f, shared, inner_a);
      std::reverse(shared.begin(), shared.end());
      addCover(piece_b, b.loops.size(), g, shared, inner_b);
      any = true;
    }
  return any;
}

/// Gives faces of two neighbours that lie in one plane and look the same way one number.
void joinSurfaces(const Placed& a, const Placed& b, double gap, int& count, std::vector<std::vector<int>>& surface, int i,
                  int j) {
  for (std::size_t f = 0; f < a.loops.size(); ++f)
    for (std::size_t g = 0; g < b.loops.size(); ++g) {
      if ((a.normals[f] - b.normals[g]).norm() > kJoint || std::abs(a.offsets[f] - b.offsets[g]) > gap) continue;
      surface[i].resize(a.loops.size(), -1);
      surface[j].resize(b.loops.size(), -1);
      int &x = surface[i][f], &y = surface[j][g];
      if (x < 0) x = count++;
      const int from = y, to = x;
      y = to;
      if (from < 0 || from == to) continue;
      for (std::vector<int>& faces : surface)
        for (int& number : faces) number = number == from ? to : number;
    }
}

}  // namespace

InternalFaces internalFaces(const std::vector<PlacedPiece>& pieces) {
  std::vector<Placed> placed;
  for (const PlacedPiece& piece : pieces) placed.emplace_back(piece);
  InternalFaces out;
  out.inner.resize(pieces.size());
  out.surface.resize(pieces.size());
  int surfaces = 0;
  for (std::size_t i = 0; i < placed.size(); ++i)
    for (std::size_t j = i + 1; j < placed.size(); ++j) {
      const double gap = kJoint * std::max(placed[i].size, placed[j].size);
      if (!touching(placed[i], placed[j], gap) ||
          !coverShared(placed[i], placed[j], gap, pieces[i], pieces[j], out.inner[i], out.inner[j]))
        continue;
      const int a = static_cast<int>(i), b = static_cast<int>(j);
      joinSurfaces(placed[i], placed[j], gap, surfaces, out.surface, a, b);
      out.neighbours.emplace_back(a, b);
    }
  return out;
}

}  // namespace haptic
