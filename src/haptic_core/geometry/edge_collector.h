/// V's vertices, faces, edges and seam, put together from the clipped edges of both bodies.
#pragma once
#include "haptic_core/geometry/contact_workspace.h"
#include "haptic_core/geometry/edge_clipping.h"

namespace haptic {

/// The part of an edge p → q that lies inside the other body.
struct InnerPart {
  double enter = 0, leave = 1;             ///< in lengths of the edge from p
  int enter_plane = -1, leave_plane = -1;  ///< planes of the other side that cut it there; -1: the edge's own end

  bool empty() const { return enter_plane >= 0 && leave_plane >= 0 && !(enter < leave); }
};

/// `Seams` keeps the pieces of seam by (plane of A, plane of B). What two sides can give always fits the workspace
/// (ContactWorkspace::reserveResult); the pieces of seam are counted by Seams.
template <class Seams>
class EdgeCollector {
 public:
  EdgeCollector(ContactWorkspace& w, Seams& seams)
      : w_(w), seams_(seams), vertices_(w.vertices_.begin()), faces_(w.faces_.begin()), edges_(w.edges_.begin()) {}

  /// Adds what is left of edge `e` of A (kIsA) or of B, and the ends of seam where it was cut.
  template <bool kIsA>
  void add(ContactSide& own, const SideEdge& e, const InnerPart& part) {
    const int start = part.enter_plane < 0 ? vertexOf(own, e.from) : cut<kIsA>(own, e, part.enter, part.enter_plane, true);
    const int end = part.leave_plane < 0 ? vertexOf(own, e.to) : cut<kIsA>(own, e, part.leave, part.leave_plane, false);
    edges_[edge_count_++] = {start, end, faceOf<kIsA>(own, e.left), faceOf<kIsA>(own, e.right)};
  }

  /// Adds the seam and hands all over. False when its pieces do not close the surface.
  EdgeClipper::Result close() {
    w_.seam_begin_ = edge_count_;
    for (ContactWorkspace::Seam piece; seams_.next(piece);) {
      closed_ &= (piece.start >= 0) & (piece.end >= 0);
      edges_[edge_count_++] = {piece.start, piece.end, faceOf<true>(w_.side_a_, piece.plane_a),
                               faceOf<false>(w_.side_b_, piece.plane_b)};
    }
    w_.vertices_.resize(vertex_count_);
    w_.faces_.resize(face_count_);
    w_.edges_.resize(edge_count_);
    if (edge_count_ == 0) return EdgeClipper::Result::kNothing;
    return closed_ ? EdgeClipper::Result::kClosed : EdgeClipper::Result::kInconsistent;
  }

 private:
  int vertexOf(ContactSide& side, int point) {
    int& id = side.point_in_v[point];
    if (id < 0) {
      id = vertex_count_++;
      vertices_[id] = side.points[point];
    }
    return id;
  }

  /// A new vertex where `plane` cuts the edge. There one piece of seam on that plane starts and one ends, seen along
  /// A's face.
  template <bool kIsA>
  int cut(const ContactSide& own, const SideEdge& e, double at, int plane, bool entering) {
    const Vector3 &p = own.points[e.from], &q = own.points[e.to];
    const int vertex = vertex_count_++;
    vertices_[vertex] = p + at * (q - p);
    const int of_left = entering == kIsA, of_right = 1 - of_left;
    closed_ &= kIsA ? seams_.setEnd(e.left, plane, of_left, vertex) : seams_.setEnd(plane, e.left, of_left, vertex);
    closed_ &= kIsA ? seams_.setEnd(e.right, plane, of_right, vertex) : seams_.setEnd(plane, e.right, of_right, vertex);
    return vertex;
  }

  template <bool kIsA>
  int faceOf(ContactSide& side, int plane) {
    const int id = side.face_in_v[plane];
    return id >= 0 ? id : addFace(side, plane, kIsA ? Owner::kA : Owner::kB);
  }

  int addFace(ContactSide& side, int plane, Owner owner) {
    const PlaneGroup& group = side.planes[plane >> 2];
    const int i = plane & 3;
    faces_[face_count_] = {Vector3(group.nx[i], group.ny[i], group.nz[i]), group.offset[i], side.faces[plane], owner};
    return side.face_in_v[plane] = face_count_++;
  }

  ContactWorkspace& w_;
  Seams& seams_;
  Vector3* const vertices_;
  ContactFace* const faces_;
  ContactEdge* const edges_;
  int vertex_count_ = 0, face_count_ = 0, edge_count_ = 0;
  bool closed_ = true;  ///< so far every end of seam was met once
};

}  // namespace haptic
