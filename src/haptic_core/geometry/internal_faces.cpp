#include "haptic_core/geometry/internal_faces.h"

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
    for (const auto& face : piece.shape->faces()) {
      Polygon loop;
      for (int h = face.first; h < face.first + face.count; ++h)
        loop.push_back(piece.X_BS * piece.shape->vertices()[piece.shape->loopVertex(h)]);
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

/// Marks the faces of `a` and `b` that share area; true when there are any.
bool markShared(const Placed& a, const Placed& b, double gap, std::vector<std::uint64_t>& hidden_a,
                std::vector<std::uint64_t>& hidden_b) {
  bool any = false;
  const auto mark = [](std::vector<std::uint64_t>& bits, std::size_t faces, std::size_t f) {
    bits.resize((faces + 63) / 64, 0);
    bits[f >> 6] |= std::uint64_t{1} << (f & 63);
  };
  for (std::size_t f = 0; f < a.loops.size(); ++f)
    for (std::size_t g = 0; g < b.loops.size(); ++g) {
      if ((a.normals[f] + b.normals[g]).norm() > kJoint || std::abs(a.offsets[f] + b.offsets[g]) > gap)
        continue;
      const double smaller = std::min(areaOf(a.loops[f], a.normals[f]), areaOf(b.loops[g], b.normals[g]));
      if (areaOf(within(a.loops[f], b.loops[g], b.normals[g]), a.normals[f]) <= kShared * smaller) continue;
      mark(hidden_a, a.loops.size(), f);
      mark(hidden_b, b.loops.size(), g);
      any = true;
    }
  return any;
}

}  // namespace

InternalFaces internalFaces(const std::vector<PlacedPiece>& pieces) {
  std::vector<Placed> placed;
  for (const PlacedPiece& piece : pieces) placed.emplace_back(piece);
  InternalFaces out;
  out.hidden.resize(pieces.size());
  for (std::size_t i = 0; i < placed.size(); ++i)
    for (std::size_t j = i + 1; j < placed.size(); ++j) {
      const double gap = kJoint * std::max(placed[i].size, placed[j].size);
      if (!touching(placed[i], placed[j], gap)) continue;
      if (markShared(placed[i], placed[j], gap, out.hidden[i], out.hidden[j]))
        out.neighbours.emplace_back(static_cast<int>(i), static_cast<int>(j));
    }
  return out;
}

}  // namespace haptic
