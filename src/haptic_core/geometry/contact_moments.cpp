#include "haptic_core/geometry/contact_moments.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/geometry/moment_sums.h"

namespace haptic {
namespace {

/// |S| below this share of the seam's own area: S is a remainder of rounding (1e-16) or of opposite ends that
/// cancel, and its direction means nothing. Larger, and normals better than 1e-9 rad are thrown away.
constexpr double kVanishing = 1e-6;

}  // namespace

Matrix3 patchAxes(const Vector3& n) {
  const double sign = n.z() < 0 ? -1.0 : 1.0;
  const double a = -1 / (sign + n.z()), b = n.x() * n.y() * a;
  Matrix3 R;
  R.col(0) << 1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x();
  R.col(1) << b, sign + n.y() * n.y() * a, -n.y();
  R.col(2) = n;
  return R;
}

Vector3 shortestWayOut(const ConvexPolyhedron& A, const ConvexPolyhedron& B, const Pose& X_AB) noexcept {
  double least = std::numeric_limits<double>::infinity();
  Vector3 best = Vector3::UnitZ();
  int va = 0, vb = 0;
  for (const auto& face : A.faces()) {
    vb = B.support(-(X_AB.R.transpose() * face.normal), vb);
    const double way = face.offset - face.normal.dot(X_AB * B.vertices()[vb]);
    if (way < least) {
      least = way;
      best = face.normal;
    }
  }
  for (const auto& face : B.faces()) {
    const Vector3 n_A = X_AB.R * face.normal;
    va = A.support(-n_A, va);
    const double way = face.offset + n_A.dot(X_AB.p - A.vertices()[va]);
    if (way < least) {
      least = way;
      best = -n_A;
    }
  }
  return best;
}

namespace {

/// Four vectors side by side.
struct Vectors {
  Lanes x, y, z;

  Vectors operator+(const Vectors& o) const { return {x + o.x, y + o.y, z + o.z}; }
  Vectors operator-(const Vectors& o) const { return {x - o.x, y - o.y, z - o.z}; }
  Vector3 total() const { return {sum(x), sum(y), sum(z)}; }
};

Lanes dot(const Vectors& a, const Vectors& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vectors cross(const Vectors& a, const Vectors& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Vectors spread(const Vector3& v) {
  return {lanes(v.x()), lanes(v.y()), lanes(v.z())};
}
/// Four vectors from memory; the double behind each is read too, and dropped.
Vectors gather(const double* a, const double* b, const double* c, const double* d) {
  Vectors v;
  transpose(loadLanes(a), loadLanes(b), loadLanes(c), loadLanes(d), v.x, v.y, v.z);
  return v;
}

/// ∫ 1, (x, y, z) and r rᵀ over V about o, times 6, 24 and 120, of four edges at a time.
struct VolumeSums {
  Lanes volume = lanes(0), x = volume, y = volume, z = volume, xx = volume, xy = volume, yy = volume;

  /// Tetrahedra (o, m, p, q) of six times the volume v.
  void add(const Lanes& v, const Vectors& m, const Vectors& p, const Vectors& q) {
    const Vectors t = m + (p + q);
    volume += v;
    x += v * t.x;
    y += v * t.y;
    z += v * t.z;
    xx += v * (t.x * t.x + m.x * m.x + (p.x * p.x + q.x * q.x));
    xy += v * (t.x * t.y + m.x * m.y + (p.x * p.y + q.x * q.y));
    yy += v * (t.y * t.y + m.y * m.y + (p.y * p.y + q.y * q.y));
  }
};

/// ∫ 1, r and r rᵀ over the projection about o, times 2, 6 and 24, of four edges at a time.
struct AreaSums {
  Lanes area = lanes(0), x = area, y = area, xx = area, xy = area, yy = area;

  void add(const Lanes& px, const Lanes& py, const Lanes& qx, const Lanes& qy) {
    const Lanes a = px * qy - py * qx, sx = px + qx, sy = py + qy;
    area += a;
    x += a * sx;
    y += a * sy;
    xx += a * (sx * sx + px * px + qx * qx);
    xy += a * (sx * sy + px * py + qx * qy);
    yy += a * (sy * sy + py * py + qy * qy);
  }
};

}  // namespace

/// The sums of `MomentSums`, four edges at a time, about a vertex o of V: products then have V's size, not that of its
/// distance from A's origin.
class ContactIntegrator {
 public:
  explicit ContactIntegrator(ContactWorkspace& w)
      : w_(w), o_(w.vertices_[w.edges_[0].from]), origin_(spread(o_)), end_(w.edges_.size()) {
    // Edges of no length fill up the last group: they add nothing.
    for (int i = 0; i < 3; ++i) w_.edges_.push_back({0, 0, 0, 0});
  }
  ~ContactIntegrator() { w_.edges_.resize(end_); }

  const Vector3& origin() const { return o_; }

  /// S_A = ½ Σ p × q over the seam, as A's side runs along it: all other edges of A's part are passed twice,
  /// in opposite directions. `scale` gets the sum of the terms' sizes.
  Vector3 seamAreaVector(double& scale) const {
    Vectors total{lanes(0), lanes(0), lanes(0)};
    Lanes sizes = lanes(0);
    for (int i = w_.seam_begin_; i < end_; i += 4) {
      const Vectors c = cross(from(i), to(i));
      total = total + c;
      sizes += absolute(c.x) + absolute(c.y) + absolute(c.z);
    }
    scale = 0.5 * sum(sizes);
    return 0.5 * total.total();
  }

  /// True when a hidden face bounds V.
  bool isOnJoint(const HiddenFaces& hidden) const {
    for (const ContactFace& face : w_.faces_) {
      const std::uint64_t* bits = face.owner == Owner::kA ? hidden.a : hidden.b;
      if (bits && HiddenFaces::has(bits, face.index)) return true;
    }
    return false;
  }

  /// Moments about o in the axes R = R_AP, and V's extent along the last of them.
  void integrate(const Matrix3& R, MomentSums& sums, double& depth) const {
    const Vectors axes[3] = {spread(R.col(0)), spread(R.col(1)), spread(R.col(2))};
    const auto turn = [&](const Vectors& v) { return Vectors{dot(v, axes[0]), dot(v, axes[1]), dot(v, axes[2])}; };
    setFeet(R);
    VolumeSums v;
    Lanes low = lanes(0), high = low;  // o is a vertex; each other one begins or ends an edge
    for (int i = 0; i < end_; i += 4) {
      const Vectors p = turn(from(i)), q = turn(to(i)), w = cross(p, q);
      low = minimum(low, minimum(p.z, q.z));
      high = maximum(high, maximum(p.z, q.z));
      const ContactEdge* const e = &w_.edges_[i];
      const Vectors l = gather(foot(e[0].left), foot(e[1].left), foot(e[2].left), foot(e[3].left));
      v.add(dot(l, w), l, p, q);
      const Vectors r = gather(foot(e[0].right), foot(e[1].right), foot(e[2].right), foot(e[3].right));
      v.add(-dot(r, w), r, p, q);
    }
    depth = largest(high) + largest(-low);
    sums.volume = sum(v.volume) / 6;
    sums.V1 = Vector3(sum(v.x), sum(v.y), sum(v.z)) / 24;
    sums.V2 = symmetric(v.xx, v.xy, v.yy) / 120;

    AreaSums a;
    for (int i = w_.seam_begin_; i < end_; i += 4) {
      const Vectors p = from(i), q = to(i);
      a.add(dot(p, axes[0]), dot(p, axes[1]), dot(q, axes[0]), dot(q, axes[1]));
    }
    sums.A0 = sum(a.area) / 2;
    sums.A1 = Vector2(sum(a.x), sum(a.y)) / 6;
    sums.A2 = symmetric(a.xx, a.xy, a.yy) / 24;
  }

 private:
  const double* vertex(int i) const { return w_.vertices_[i].data(); }
  const double* foot(int face) const { return reinterpret_cast<const double*>(&w_.feet_[face]); }

  /// Where edges i … i + 3 begin and end, about o.
  Vectors from(int i) const {
    const ContactEdge* const e = &w_.edges_[i];
    return gather(vertex(e[0].from), vertex(e[1].from), vertex(e[2].from), vertex(e[3].from)) - origin_;
  }
  Vectors to(int i) const {
    const ContactEdge* const e = &w_.edges_[i];
    return gather(vertex(e[0].to), vertex(e[1].to), vertex(e[2].to), vertex(e[3].to)) - origin_;
  }

  /// The points of the faces' planes nearest to o, in the axes R.
  void setFeet(const Matrix3& R) const {
    const Lanes rows[3] = {
        {R(0, 0), R(0, 1), R(0, 2), 0}, {R(1, 0), R(1, 1), R(1, 2), 0}, {R(2, 0), R(2, 1), R(2, 2), 0}};
    w_.feet_.clear();
    for (const ContactFace& f : w_.faces_) {
      const Vector3& n = f.normal;
      w_.feet_.push_back(lanes(f.offset - n.dot(o_)) *
                         (rows[0] * lanes(n.x()) + rows[1] * lanes(n.y()) + rows[2] * lanes(n.z())));
    }
  }

  static Matrix2 symmetric(const Lanes& xx, const Lanes& xy, const Lanes& yy) {
    const double off_diagonal = sum(xy);
    return (Matrix2() << sum(xx), off_diagonal, off_diagonal, sum(yy)).finished();
  }

  ContactWorkspace& w_;
  const Vector3 o_;
  const Vectors origin_;
  const int end_;
};

bool integrateContact(ContactWorkspace& w, const ConvexPolyhedron& A, const ConvexPolyhedron& B,
                      const Pose& X_AB, PairCache& cache, NormalRule rule, const HiddenFaces& hidden,
                      ContactVolume& out) noexcept {
  if (w.edges().empty()) return false;
  ContactIntegrator integrator(w);
  double scale = 0;
  out.area_vector_A = integrator.seamAreaVector(scale);
  if ((hidden.a || hidden.b) && integrator.isOnJoint(hidden)) out.flags |= ContactVolume::kOnJoint;
  const double size = out.area_vector_A.norm();
  Vector3 n;
  const bool remembered = cache.normal.squaredNorm() > 0;
  if (rule == NormalRule::kHistory && remembered) {
    n = cache.normal;
  } else if (size > kVanishing * scale) {
    n = out.area_vector_A / size;
  } else {
    n = remembered ? cache.normal : shortestWayOut(A, B, X_AB);
    out.flags |= ContactVolume::kNormalFromHistory;
  }
  const Matrix3 R = patchAxes(n);
  MomentSums sums;
  integrator.integrate(R, sums, out.depth);
  cache.normal = cache.direction = n;
  if (!(sums.volume > 0)) return false;
  const Vector3 centroid = sums.V1 / sums.volume;
  const MomentSums central = sums.about(centroid);
  out.X_AP = {R, integrator.origin() + R * centroid};
  out.volume = central.volume;
  out.V2 = central.V2;
  out.A0 = central.A0;
  out.A1 = central.A1;
  out.A2 = central.A2;
  return true;
}

}  // namespace haptic
