/// V's vertices, faces, edges and seam, put together from the clipped edges of both bodies.
#pragma once
#include "haptic_core/geometry/volume/contact_workspace.h"
#include "haptic_core/geometry/volume/edge_clipping.h"

namespace haptic {

/// The part of an edge p → q that lies inside the other body.
struct InnerPart {
  double enter = 0, leave = 1;             ///< in lengths of the edge from p
  int enter_plane = -1, leave_plane = -1;  ///< planes of the other side that cut it there; -1: the edge's own end

  /// Nothing of the edge is inside.
  bool empty() const { return enter_plane >= 0 && leave_plane >= 0 && !(enter < leave); }
};

/// Puts V together from the clipped edges of both bodies.
/// A side knows where its points are and which planes it has: `pointInV(p)`, `faceInV(plane)` (numbers in V, -1: not yet),
/// `point(p)` (fourth lane free) and `face(plane, owner)`. `Seams` keeps the pieces of seam by (plane of A, plane of B).
/// What two sides can give always fits the workspace (ContactWorkspace::reserveResult); pieces are counted by Seams.
template <class Side, class Seams>
class EdgeCollector {
 public:
  /// Starts with an empty V; `w`, `a`, `b` and `seams` must outlive it.
  EdgeCollector(ContactWorkspace& w, Side& a, Side& b, Seams& seams)
      : w_(w), a_(a), b_(b), seams_(seams), vertices_(w.vertices_.begin()->data()), faces_(w.faces_.begin()),
        edges_(w.edges_.begin()) {}

  /// Adds the rest of edge `e` of A (kIsA) or of B, and the ends of seam where it was cut.
  template <bool kIsA>
  void add(const SideEdge& e, const InnerPart& part) {
    const int start = part.enter_plane < 0 ? vertexOf<kIsA>(e.from) : cut<kIsA, true>(e, part.enter, part.enter_plane);
    const int end = part.leave_plane < 0 ? vertexOf<kIsA>(e.to) : cut<kIsA, false>(e, part.leave, part.leave_plane);
    edges_[edge_count_++] = {start, end, faceOf<kIsA>(e.left), faceOf<kIsA>(e.right)};
  }

  /// Adds the seam and hands all over. False when its pieces do not close the surface.
  EdgeClipper::Result close() {
    w_.seam_begin_ = edge_count_;
    int ends = 0;  // negative when one is missing
    for (ContactWorkspace::Seam piece; seams_.next(piece);) {
      ends |= piece.start | piece.end;
      edges_[edge_count_++] = {piece.start, piece.end, faceOf<true>(piece.plane_a), faceOf<false>(piece.plane_b)};
    }
    // Each cut is two ends, each piece has two: as many as places for them, and no place empty, so each was met once.
    const bool closed = seams_.fits() && ends >= 0 && cut_count_ == edge_count_ - w_.seam_begin_;
    w_.vertices_.resize(vertex_count_);
    w_.faces_.resize(face_count_);
    w_.edges_.resize(edge_count_);
    if (edge_count_ == 0) return EdgeClipper::Result::kNothing;
    return closed ? EdgeClipper::Result::kClosed : EdgeClipper::Result::kInconsistent;
  }

 private:
  template <bool kIsA>
  Side& side() { return kIsA ? a_ : b_; }

  int addVertex(const Lanes& x) {
    storeLanes(x, vertices_ + 3 * vertex_count_);  // the fourth lane is the next vertex's, or unused
    return vertex_count_++;
  }

  template <bool kIsA>
  int vertexOf(int point) {
    auto& id = side<kIsA>().pointInV(point);
    if (id < 0) id = addVertex(side<kIsA>().point(point));
    return id;
  }

  /// A new vertex where `plane` cuts the edge. There one piece of seam on that plane starts and one ends, seen along
  /// A's face.
  template <bool kIsA, bool kEntering>
  int cut(const SideEdge& e, double at, int plane) {
    const Lanes p = side<kIsA>().point(e.from), q = side<kIsA>().point(e.to);
    const int vertex = addVertex(p + lanes(at) * (q - p));
    constexpr int kOfLeft = kEntering == kIsA, kOfRight = 1 - kOfLeft;
    seams_.setEnd(kIsA ? e.left : plane, kIsA ? plane : e.left, kOfLeft, vertex);
    seams_.setEnd(kIsA ? e.right : plane, kIsA ? plane : e.right, kOfRight, vertex);
    ++cut_count_;
    return vertex;
  }

  template <bool kIsA>
  int faceOf(int plane) {
    auto& id = side<kIsA>().faceInV(plane);
    if (id < 0) {
      faces_[face_count_] = side<kIsA>().face(plane, kIsA ? Owner::kA : Owner::kB);
      id = face_count_++;
    }
    return id;
  }

  ContactWorkspace& w_;
  Side &a_, &b_;
  Seams& seams_;
  double* const vertices_;
  ContactFace* const faces_;
  ContactEdge* const edges_;
  int vertex_count_ = 0, face_count_ = 0, edge_count_ = 0, cut_count_ = 0;
};

}  // namespace haptic
