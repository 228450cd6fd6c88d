#include "haptic_core/geometry/volume/edge_clipping.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/geometry/volume/edge_collector.h"

namespace haptic {
namespace {

/// Distance from a plane, in roundings of the coordinates there, that counts as on it. A height is a sum of
/// four products, wrong by up to 4 roundings; with less than that, faces aligned but for rounding would be
/// torn into contradicting signs and take the slow path; each more adds a rounding to the volume's error.
constexpr double kTie = 8 * std::numeric_limits<double>::epsilon();

/// The pieces of seam in a list, found through a hash table.
class TableSeams {
 public:
  using Piece = ContactWorkspace::Seam;
  TableSeams(PairTable& table, LoadedVector<Piece>& pieces) : table_(table), pieces_(pieces) {
    table_.clear();
    pieces_.clear();
  }
  void setEnd(int f, int g, int end, int vertex) {
    int* const index = table_.find(f, g);
    if (!index || (*index < 0 && !pieces_.push_back({-1, -1, f, g}))) {
      fits_ = false;
      return;
    }
    if (*index < 0) *index = pieces_.size() - 1;
    Piece& piece = pieces_[*index];
    (end ? piece.end : piece.start) = vertex;
  }
  bool fits() const { return fits_; }
  bool next(Piece& piece) {
    if (given_ == pieces_.size()) return false;
    piece = pieces_[given_++];
    return true;
  }

 private:
  PairTable& table_;
  LoadedVector<Piece>& pieces_;
  int given_ = 0;
  bool fits_ = true;
};

/// A side as gathered, for the collector.
class GatheredSide {
 public:
  explicit GatheredSide(ContactSide& side) : side_(side) {}
  int& pointInV(int p) { return side_.point_in_v[p]; }
  int& faceInV(int plane) { return side_.face_in_v[plane]; }
  Lanes point(int p) const { return loadLanes(side_.points[p].data()); }
  ContactFace face(int plane, Owner owner) const {
    const PlaneGroup& group = side_.planes[plane >> 2];
    const int i = plane & 3;
    return {Vector3(group.nx[i], group.ny[i], group.nz[i]), group.offset[i], side_.faces[plane], owner};
  }

 private:
  ContactSide& side_;
};

}  // namespace

EdgeClipper::EdgeClipper(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB,
                         ContactWorkspace& workspace)
    : A_(A), B_(B), X_AB_(X_AB), w_(workspace), a_(workspace.side_a_), b_(workspace.side_b_) {
  const double reach_a = A.centre().norm() + A.boundingRadius(),
               reach_b = B.centre().norm() + B.boundingRadius();
  // Coordinates of the contact: no larger than either body's reach, but B's carry the rounding of its pose.
  tolerance_ = kTie * (std::min(reach_a, reach_b) + X_AB.p.lpNorm<Eigen::Infinity>());
}

namespace {

/// Of four candidates (lane i: a plane of `group[i]`) the one with the largest t, of equals the first plane.
int lastPlane(const Lanes& t, const Lanes& group, double largest_t) {
  unsigned equals = ~bits(t < lanes(largest_t)) & 15;
  int plane = std::numeric_limits<int>::max();
  for (; equals; equals &= equals - 1) {
    const int i = __builtin_ctz(equals);
    plane = std::min(plane, 4 * static_cast<int>(group[i]) + i);
  }
  return plane;
}

/// Clips p → q: the planes that `from` is outside of are entered, those of `to` are left. Four planes at a time, those
/// of a group that neither is outside of are left out.
InnerPart innerPart(const ContactSide& other, const Vector3& p, const Vector3& q, const std::uint64_t* from,
                    const std::uint64_t* to, int words) {
  // Leaving is counted backwards, so that for both the largest counts; at first neither happens.
  Lanes enter = lanes(-1), leave = lanes(-2), enter_group = lanes(0), leave_group = enter_group;
  const Lanes px = lanes(p.x()), py = lanes(p.y()), pz = lanes(p.z());
  const Lanes qx = lanes(q.x()), qy = lanes(q.y()), qz = lanes(q.z());
  for (int w = 0; w < words; ++w) {
    for (std::uint64_t rest = from[w] | to[w]; rest;) {
      const int shift = __builtin_ctzll(rest) & ~3, group = 16 * w + shift / 4;
      rest &= ~(std::uint64_t{15} << shift);
      const PlaneGroup& planes = other.planes[group];
      const Lanes hp = planes.above(px, py, pz), hq = planes.above(qx, qy, qz);
      const Lanes t = maximum(lanes(0), minimum(lanes(1), hp / (hp - hq)));
      const LaneMask later = laneMask(from[w] >> shift & 15) & (t > enter),
                     sooner = laneMask(to[w] >> shift & 15) & (-t > leave);
      enter = select(later, t, enter);
      enter_group = select(later, lanes(group), enter_group);
      leave = select(sooner, -t, leave);
      leave_group = select(sooner, lanes(group), leave_group);
    }
  }
  InnerPart part;
  if (const double last = largest(enter); last >= 0) {
    part.enter = last;
    part.enter_plane = lastPlane(enter, enter_group, last);
  }
  if (const double first = -largest(leave); first <= 1) {
    part.leave = first;
    part.leave_plane = lastPlane(leave, leave_group, -first);
  }
  return part;
}

template <bool kIsA>
void clipEdges(const ContactSide& own, const ContactSide& other, EdgeCollector<GatheredSide, TableSeams>& v) {
  const int words = own.words;
  for (const SideEdge& e : own.edges) {
    const std::uint64_t *from = &own.codes[e.from * words], *to = &own.codes[e.to * words];
    std::uint64_t both = 0, either = 0;
    for (int w = 0; w < words; ++w) {
      both |= from[w] & to[w];
      either |= from[w] | to[w];
    }
    if (both) continue;
    const InnerPart part = either ? innerPart(other, own.points[e.from], own.points[e.to], from, to, words) : InnerPart{};
    if (!part.empty()) v.template add<kIsA>(e, part);
  }
}

}  // namespace

namespace {

void startSide(ContactSide& side) {
  side.points.clear();
  side.faces.clear();
  side.planes.clear();
  side.edges.clear();
  side.cap.clear();
  if (++side.epoch == 0) {
    for (auto& s : side.vertex_stamp.all()) s.epoch = 0;
    for (auto& s : side.face_stamp.all()) s.epoch = 0;
    side.epoch = 1;
  }
}

}  // namespace

void EdgeClipper::gather(const ConvexPolyhedron& body, const Vector3& direction, double threshold,
                         int support, ContactSide& side) {
  startSide(side);
  const std::uint32_t epoch = side.epoch;
  auto& vertex_stamp = side.vertex_stamp.all();
  auto& face_stamp = side.face_stamp.all();
  // Points are numbered as they are met; for the time being point_in_v holds which vertex of the body each
  // is.
  LoadedVector<int>& vertex_of = side.point_in_v;
  vertex_of.clear();
  const auto meet = [&](int v) {
    const bool beyond = v == support || direction.dot(body.vertices()[v]) >= threshold;
    vertex_stamp[v] = {epoch, vertex_of.size(), beyond};
    vertex_of.push_back(v);
    if (beyond) side.cap.push_back(v);
  };
  meet(support);
  for (int i = 0; i < side.cap.size(); ++i) {
    const int v = side.cap[i];
    for (int k = body.neighbourBegin(v), end = body.neighbourBegin(v + 1); k < end; ++k) {
      const int u = body.neighbours()[k], h = body.outgoing()[k], f = body.faceOf(h);
      if (vertex_stamp[u].epoch != epoch) meet(u);
      if (face_stamp[f].epoch != epoch) {
        face_stamp[f] = {epoch, side.faces.size(), true};
        side.faces.push_back(f);
      }
      // Each edge once: from its lower end, or from the only end in the cap.
      if (v < u || !vertex_stamp[u].beyond) {
        const ConvexPolyhedron::Edge& e = body.edges()[body.edgeOf(h)];
        side.edges.push_back({e.from, e.to, e.left, e.right});
      }
    }
  }
  for (SideEdge& e : side.edges)
    e = {vertex_stamp[e.from].local, vertex_stamp[e.to].local, face_stamp[e.left].local,
         face_stamp[e.right].local};
  for (int v : vertex_of) side.points.push_back(body.vertices()[v]);
  for (int& v : vertex_of) v = -1;
  side.face_in_v.clear();
  for (int i = 0; i < side.faces.size(); ++i) side.face_in_v.push_back(-1);
}

namespace {

/// Planes of one body in A's frame; groups filled up with planes that nothing is outside of.
template <class PlaneOf>
void setPlanes(ContactSide& side, PlaneOf&& plane_of) {
  const int count = side.faces.size();
  for (int first = 0; first < count; first += 4) {
    PlaneGroup group{lanes(0), lanes(0), lanes(0), lanes(std::numeric_limits<double>::infinity())};
    for (int i = 0; i < 4 && first + i < count; ++i) {
      Vector3 normal;
      plane_of(side.faces[first + i], normal, group.offset[i]);
      group.nx[i] = normal.x();
      group.ny[i] = normal.y();
      group.nz[i] = normal.z();
    }
    side.planes.push_back(group);
  }
}

}  // namespace

void EdgeClipper::classify(ContactSide& side, const ContactSide& other, double tolerance) {
  const int groups = other.planes.size();
  side.words = (groups + 15) / 16;
  side.codes.resize(side.points.size() * side.words);
  const PlaneGroup* planes = other.planes.begin();
  const Lanes limit = lanes(tolerance);
  // Two points per pass over the planes: a plane's loads are shared.
  for (int i = 0; i < side.points.size(); i += 2) {
    const int j = std::min(i + 1, side.points.size() - 1);
    const Vector3 &p = side.points[i], &q = side.points[j];
    const Lanes px = lanes(p.x()), py = lanes(p.y()), pz = lanes(p.z());
    const Lanes qx = lanes(q.x()), qy = lanes(q.y()), qz = lanes(q.z());
    for (int word = 0, g = 0; word < side.words; ++word) {
      std::uint64_t p_bits = 0, q_bits = 0;
      for (int shift = 0; shift < 64 && g < groups; shift += 4, ++g) {
        const PlaneGroup& plane = planes[g];
        p_bits |= static_cast<std::uint64_t>(bits(plane.above(px, py, pz) > limit)) << shift;
        q_bits |= static_cast<std::uint64_t>(bits(plane.above(qx, qy, qz) > limit)) << shift;
      }
      side.codes[i * side.words + word] = p_bits;
      side.codes[j * side.words + word] = q_bits;
    }
  }
}

EdgeClipper::Result EdgeClipper::clip(const Overlap& overlap) {
  const Vector3& n = overlap.direction;
  gather(A_, n, overlap.bottom_b - tolerance_, overlap.support_a, a_);
  const Vector3 n_B = X_AB_.R.transpose() * n;
  gather(B_, -n_B, n.dot(X_AB_.p) - overlap.top_a - tolerance_, overlap.support_b, b_);
  for (Vector3& x : b_.points) x = X_AB_ * x;
  setPlanes(a_, [&](int f, Vector3& normal, double& offset) {
    normal = A_.faces()[f].normal;
    offset = A_.faces()[f].offset;
  });
  setPlanes(b_, [&](int f, Vector3& normal, double& offset) {
    normal = X_AB_.R * B_.faces()[f].normal;
    offset = B_.faces()[f].offset + normal.dot(X_AB_.p);
  });
  classify(a_, b_, -tolerance_);
  classify(b_, a_, tolerance_);
  TableSeams seams(w_.pairs_, w_.seams_);
  GatheredSide a(a_), b(b_);
  EdgeCollector<GatheredSide, TableSeams> v(w_, a, b, seams);
  clipEdges<true>(a_, b_, v);
  clipEdges<false>(b_, a_, v);
  return v.close();
}

}  // namespace haptic
