// Two boxes: four parallel edges at a time against three pairs of parallel planes.
//
// Planes are numbered axis + 4 × (upper ? 1 : 0), so that the two groups of a side are its lower and its upper faces.
#include <cstring>

#include "haptic_core/geometry/edge_clipping.h"
#include "haptic_core/geometry/edge_collector.h"

namespace haptic {
namespace {

/// The edges of `makeBox`, those along x first; of each four the first point has the lower coordinates.
struct BoxEdges {
  SideEdge edge[12];

  constexpr BoxEdges() : edge() {
    for (int n = 0; n < 12; ++n) {
      const int axis = n / 4, i = (axis + 1) % 3, j = (axis + 2) % 3, upper_i = n & 1, upper_j = n >> 1 & 1;
      const int from = upper_i << i | upper_j << j, face_i = i + 4 * upper_i, face_j = j + 4 * upper_j;
      // Seen from outside, face j lies left of the edge when it and face i are on opposite sides.
      edge[n] = upper_i == upper_j ? SideEdge{from, from | 1 << axis, face_i, face_j}
                                   : SideEdge{from, from | 1 << axis, face_j, face_i};
    }
  }
};
constexpr BoxEdges kBox;

/// The pieces of seam in a table of 8 × 8 planes.
class BoxSeams {
 public:
  BoxSeams() { std::memset(ends_, -1, sizeof ends_); }

  bool setEnd(int f, int g, int end, int vertex) {
    const int i = 8 * f + g;
    used_ |= std::uint64_t{1} << i;
    const bool first = ends_[i][end] < 0;
    ends_[i][end] = static_cast<signed char>(vertex);  // at most 16 corners and 48 cuts
    return first;
  }
  bool next(ContactWorkspace::Seam& piece) {
    if (!used_) return false;
    const int i = __builtin_ctzll(used_);
    used_ &= used_ - 1;
    piece = {ends_[i][0], ends_[i][1], i >> 3, i & 7};
    return true;
  }

 private:
  signed char ends_[64][2];
  std::uint64_t used_ = 0;
};

Lanes wide(const Vector3& v) {
  return Lanes{v.x(), v.y(), v.z(), 0};
}

/// The corners of one box in the axes of the other, where that one's planes are three intervals. The fourth lane is 0.
struct Corners {
  Lanes at[8];

  /// Those at middle ± x ± y ± z, in the order of `makeBox`.
  Corners(const Vector3& middle, const Vector3& x, const Vector3& y, const Vector3& z) {
    const Lanes low = wide(middle - x), high = wide(middle + x), along_y = wide(y), along_z = wide(z);
    at[0] = low - along_y - along_z;
    at[1] = high - along_y - along_z;
    at[2] = low + along_y - along_z;
    at[3] = high + along_y - along_z;
    at[4] = low - along_y + along_z;
    at[5] = high - along_y + along_z;
    at[6] = low + along_y + along_z;
    at[7] = high + along_y + along_z;
  }
};

/// The planes of a box with axes R and centre p.
void setPlanes(ContactSide& side, const Matrix3& R, const Vector3& p, const Vector3& half) {
  const Lanes x{R(0, 0), R(0, 1), R(0, 2), 0}, y{R(1, 0), R(1, 1), R(1, 2), 0}, z{R(2, 0), R(2, 1), R(2, 2), 0};
  const Lanes centre = x * lanes(p.x()) + y * lanes(p.y()) + z * lanes(p.z());
  side.planes.resize(2);
  side.planes[0] = {-x, -y, -z, wide(half) - centre};
  side.planes[1] = {x, y, z, wide(half) + centre};
}

void startBox(ContactSide& side) {
  static constexpr int kFaces[8] = {0, 2, 4, -1, 1, 3, 5, -1};
  side.points.resize(8);
  side.point_in_v.resize(8);
  side.faces.resize(8);
  side.face_in_v.resize(8);
  std::memset(side.point_in_v.begin(), -1, 8 * sizeof(int));
  std::memset(side.face_in_v.begin(), -1, 8 * sizeof(int));
  std::memcpy(side.faces.begin(), kFaces, sizeof kFaces);
}

/// Four parallel edges against the three intervals |coordinate| ≤ half. Of a mask's bits, k belongs to edge k.
class ParallelEdges {
 public:
  /// From corners `from` to corners `to`; a point is outside beyond ± limit.
  ParallelEdges(const Corners& corners, const SideEdge* e, const Vector3& limit) {
    const Lanes* const at = corners.at;
    transpose(at[e[0].from], at[e[1].from], at[e[2].from], at[e[3].from], from_[0], from_[1], from_[2]);
    transpose(at[e[0].to], at[e[1].to], at[e[2].to], at[e[3].to], to_[0], to_[1], to_[2]);
    for (int axis = 0; axis < 3; ++axis) {
      const Lanes upper = lanes(limit[axis]), lower = -upper;
      const LaneMask from_below = from_[axis] < lower, from_above = from_[axis] > upper;
      const LaneMask to_below = to_[axis] < lower, to_above = to_[axis] > upper;
      missing_ |= bits((from_below & to_below) | (from_above & to_above));
      entering_[axis] = from_below | from_above;
      leaving_[axis] = to_below | to_above;
      from_above_[axis] = bits(from_above);
      to_above_[axis] = bits(to_above);
    }
  }

  /// Those that no plane has wholly outside.
  unsigned candidates() const { return ~missing_ & 15; }

  /// The last axis that each enters, the first that it leaves, and where.
  void clip(const Vector3& half) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!bits(entering_[axis] | leaving_[axis])) continue;
      const Lanes per_length = lanes(1) / (to_[axis] - from_[axis]);
      const Lanes t1 = (lanes(-half[axis]) - from_[axis]) * per_length, t2 = (lanes(half[axis]) - from_[axis]) * per_length;
      const Lanes in = maximum(minimum(minimum(t1, t2), lanes(1)), lanes(0)),
                  out = maximum(minimum(maximum(t1, t2), lanes(1)), lanes(0));
      const LaneMask later = entering_[axis] & (in > enter_), sooner = leaving_[axis] & (out < leave_);
      enter_ = select(later, in, enter_);
      enter_axis_ = select(later, lanes(axis), enter_axis_);
      leave_ = select(sooner, out, leave_);
      leave_axis_ = select(sooner, lanes(axis), leave_axis_);
    }
  }

  InnerPart part(int k) const {
    InnerPart part;
    if (enter_[k] >= 0) {
      const int axis = static_cast<int>(enter_axis_[k]);
      part.enter = enter_[k];
      part.enter_plane = axis + 4 * static_cast<int>(from_above_[axis] >> k & 1);
    }
    if (leave_[k] <= 1) {
      const int axis = static_cast<int>(leave_axis_[k]);
      part.leave = leave_[k];
      part.leave_plane = axis + 4 * static_cast<int>(to_above_[axis] >> k & 1);
    }
    return part;
  }

 private:
  Lanes from_[3], to_[3];  // x, y and z of the ends
  LaneMask entering_[3], leaving_[3];
  unsigned from_above_[3], to_above_[3], missing_ = 0;
  Lanes enter_ = lanes(-1), leave_ = lanes(2), enter_axis_ = lanes(0), leave_axis_ = lanes(0);  // -1, 2: not at all
};

template <bool kIsA>
void clipEdges(const Corners& corners, const Vector3& half_of_other, double tolerance, ContactSide& own,
               EdgeCollector<BoxSeams>& v) {
  const Vector3 limit = half_of_other.array() + tolerance;
  for (int first = 0; first < 12; first += 4) {
    const SideEdge* const edges = &kBox.edge[first];
    ParallelEdges parallel(corners, edges, limit);
    unsigned rest = parallel.candidates();
    if (!rest) continue;
    parallel.clip(half_of_other);
    for (; rest; rest &= rest - 1) {
      const int k = __builtin_ctz(rest);
      const InnerPart part = parallel.part(k);
      if (!part.empty()) v.add<kIsA>(own, edges[k], part);
    }
  }
}

}  // namespace

EdgeClipper::Result EdgeClipper::clipBoxes() {
  const Matrix3& R = X_AB_.R;
  const Vector3 &p = X_AB_.p, &half_a = A_.halfSize(), &half_b = B_.halfSize();
  startBox(a_);
  startBox(b_);
  setPlanes(a_, Matrix3::Identity(), Vector3::Zero(), half_a);
  setPlanes(b_, R, p, half_b);
  const Corners of_a(-(R.transpose() * p), half_a.x() * R.row(0), half_a.y() * R.row(1), half_a.z() * R.row(2));
  const Corners of_b(p, half_b.x() * R.col(0), half_b.y() * R.col(1), half_b.z() * R.col(2));
  for (int v = 0; v < 8; ++v) {
    a_.points[v] = A_.vertices()[v];
    b_.points[v] = Vector3(of_b.at[v][0], of_b.at[v][1], of_b.at[v][2]);
  }
  BoxSeams seams;
  EdgeCollector<BoxSeams> v(w_, seams);
  clipEdges<true>(of_a, half_b, -tolerance_, a_, v);
  clipEdges<false>(of_b, half_a, tolerance_, b_, v);
  return v.close();
}

}  // namespace haptic
