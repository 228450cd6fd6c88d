#include "haptic_core/geometry/edge_clipping.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

/// Distance from a plane, in roundings of the coordinates there, that counts as on it. A height is a sum of
/// four products, wrong by up to 4 roundings; with less than that, faces aligned but for rounding would be
/// torn into contradicting signs and take the slow path; each more adds a rounding to the volume's error.
constexpr double kTie = 8 * std::numeric_limits<double>::epsilon();

/// The pieces of seam by (face of A, face of B): for two boxes a table of 36.
class BoxSeams {
 public:
  using Piece = ContactWorkspace::Seam;
  BoxSeams() { std::fill(std::begin(ends_), std::end(ends_), -1); }

  /// Where the piece's start (end = 0) or end (1) is kept; -1: not found yet.
  int* at(int f, int g, int end) {
    const int i = 6 * f + g;
    used_ |= std::uint64_t{1} << i;
    return &ends_[2 * i + end];
  }
  bool next(Piece& piece) {
    if (!used_) return false;
    const int i = __builtin_ctzll(used_);
    used_ &= used_ - 1;
    piece = {ends_[2 * i], ends_[2 * i + 1], i / 6, i % 6};
    return true;
  }

 private:
  int ends_[72];
  std::uint64_t used_ = 0;
};

/// The same for any shapes: a list, found through a hash table.
class TableSeams {
 public:
  using Piece = ContactWorkspace::Seam;
  TableSeams(PairTable& table, LoadedVector<Piece>& pieces) : table_(table), pieces_(pieces) {
    table_.clear();
    pieces_.clear();
  }
  int* at(int f, int g, int end) {
    int* index = table_.find(f, g);
    if (!index || (*index < 0 && !pieces_.push_back({-1, -1, f, g}))) return nullptr;
    if (*index < 0) *index = pieces_.size() - 1;
    Piece& piece = pieces_[*index];
    return end ? &piece.end : &piece.start;
  }
  bool next(Piece& piece) {
    if (given_ == pieces_.size()) return false;
    piece = pieces_[given_++];
    return true;
  }

 private:
  PairTable& table_;
  LoadedVector<Piece>& pieces_;
  int given_ = 0;
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

int EdgeClipper::vertexOf(ContactSide& side, int point) {
  int& id = side.point_in_v[point];
  if (id < 0) {
    id = w_.vertices_.size();
    w_.vertices_.push_back(side.points[point]);
  }
  return id;
}

template <bool kIsA>
int EdgeClipper::faceOf(ContactSide& side, int face) {
  int& id = side.face_in_v[face];
  if (id < 0) {
    id = w_.faces_.size();
    const PlaneGroup& p = side.planes[face >> 2];
    const int i = face & 3;
    w_.faces_.push_back(
        {Vector3(p.nx[i], p.ny[i], p.nz[i]), p.offset[i], side.faces[face], kIsA ? Owner::kA : Owner::kB});
  }
  return id;
}

template <bool kIsA, int kWords, class Seams>
bool EdgeClipper::clipEdges(ContactSide& own, ContactSide& other, Seams& seams) {
  const int words = kWords > 0 ? kWords : own.words;
  const std::uint64_t* const codes = own.codes.begin();
  bool consistent = true;
  // An end at `vertex` of the pieces of seam on plane `through`: one starts and one ends there, seen along
  // A's face.
  const auto join = [&](int through, int left, int right, int vertex, bool entering) {
    const int of_left = entering == kIsA, of_right = 1 - of_left;
    int* first = kIsA ? seams.at(left, through, of_left) : seams.at(through, left, of_left);
    consistent = consistent && first && *first < 0;
    if (first) *first = vertex;
    int* second = kIsA ? seams.at(right, through, of_right) : seams.at(through, right, of_right);
    consistent = consistent && second && *second < 0;
    if (second) *second = vertex;
  };
  for (int i = 0; i < own.edge_count; ++i) {
    const ConvexPolyhedron::Edge& e = own.edges[i];
    const std::uint64_t *from_code = codes + e.from * words, *to_code = codes + e.to * words;
    std::uint64_t both = 0;
    for (int w = 0; w < words; ++w) both |= from_code[w] & to_code[w];
    if (both) continue;
    // Clip: the planes that `from` is outside of are entered, those of `to` are left.
    const Vector3 &p = own.points[e.from], &q = own.points[e.to];
    double enter = 0, leave = 1;
    int enter_plane = -1, leave_plane = -1;
    for (int w = 0; w < words; ++w)
      for (std::uint64_t rest = from_code[w] | to_code[w]; rest; rest &= rest - 1) {
        const int g = 64 * w + __builtin_ctzll(rest);
        const double hp = other.height(g, p), hq = other.height(g, q);
        const double t = std::min(1.0, std::max(0.0, hp / (hp - hq)));
        if (from_code[w] & rest & -rest) {
          if (t > enter || enter_plane < 0) enter = t, enter_plane = g;
        } else if (t < leave || leave_plane < 0) {
          leave = t, leave_plane = g;
        }
      }
    if (enter_plane >= 0 && leave_plane >= 0 && !(enter < leave)) continue;
    int start, end;
    if (enter_plane < 0) {
      start = vertexOf(own, e.from);
    } else {
      start = w_.vertices_.size();
      w_.vertices_.push_back(p + enter * (q - p));
      join(enter_plane, e.left, e.right, start, true);
    }
    if (leave_plane < 0) {
      end = vertexOf(own, e.to);
    } else {
      end = w_.vertices_.size();
      w_.vertices_.push_back(p + leave * (q - p));
      join(leave_plane, e.left, e.right, end, false);
    }
    const int left = faceOf<kIsA>(own, e.left), right = faceOf<kIsA>(own, e.right);
    if (!w_.edges_.push_back({start, end, left, right})) return false;
  }
  return consistent;
}

template <int kWords, class Seams>
EdgeClipper::Result EdgeClipper::assemble(Seams& seams) {
  w_.vertices_.clear();
  w_.faces_.clear();
  w_.edges_.clear();
  if (!clipEdges<true, kWords>(a_, b_, seams) || !clipEdges<false, kWords>(b_, a_, seams))
    return Result::kInconsistent;
  if (w_.edges_.empty()) return Result::kNothing;
  w_.seam_begin_ = w_.edges_.size();
  for (ContactWorkspace::Seam piece; seams.next(piece);) {
    const int f = faceOf<true>(a_, piece.face_a), g = faceOf<false>(b_, piece.face_b);
    if (piece.start < 0 || piece.end < 0 || !w_.edges_.push_back({piece.start, piece.end, f, g}))
      return Result::kInconsistent;
  }
  return Result::kClosed;
}

namespace {

void startSide(ContactSide& side) {
  side.points.clear();
  side.faces.clear();
  side.planes.clear();
  side.own_edges.clear();
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
        side.own_edges.push_back({e.from, e.to, e.left, e.right});
      }
    }
  }
  for (auto& e : side.own_edges)
    e = {vertex_stamp[e.from].local, vertex_stamp[e.to].local, face_stamp[e.left].local,
         face_stamp[e.right].local};
  side.edges = side.own_edges.begin();
  side.edge_count = side.own_edges.size();
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
        const Lanes above_p = plane.nx * px + plane.ny * py + plane.nz * pz - plane.offset;
        const Lanes above_q = plane.nx * qx + plane.ny * qy + plane.nz * qz - plane.offset;
        p_bits |= static_cast<std::uint64_t>(bits(above_p > limit)) << shift;
        q_bits |= static_cast<std::uint64_t>(bits(above_q > limit)) << shift;
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
  return assemble<0>(seams);
}

namespace {

/// The corners middle ± x ± y ± z in the order of `makeBox`.
void corners(const Vector3& middle, const Vector3& x, const Vector3& y, const Vector3& z, Lanes* corner) {
  const auto wide = [](const Vector3& v) { return Lanes{v.x(), v.y(), v.z(), 0}; };
  const Lanes low = wide(middle - x), high = wide(middle + x), along_y = wide(y), along_z = wide(z);
  corner[0] = low - along_y - along_z;
  corner[1] = high - along_y - along_z;
  corner[2] = low + along_y - along_z;
  corner[3] = high + along_y - along_z;
  corner[4] = low - along_y + along_z;
  corner[5] = high - along_y + along_z;
  corner[6] = low + along_y + along_z;
  corner[7] = high + along_y + along_z;
}

/// Bits 2k and 2k + 1: beyond the lower and the upper face of axis k.
std::uint64_t boxCode(const Lanes& corner, const Lanes& limit) {
  static constexpr std::uint64_t kSpread[8] = {0, 1, 4, 5, 16, 17, 20, 21};
  return kSpread[bits(corner < -limit) & 7] | kSpread[bits(corner > limit) & 7] << 1;
}

/// The planes of a box with axes R and centre p in the order of `makeBox`.
void setBoxPlanes(ContactSide& side, const Matrix3& R, const Vector3& p, const Vector3& half) {
  const Vector3 d = R.transpose() * p;
  const double far = std::numeric_limits<double>::infinity();
  side.planes.resize(2);
  side.planes[0] =
      PlaneGroup{Lanes{-R(0, 0), R(0, 0), -R(0, 1), R(0, 1)}, Lanes{-R(1, 0), R(1, 0), -R(1, 1), R(1, 1)},
                 Lanes{-R(2, 0), R(2, 0), -R(2, 1), R(2, 1)},
                 Lanes{half.x() - d.x(), half.x() + d.x(), half.y() - d.y(), half.y() + d.y()}};
  side.planes[1] =
      PlaneGroup{Lanes{-R(0, 2), R(0, 2), 0, 0}, Lanes{-R(1, 2), R(1, 2), 0, 0},
                 Lanes{-R(2, 2), R(2, 2), 0, 0}, Lanes{half.z() - d.z(), half.z() + d.z(), far, far}};
}

void startBox(ContactSide& side, const ConvexPolyhedron& body) {
  side.words = 1;
  side.points.resize(8);
  side.codes.resize(8);
  side.point_in_v.resize(8);
  side.faces.resize(6);
  side.face_in_v.resize(6);
  for (int v = 0; v < 8; ++v) side.point_in_v[v] = -1;
  for (int f = 0; f < 6; ++f) {
    side.faces[f] = f;
    side.face_in_v[f] = -1;
  }
  side.edges = body.edges().data();
  side.edge_count = 12;
}

}  // namespace

EdgeClipper::Result EdgeClipper::clipBoxes() {
  startBox(a_, A_);
  startBox(b_, B_);
  const Matrix3& R = X_AB_.R;
  const Vector3 &p = X_AB_.p, &half_a = A_.halfSize(), &half_b = B_.halfSize();
  setBoxPlanes(a_, Matrix3::Identity(), Vector3::Zero(), half_a);
  setBoxPlanes(b_, R, p, half_b);
  // Each body's corners in the other's axes, where its six planes are three intervals. The fourth lane is 0.
  Lanes corner[8];
  corners(-(R.transpose() * p), half_a.x() * R.row(0), half_a.y() * R.row(1), half_a.z() * R.row(2), corner);
  const Vector3 inner = half_b.array() - tolerance_, outer = half_a.array() + tolerance_;
  for (int v = 0; v < 8; ++v) {
    a_.points[v] = A_.vertices()[v];
    a_.codes[v] = boxCode(corner[v], Lanes{inner.x(), inner.y(), inner.z(), 0});
  }
  corners(p, half_b.x() * R.col(0), half_b.y() * R.col(1), half_b.z() * R.col(2), corner);
  for (int v = 0; v < 8; ++v) {
    b_.points[v] = Vector3(corner[v][0], corner[v][1], corner[v][2]);
    b_.codes[v] = boxCode(corner[v], Lanes{outer.x(), outer.y(), outer.z(), 0});
  }
  BoxSeams seams;
  return assemble<1>(seams);
}

}  // namespace haptic
