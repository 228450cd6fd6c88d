// V starts as A and is cut by the half space of every face of B in turn. A cut keeps each face's vertices
// below the plane and puts a new vertex where its loop leaves the half space and where it comes back; leaving
// and coming back on the same edge of two neighbouring faces is the same new vertex. In each face a new edge
// runs from the point of leaving to the point of return; taken backwards, those edges chain into the loop of
// the new face. Every new vertex is left once and returned to once, so the chains close whatever signs
// rounding gave the heights: the surface stays closed, no case needs repair, and its volume is wrong by no
// more than the heights are. (Sutherland & Hodgman 1974 for one face.)
#include "haptic_core/geometry/volume/volume_cutting.h"

#include <algorithm>

namespace haptic {

class VolumeCutter {
 public:
  explicit VolumeCutter(ContactWorkspace& workspace) : w_(workspace) {}

  void start(const ConvexPolyhedron& shape, const Pose& X_AS, Owner owner) {
    clear(w_.solid_);
    for (const Vector3& v : shape.vertices()) keep(w_.solid_.points.push_back(X_AS * v));
    for (int f = 0; f < shape.faceCount(); ++f) {
      const auto& face = shape.faces()[f];
      const Vector3 normal = X_AS.R * face.normal;
      keep(w_.solid_.faces.push_back({{normal, face.offset + normal.dot(X_AS.p), f, owner}, face.first, face.count}));
      for (int h = face.first; h < face.first + face.count; ++h) keep(w_.solid_.loop.push_back(shape.loopVertex(h)));
    }
  }

  void start(const Vector3& lower, const Vector3& upper) {
    clear(w_.solid_);
    for (int i = 0; i < 8; ++i) {
      keep(w_.solid_.points.push_back({i & 1 ? upper.x() : lower.x(), i & 2 ? upper.y() : lower.y(), i & 4 ? upper.z() : lower.z()}));
    }
    constexpr int kLoops[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int f = 0; f < 6; ++f) {
      const double side = f & 1 ? 1 : -1;
      const ContactFace plane{side * Vector3::Unit(f / 2), side * (f & 1 ? upper : lower)[f / 2], -1, Owner::kA};
      keep(w_.solid_.faces.push_back({plane, 4 * f, 4}));
      for (const int corner : kLoops[f]) keep(w_.solid_.loop.push_back(corner));
    }
  }

  /// False when nothing is left.
  bool cut(const ContactFace& plane) {
    int outside = 0;
    w_.height_.clear();
    for (const Vector3& x : w_.solid_.points) {
      w_.height_.push_back(plane.normal.dot(x) - plane.offset);
      outside += w_.height_[w_.height_.size() - 1] > 0;
    }
    if (outside == 0) return true;
    if (outside == w_.solid_.points.size()) return false;
    keepPointsBelow();
    for (const auto& face : w_.solid_.faces) cutFace(face);
    addCaps(plane);
    std::swap(w_.solid_, w_.cut_);
    return !w_.solid_.faces.empty();
  }

  /// Hands the solid over as vertices, faces and edges.
  void finish() {
    w_.vertices_.clear();
    w_.faces_.clear();
    w_.edges_.clear();
    for (const Vector3& x : w_.solid_.points) keep(w_.vertices_.push_back(x));
    w_.pairs_.clear();
    for (const auto& face : w_.solid_.faces) {
      keep(w_.faces_.push_back(face.face));
      for (int i = 0; i < face.count; ++i)
        addHalfEdge(loopPoint(face, i), loopPoint(face, i + 1), w_.faces_.size() - 1);
    }
    for (ContactEdge& e : w_.edges_)
      if (w_.faces_[e.left].owner == Owner::kB && w_.faces_[e.right].owner == Owner::kA)
        e = {e.to, e.from, e.right, e.left};
    const auto is_inner = [&](const ContactEdge& e) {
      return w_.faces_[e.left].owner == w_.faces_[e.right].owner;
    };
    w_.seam_begin_ =
        static_cast<int>(std::partition(w_.edges_.begin(), w_.edges_.end(), is_inner) - w_.edges_.begin());
  }

  bool complete() const { return complete_; }

 private:
  using CutFace = CutSolid::Face;

  void keep(bool stored) { complete_ = complete_ && stored; }
  static void clear(CutSolid& s) {
    s.points.clear();
    s.faces.clear();
    s.loop.clear();
  }
  int loopPoint(const CutFace& f, int i) const {
    return w_.solid_.loop[f.first + (i < f.count ? i : i - f.count)];
  }
  bool isOut(int point) const { return w_.height_[point] > 0; }

  void keepPointsBelow() {
    clear(w_.cut_);
    w_.moved_to_.clear();
    w_.cap_next_.clear();
    w_.pairs_.clear();
    for (int i = 0; i < w_.solid_.points.size(); ++i) {
      w_.moved_to_.push_back(isOut(i) ? -1 : w_.cut_.points.size());
      if (!isOut(i)) w_.cut_.points.push_back(w_.solid_.points[i]);
    }
    for (int i = 0; i < w_.cut_.points.size(); ++i) w_.cap_next_.push_back(-1);
  }

  /// The new vertex on the edge from a point inside to one outside, made once for both faces.
  int crossing(int inside, int outside) {
    int* found = w_.pairs_.find(inside, outside);
    if (found && *found >= 0) return *found;
    const double hi = w_.height_[inside], ho = w_.height_[outside];
    const Vector3 &a = w_.solid_.points[inside], &b = w_.solid_.points[outside];
    if (!found || !w_.cut_.points.push_back(a + hi / (hi - ho) * (b - a)) || !w_.cap_next_.push_back(-1)) {
      complete_ = false;
      return std::max(0, w_.moved_to_[inside]);
    }
    return *found = w_.cut_.points.size() - 1;
  }

  void cutFace(const CutFace& face) {
    CutFace kept{face.face, w_.cut_.loop.size(), 0};
    int first_return = -1, leave = -1;
    for (int i = 0; i < face.count; ++i) {
      const int p = loopPoint(face, i), q = loopPoint(face, i + 1);
      if (!isOut(p)) keep(w_.cut_.loop.push_back(w_.moved_to_[p]));
      if (isOut(p) == isOut(q)) continue;
      const int x = isOut(p) ? crossing(q, p) : crossing(p, q);
      keep(w_.cut_.loop.push_back(x));
      if (!isOut(p))
        leave = x;  // left here …
      else if (leave < 0)
        first_return = x;  // … before the list began
      else {
        w_.cap_next_[x] = leave;
        leave = -1;
      }  // … and back: the cap passes this edge backwards
    }
    if (first_return >= 0 && leave >= 0) w_.cap_next_[first_return] = leave;
    kept.count = w_.cut_.loop.size() - kept.first;
    if (kept.count > 0) keep(w_.cut_.faces.push_back(kept));
  }

  void addCaps(const ContactFace& plane) {
    for (int start = 0; start < w_.cap_next_.size(); ++start) {
      CutFace cap{plane, w_.cut_.loop.size(), 0};
      for (int p = start; w_.cap_next_[p] >= 0;) {
        keep(w_.cut_.loop.push_back(p));
        const int next = w_.cap_next_[p];
        w_.cap_next_[p] = -1;
        p = next;
      }
      cap.count = w_.cut_.loop.size() - cap.first;
      if (cap.count > 0) keep(w_.cut_.faces.push_back(cap));
    }
  }

  void addHalfEdge(int p, int q, int face) {
    int* waiting = w_.pairs_.find(q, p);
    if (waiting && *waiting >= 0) {
      w_.edges_[*waiting].right = face;
      *waiting = -1;
      return;
    }
    int* mine = w_.pairs_.find(p, q);
    if (mine) *mine = w_.edges_.size();
    keep(mine && w_.edges_.push_back({p, q, face, face}));
  }

  ContactWorkspace& w_;
  bool complete_ = true;
};

void startBox(const Vector3& lower, const Vector3& upper, ContactWorkspace& workspace) noexcept {
  VolumeCutter(workspace).start(lower, upper);
}

bool cutSolid(const ContactFace& plane, ContactWorkspace& workspace, bool& complete) noexcept {
  VolumeCutter cutter(workspace);
  const bool left = cutter.cut(plane);
  complete = complete && cutter.complete();
  return left;
}

bool cutVolume(const ConvexPolyhedron& shape, const Pose& X_AS, Owner owner, const ContactFace& plane,
               ContactWorkspace& workspace, bool& complete) noexcept {
  VolumeCutter cutter(workspace);
  cutter.start(shape, X_AS, owner);
  if (!cutter.cut(plane)) return false;
  cutter.finish();
  complete = cutter.complete();
  return true;
}

bool cutVolume(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
               ContactWorkspace& workspace, bool& complete) noexcept {
  VolumeCutter cutter(workspace);
  cutter.start(A, Pose(), Owner::kA);
  for (int f = 0; f < B.faceCount(); ++f) {
    const auto& face = B.faces()[f];
    const Vector3 normal = X_AB.R * face.normal;
    if (!cutter.cut({normal, face.offset + normal.dot(X_AB.p), f, Owner::kB})) return false;
  }
  cutter.finish();
  complete = cutter.complete();
  return true;
}

}  // namespace haptic
