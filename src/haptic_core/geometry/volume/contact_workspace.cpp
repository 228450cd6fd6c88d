#include "haptic_core/geometry/shapes/half_space.h"
#include "haptic_core/geometry/shapes/rod.h"
#include "haptic_core/geometry/volume/contact_workspace.h"

#include <algorithm>

namespace haptic {

void PairTable::clear() noexcept {
  if (++epoch_ != 0) return;
  for (Slot& slot : slots_) slot.epoch = 0;  // once in 2³² uses, lest an old mark look new
  epoch_ = 1;
}

void ContactSide::reserve(int vertices, int face_count) {
  points.reserve(vertices + 1);
  cap.reserve(vertices);
  point_in_v.reserve(vertices);
  vertex_stamp.reserve(vertices);
  edges.reserve(vertices + face_count);
  planes.reserve((face_count + 3) / 4);
  faces.reserve(face_count);
  face_in_v.reserve(face_count);
  face_stamp.reserve(face_count);
}

void PairTable::reserve(int entries) {
  // At most half full, so that a search ends after about 1.5 probes.
  std::size_t size = 16;
  while (size < 2 * static_cast<std::size_t>(entries)) size *= 2;
  if (size > slots_.size()) slots_.assign(size, Slot{0, 0, -1});
}

int* PairTable::find(int a, int b) noexcept {
  const std::uint64_t key =
      static_cast<std::uint64_t>(static_cast<std::uint32_t>(a)) << 32 | static_cast<std::uint32_t>(b);
  const std::size_t mask = slots_.size() - 1;
  std::size_t i = (key * 0x9E3779B97F4A7C15ull >> 32) & mask;
  for (std::size_t probes = 0; probes <= mask; ++probes, i = (i + 1) & mask) {
    Slot& slot = slots_[i];
    if (slot.epoch != epoch_) {
      slot = {key, epoch_, -1};
      return &slot.value;
    }
    if (slot.key == key) return &slot.value;
  }
  return nullptr;
}

void ContactWorkspace::reserve(KeptVolume& kept) const {
  kept.vertices = vertices_, kept.faces = faces_, kept.edges = edges_, kept.round = round_;
}

void ContactWorkspace::exchange(KeptVolume& kept) noexcept {
  vertices_.swap(kept.vertices);
  faces_.swap(kept.faces);
  edges_.swap(kept.edges);
  std::swap(seam_begin_, kept.seam_begin);
  if (round_.filled || kept.round.filled) std::swap(round_, kept.round);
}

void ContactWorkspace::clear() noexcept {
  vertices_.clear();
  faces_.clear();
  edges_.clear();
  loops_.clear();
  loop_vertices_.clear();
  seam_begin_ = 0;
  round_.filled = false;
  dropped_ = 0;
}

void ContactWorkspace::reserve(const ConvexPolyhedron& A, const ConvexPolyhedron& B) {
  // Either shape may come as A or as B.
  reserveSides(std::max(A.vertexCount(), B.vertexCount()), std::max(A.faceCount(), B.faceCount()));
  reserveResult(A.faceCount() + B.faceCount());
}

void ContactWorkspace::reserveRound(const ConvexShape& other) {
  round_.reserve(other.faceCount(), 2 * other.edgeCount());
  faces_.reserve(other.faceCount() + 3);
}

void ContactWorkspace::reserveCut(const ConvexShape& shape, int planes) {
  reserveRound(shape);
  reserveResult(shape.faceCount() + planes);
}

void ContactWorkspace::reserveRod(const ConvexShape& other) {
  reserveRound(other);
  // A box around a rod, cut by the faces: at most six half edges for each of its own.
  constexpr int kBox = 6;
  const int faces = other.faceCount() + kBox;
  round_.reserve(faces, 6 * faces);
  reserveResult(faces);
}

void ContactWorkspace::reserve(int face_count) {
  // The other shape has at least 4 faces; a polyhedron with F faces has at most 2F - 4 vertices.
  reserveSides(2 * face_count, face_count);
  reserveResult(face_count);
}

void ContactWorkspace::reserveSides(int vertices, int faces) {
  for (ContactSide* side : {&side_a_, &side_b_}) side->reserve(vertices, faces);
  for (ContactSide* side : {&side_a_, &side_b_})
    side->codes.reserve(side->cap.capacity() * ((side->faces.capacity() + 63) / 64));
}

bool ContactWorkspace::fits(const ConvexPolyhedron& A, const ConvexPolyhedron& B) const {
  return std::max(A.vertexCount(), B.vertexCount()) <= side_a_.cap.capacity() &&
         std::max(A.faceCount(), B.faceCount()) <= side_a_.faces.capacity() &&
         A.faceCount() + B.faceCount() + 3 < faces_.capacity();
}

void ContactWorkspace::reserveResult(int face_count) {
  // V has at most one face per face of A and B. A polyhedron with F faces has ≤ 2F - 4 vertices and ≤ 3F - 6
  // edges; rounding can split a face of a degenerate cut in two, for which there is half as much again.
  const int faces = face_count + face_count / 2 + 16, vertices = 2 * faces, edges = 3 * faces;
  // Before it is seen whether V's edges close, each edge of the sides may have given two cuts.
  const int found = vertices + 2 * edges;
  vertices_.reserve(found + 4);
  turned_.reserve(found + 3);
  seams_.reserve(edges);
  feet_.reserve(faces + 3);
  edge_areas_.reserve(2 * edges + 3);
  face_areas_.reserve(faces + 3);
  faces_.reserve(faces + 3);
  edges_.reserve(2 * edges);
  loops_.reserve(faces);
  loop_vertices_.reserve(2 * edges);
  next_edge_.reserve(2 * edges);
  for (CutSolid* s : {&solid_, &cut_}) {
    s->points.reserve(vertices);
    s->faces.reserve(faces);
    s->loop.reserve(2 * edges);
  }
  height_.reserve(found);
  moved_to_.reserve(vertices);
  cap_next_.reserve(vertices);
  pairs_.reserve(2 * edges);
  patch_points_.reserve(found);
  leave_.reserve(faces);
  centres_.reserve(faces);
  return_.reserve(faces);
  shadows_.reserve(faces + 3);
  loads_.reserve(faces + 3);
  away_.reserve(found);
  shadow_edges_.reserve(4 * edges);
  polygon_.reserve(2 * edges);
  outline_.reserve(2 * edges);  // a face's own corners, and one more for each edge of a cover
  cut_outline_.reserve(2 * edges);
  clipped_.reserve(2 * edges);
}

const LoadedVector<Vector3>& ContactWorkspace::faceCentres() noexcept {
  centres_.clear();
  height_.clear();
  for (int f = 0; f < faces_.size(); ++f) {
    centres_.push_back(Vector3::Zero());
    height_.push_back(0);
  }
  for (const ContactEdge& e : edges_) {
    for (const int f : {e.left, e.right}) {
      centres_[f] += 0.5 * (vertices_[e.from] + vertices_[e.to]);
      height_[f] += 1;
    }
  }
  for (int f = 0; f < faces_.size(); ++f) centres_[f] /= height_[f];
  return centres_;
}

void ContactWorkspace::buildLoopsOf(int face) noexcept {
  loops_.clear();
  loop_vertices_.clear();
  next_edge_.clear();  // the face's half edges that are in no loop yet: 2e runs along edge e, 2e + 1 against it
  for (int e = 0; e < edges_.size(); ++e) {
    if (edges_[e].left == face) next_edge_.push_back(2 * e);
    if (edges_[e].right == face) next_edge_.push_back(2 * e + 1);
  }
  const auto start = [this](int h) { return h & 1 ? edges_[h / 2].to : edges_[h / 2].from; };
  const auto end = [this](int h) { return h & 1 ? edges_[h / 2].from : edges_[h / 2].to; };
  while (!next_edge_.empty()) {
    ContactLoop loop{face, loop_vertices_.size(), 0};
    int next = 0;
    do {
      const int h = next_edge_[next];
      loop_vertices_.push_back(start(h));
      next_edge_[next] = next_edge_[next_edge_.size() - 1];
      next_edge_.resize(next_edge_.size() - 1);
      next = 0;
      while (next < next_edge_.size() && start(next_edge_[next]) != end(h)) ++next;
    } while (next < next_edge_.size());
    loop.count = loop_vertices_.size() - loop.first;
    if (loop.count >= 3) loops_.push_back(loop);
  }
}

void ContactWorkspace::buildLoops() noexcept {
  loops_.clear();
  loop_vertices_.clear();
  // Half edges 2e (in `left`) and 2e + 1 (in `right`), found by (face, start vertex).
  pairs_.clear();
  next_edge_.clear();
  for (int e = 0; e < edges_.size(); ++e) {
    const ContactEdge& edge = edges_[e];
    *pairs_.find(edge.left, edge.from) = 2 * e;
    *pairs_.find(edge.right, edge.to) = 2 * e + 1;
    next_edge_.push_back(0);
    next_edge_.push_back(0);
  }
  for (int start = 0; start < 2 * edges_.size(); ++start) {
    if (next_edge_[start]) continue;
    const int face = start & 1 ? edges_[start / 2].right : edges_[start / 2].left;
    ContactLoop loop{face, loop_vertices_.size(), 0};
    for (int h = start; h >= 0 && !next_edge_[h];) {
      next_edge_[h] = 1;
      const ContactEdge& edge = edges_[h / 2];
      loop_vertices_.push_back(h & 1 ? edge.to : edge.from);
      h = *pairs_.find(face, h & 1 ? edge.from : edge.to);
    }
    loop.count = loop_vertices_.size() - loop.first;
    if (loop.count >= 3) loops_.push_back(loop);
  }
}

}  // namespace haptic
