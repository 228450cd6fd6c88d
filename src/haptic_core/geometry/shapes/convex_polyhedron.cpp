#include "haptic_core/geometry/shapes/convex_polyhedron.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "haptic_core/base/error.h"

namespace haptic {
namespace {

std::string faceName(std::size_t f) {
  return "face " + std::to_string(f);
}

/// In the very order of `makeBox`, which the box path relies on.
bool isCentredBox(const std::vector<Vector3>& vertices, const std::vector<ConvexPolyhedron::Face>& faces,
                  const ConvexPolyhedron::Box& box) {
  if (vertices.size() != 8 || faces.size() != 6 || box.lower != -box.upper) return false;
  for (int i = 0; i < 8; ++i)
    for (int axis = 0; axis < 3; ++axis)
      if (vertices[i][axis] != (i >> axis & 1 ? box.upper[axis] : box.lower[axis])) return false;
  for (int f = 0; f < 6; ++f)
    if (faces[f].normal != Vector3((f & 1 ? 1.0 : -1.0) * Vector3::Unit(f / 2))) return false;
  return true;
}

}  // namespace

ConvexPolyhedron::ConvexPolyhedron(std::vector<Vector3> vertices, const std::vector<std::vector<int>>& faces,
                                   const std::string& name)
    : ConvexShape(ShapeKind::kPolyhedron, name), vertices_(std::move(vertices)) {
  checkInput(faces);
  for (const auto& loop : faces) {
    faces_.push_back({Vector3::Zero(), 0.0, static_cast<int>(loop_.size()), static_cast<int>(loop.size())});
    loop_.insert(loop_.end(), loop.begin(), loop.end());
    half_edge_face_.insert(half_edge_face_.end(), loop.size(), static_cast<int>(faces_.size()) - 1);
  }
  pairHalfEdges();
  properties_ = haptic::massProperties(triangles(), 1.0);
  if (!std::isfinite(properties_.volume))
    throw SetupError(name_, "the volume overflows", "give coordinates in metres");
  if (!(std::abs(properties_.volume) > 0))
    throw SetupError(name_, "the volume is zero", "give vertices that do not lie in one plane");
  if (properties_.volume < 0)
    throw SetupError(name_, "face 0 and all others point inwards (negative volume)",
                     "list each face's vertices counter-clockwise seen from outside");
  aabb_ = {vertices_[0], vertices_[0]};
  for (const Vector3& v : vertices_) {
    radius_ = std::max(radius_, (v - centre()).norm());
    aabb_.lower = aabb_.lower.cwiseMin(v);
    aabb_.upper = aabb_.upper.cwiseMax(v);
  }
  setPlanes();
  checkConvex();
  listNeighbours();
  is_box_ = isCentredBox(vertices_, faces_, aabb_);
}

void ConvexPolyhedron::checkInput(const std::vector<std::vector<int>>& faces) const {
  if (vertices_.size() < 4)
    throw SetupError(name_, std::to_string(vertices_.size()) + " vertices make no solid", "give at least 4");
  for (std::size_t i = 0; i < vertices_.size(); ++i)
    if (!vertices_[i].allFinite())
      throw SetupError(name_, "vertex " + std::to_string(i) + " is not finite", "correct its coordinates");
  std::vector<char> used(vertices_.size(), 0);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (faces[f].size() < 3)
      throw SetupError(name_, faceName(f) + " has fewer than 3 vertices", "remove it or complete its loop");
    for (int v : faces[f]) {
      if (v < 0 || v >= vertexCount())
        throw SetupError(name_, faceName(f) + " names vertex " + std::to_string(v) + ", which does not exist",
                         "use indices 0 to " + std::to_string(vertexCount() - 1));
      used[v] = 1;
    }
  }
  for (std::size_t i = 0; i < used.size(); ++i)
    if (!used[i])
      throw SetupError(name_, "no face uses vertex " + std::to_string(i), "remove it, or use hull()");
}

void ConvexPolyhedron::pairHalfEdges() {
  std::map<std::pair<int, int>, int> half_edge_of;
  twin_.assign(loop_.size(), -1);
  half_edge_edge_.assign(loop_.size(), -1);
  const auto end_of = [this](int h) {
    const Face& f = faces_[half_edge_face_[h]];
    return loop_[h + 1 < f.first + f.count ? h + 1 : f.first];
  };
  for (int h = 0; h < static_cast<int>(loop_.size()); ++h)
    if (loop_[h] == end_of(h) || !half_edge_of.emplace(std::make_pair(loop_[h], end_of(h)), h).second)
      throw SetupError(name_,
                       faceName(half_edge_face_[h]) + " repeats the edge " + std::to_string(loop_[h]) +
                           " → " + std::to_string(end_of(h)),
                       "orient all faces outward and list each vertex once per face");
  for (int h = 0; h < static_cast<int>(loop_.size()); ++h) {
    const auto found = half_edge_of.find({end_of(h), loop_[h]});
    if (found == half_edge_of.end())
      throw SetupError(name_,
                       "not closed: edge " + std::to_string(loop_[h]) + " – " + std::to_string(end_of(h)) +
                           " of " + faceName(half_edge_face_[h]) + " has no neighbour",
                       "add the missing face, or use hull()");
    twin_[h] = found->second;
    if (loop_[h] < end_of(h)) {
      half_edge_edge_[h] = half_edge_edge_[twin_[h]] = edgeCount();
      edges_.push_back({loop_[h], end_of(h), half_edge_face_[h], half_edge_face_[twin_[h]]});
    }
  }
  if (vertexCount() - edgeCount() + faceCount() != 2)
    throw SetupError(name_,
                     "the faces do not form one closed surface (Euler number " +
                         std::to_string(vertexCount() - edgeCount() + faceCount()) + ", not 2)",
                     "make each connected part a shape of its own");
}

void ConvexPolyhedron::setPlanes() {
  for (Face& face : faces_) {
    // Newell's sum about a vertex of the loop: the area vector whatever the loop's slight warp.
    const Vector3 o = vertices_[loop_[face.first]];
    Vector3 area = Vector3::Zero();
    for (int i = 1; i + 1 < face.count; ++i)
      area += (vertices_[loop_[face.first + i]] - o).cross(vertices_[loop_[face.first + i + 1]] - o);
    const double length = area.norm();
    if (!(length > 0))
      throw SetupError(name_, faceName(&face - faces_.data()) + " has no area", "remove it, or use hull()");
    face.normal = area / length;
    double sum = 0;
    for (int i = 0; i < face.count; ++i) sum += face.normal.dot(vertices_[loop_[face.first + i]]);
    face.offset = sum / face.count;
  }
}

void ConvexPolyhedron::checkConvex() const {
  const double tolerance = kFlatness * std::max(radius_, std::max(aabb_.lower.norm(), aabb_.upper.norm()));
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const Face& face = faces_[f];
    for (int i = 0; i < face.count; ++i)
      if (std::abs(face.normal.dot(vertices_[loop_[face.first + i]]) - face.offset) > tolerance)
        throw SetupError(name_,
                         faceName(f) + " is not planar at vertex " + std::to_string(loop_[face.first + i]),
                         "split it into triangles, or use hull()");
    for (int v = 0; v < vertexCount(); ++v)
      if (face.normal.dot(vertices_[v]) - face.offset > tolerance)
        throw SetupError(name_, "not convex: vertex " + std::to_string(v) + " lies outside " + faceName(f),
                         "use hull(), or split the body into convex pieces");
  }
}

void ConvexPolyhedron::listNeighbours() {
  neighbour_begin_.assign(vertexCount() + 1, 0);
  for (int v : loop_) ++neighbour_begin_[v + 1];
  for (int v = 0; v < vertexCount(); ++v) neighbour_begin_[v + 1] += neighbour_begin_[v];
  neighbours_.resize(loop_.size());
  outgoing_.resize(loop_.size());
  std::vector<int> filled(neighbour_begin_.begin(), neighbour_begin_.end() - 1);
  for (int h = 0; h < static_cast<int>(loop_.size()); ++h) {
    const int slot = filled[loop_[h]]++;
    neighbours_[slot] = loop_[twin_[h]];
    outgoing_[slot] = h;
  }
}

ConvexPolyhedron::Box ConvexPolyhedron::aabb(const Pose& X_WS) const {
  const Vector3 middle = X_WS * (0.5 * (aabb_.lower + aabb_.upper));
  const Vector3 half = X_WS.R.cwiseAbs() * (0.5 * (aabb_.upper - aabb_.lower));
  return {middle - half, middle + half};
}

double ConvexPolyhedron::surface() const {
  double twice = 0;
  for (const Face& f : faces_) {
    const Vector3& a = vertices_[loop_[f.first]];
    for (int i = 1; i + 1 < f.count; ++i) {
      const Vector3 &b = vertices_[loop_[f.first + i]], &c = vertices_[loop_[f.first + i + 1]];
      twice += (b - a).cross(c - a).norm();
    }
  }
  return 0.5 * twice;
}

double ConvexPolyhedron::leastWidth() const {
  double least = 2 * boundingRadius();
  for (const Face& face : faces_) {
    double lowest = INFINITY, highest = -INFINITY;
    for (const Vector3& vertex : vertices_) {
      const double z = face.normal.dot(vertex);
      lowest = std::min(lowest, z);
      highest = std::max(highest, z);
    }
    least = std::min(least, highest - lowest);
  }
  return least;
}

std::vector<Vector3> ConvexPolyhedron::sides() const {
  std::vector<Vector3> normals;
  for (const Face& face : faces_) normals.push_back(face.normal);
  return normals;
}

void ConvexPolyhedron::eachNumber(NumberVisitor& visitor) const {
  for (const Vector3& vertex : vertices_) visitor.visit(vertex.x()), visitor.visit(vertex.y()), visitor.visit(vertex.z());
  for (const Face& face : faces_) visitor.visit(face.count);
}

TriangleMesh ConvexPolyhedron::triangles() const {
  TriangleMesh mesh;
  mesh.vertices = vertices_;
  for (const Face& f : faces_)
    for (int i = 1; i + 1 < f.count; ++i)
      mesh.triangles.push_back({loop_[f.first], loop_[f.first + i], loop_[f.first + i + 1]});
  return mesh;
}

int ConvexPolyhedron::support(const Vector3& direction, int hint) const noexcept {
  int best = hint >= 0 && hint < vertexCount() ? hint : 0;
  double height = direction.dot(vertices_[best]);
  for (bool climbing = true; climbing;) {
    climbing = false;
    for (int i = neighbour_begin_[best], end = neighbour_begin_[best + 1]; i < end; ++i) {
      const double candidate = direction.dot(vertices_[neighbours_[i]]);
      if (candidate > height) {
        height = candidate;
        best = neighbours_[i];
        climbing = true;
        break;
      }
    }
  }
  return best;
}

}  // namespace haptic
