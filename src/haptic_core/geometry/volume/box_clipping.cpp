// Two boxes: four parallel edges at a time against three pairs of parallel planes.
//
// Planes are numbered axis + 4 × (upper ? 1 : 0), so that the two groups of a side are its lower and its upper faces.
#include <cstring>

#include "haptic_core/geometry/volume/edge_clipping.h"
#include "haptic_core/geometry/volume/edge_collector.h"

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

  void setEnd(int f, int g, int end, int vertex) {
    const int i = 8 * f + g;
    used_ |= std::uint64_t{1} << i;
    ends_[i][end] = static_cast<signed char>(vertex);  // at most 16 corners and 48 cuts
  }
  static constexpr bool fits() { return true; }
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

Lanes wide(const Vector3& v, double fourth = 0) {
  return Lanes{v.x(), v.y(), v.z(), fourth};
}

/// The corners middle ± x ± y ± z of a box, in the order of `makeBox`. The fourth lane is 0.
struct Corners {
  Lanes at[8];

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

/// A box for the collector: its corners in A's frame, its planes as outward normal and offset.
class BoxSide {
 public:
  /// With axes R and centre p.
  BoxSide(const Matrix3& R, const Vector3& p, const Vector3& half)
      : corners_(p, half.x() * R.col(0), half.y() * R.col(1), half.z() * R.col(2)) {
    for (int axis = 0; axis < 3; ++axis) {
      const Lanes outward = wide(R.col(axis), R.col(axis).dot(p)), offset{0, 0, 0, half[axis]};
      planes_[axis] = offset - outward;
      planes_[axis + 4] = offset + outward;
    }
    std::memset(point_in_v_, -1, sizeof point_in_v_);
    std::memset(face_in_v_, -1, sizeof face_in_v_);
  }

  signed char& pointInV(int p) { return point_in_v_[p]; }
  signed char& faceInV(int plane) { return face_in_v_[plane]; }
  const Lanes& point(int p) const { return corners_.at[p]; }
  const Corners& corners() const { return corners_; }
  ContactFace face(int plane, Owner owner) const {
    const Lanes& n = planes_[plane];
    return {Vector3(n[0], n[1], n[2]), n[3], 2 * (plane & 3) + (plane >> 2), owner};
  }

 private:
  Corners corners_;
  Lanes planes_[8];
  signed char point_in_v_[8], face_in_v_[8];  // as BoxSeams
};

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
      from_above_[axis] = from_above;
      to_above_[axis] = to_above;
    }
  }

  /// Those that no plane has wholly outside.
  unsigned candidates() const { return ~missing_ & 15; }

  /// The last plane that each enters, the first that it leaves, and where.
  void clip(const Vector3& half) {
    Lanes enter = lanes(-1), leave = lanes(2), enter_plane = enter, leave_plane = enter;
    for (int axis = 0; axis < 3; ++axis) {
      if (!bits(entering_[axis] | leaving_[axis])) continue;
      const Lanes per_length = lanes(1) / (to_[axis] - from_[axis]);
      const Lanes t1 = (lanes(-half[axis]) - from_[axis]) * per_length, t2 = (lanes(half[axis]) - from_[axis]) * per_length;
      const Lanes in = maximum(minimum(minimum(t1, t2), lanes(1)), lanes(0)),
                  out = maximum(minimum(maximum(t1, t2), lanes(1)), lanes(0));
      const LaneMask later = entering_[axis] & (in > enter), sooner = leaving_[axis] & (out < leave);
      const Lanes lower = lanes(axis), upper = lanes(axis + 4);
      enter = select(later, in, enter);
      enter_plane = select(later, select(from_above_[axis], upper, lower), enter_plane);
      leave = select(sooner, out, leave);
      leave_plane = select(sooner, select(to_above_[axis], upper, lower), leave_plane);
    }
    storeLanes(enter, enter_);
    storeLanes(leave, leave_);
    storeLanes(enter_plane, enter_plane_);
    storeLanes(leave_plane, leave_plane_);
  }

  InnerPart part(int k) const {
    return {enter_[k], leave_[k], static_cast<int>(enter_plane_[k]), static_cast<int>(leave_plane_[k])};
  }

 private:
  Lanes from_[3], to_[3];  // x, y and z of the ends
  LaneMask entering_[3], leaving_[3], from_above_[3], to_above_[3];
  unsigned missing_ = 0;
  double enter_[4], leave_[4], enter_plane_[4], leave_plane_[4];  // by edge; plane -1: none
};

/// `corners`: in the axes of the other box, where that one's planes are three intervals.
template <bool kIsA>
void clipEdges(const Corners& corners, const Vector3& half_of_other, double tolerance, EdgeCollector<BoxSide, BoxSeams>& v) {
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
      if (!part.empty()) v.add<kIsA>(edges[k], part);
    }
  }
}

}  // namespace

EdgeClipper::Result EdgeClipper::clipBoxes() {
  const Matrix3& R = X_AB_.R;
  const Vector3 &p = X_AB_.p, &half_a = A_.halfSize(), &half_b = B_.halfSize();
  BoxSide a(Matrix3::Identity(), Vector3::Zero(), half_a), b(R, p, half_b);
  BoxSeams seams;
  EdgeCollector<BoxSide, BoxSeams> v(w_, a, b, seams);
  const Corners of_a(-(R.transpose() * p), half_a.x() * R.row(0), half_a.y() * R.row(1), half_a.z() * R.row(2));
  clipEdges<true>(of_a, half_b, -tolerance_, v);
  clipEdges<false>(b.corners(), half_a, tolerance_, v);
  return v.close();
}

}  // namespace haptic
