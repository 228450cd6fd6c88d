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

/// Sums of four edges at a time.
struct LaneSums {
  Lanes volume = lanes(0), x = lanes(0), y = lanes(0), z = lanes(0), xx = lanes(0), xy = lanes(0),
        yy = lanes(0);

  /// Tetrahedra (o, m, p, q) of signed volume v/6; `sum` = p + q and `square` = p pᵀ + q qᵀ.
  void add(const Lanes& v, const Lanes& mx, const Lanes& my, const Lanes& mz, const Lanes* sum_pq,
           const Lanes* square) {
    const Lanes sx = mx + sum_pq[0], sy = my + sum_pq[1], sz = mz + sum_pq[2];
    volume += v;
    x += v * sx;
    y += v * sy;
    z += v * sz;
    xx += v * (sx * sx + mx * mx + square[0]);
    xy += v * (sx * sy + mx * my + square[1]);
    yy += v * (sy * sy + my * my + square[2]);
  }
};

Matrix2 symmetric(double xx, double xy, double yy) {
  return (Matrix2() << xx, xy, xy, yy).finished();
}

/// x·a + y·b + z·c with v = (x, y, z): v in the axes whose columns are a, b, c.
Lanes rotate(const Lanes* axes, const Vector3& v) {
  return axes[0] * lanes(v.x()) + axes[1] * lanes(v.y()) + axes[2] * lanes(v.z());
}

}  // namespace

/// The sums of `MomentSums`, four edges at a time.
class ContactIntegrator {
 public:
  ContactIntegrator(ContactWorkspace& w) : w_(w), o_(w.vertices_[w.edges_[0].from]) {}

  /// S_A = ½ Σ p × q over the seam, as A's side runs along it: all other edges of A's part are passed twice,
  /// in opposite directions. `scale` gets the sum of the terms' sizes.
  Vector3 seamAreaVector(double& scale) const {
    Lanes total = lanes(0), sizes = lanes(0);
    for (int i = w_.seam_begin_; i < w_.edges_.size(); ++i) {
      const Lanes p = point(w_.edges_[i].from), q = point(w_.edges_[i].to);
      const Lanes c = p * turned(q) - turned(p) * q;
      total += c;
      sizes += absolute(c);
    }
    total = turned(total);
    scale = 0.5 * (sizes[0] + sizes[1] + sizes[2]);
    return 0.5 * Vector3(total[0], total[1], total[2]);
  }

  /// True when a hidden face bounds V.
  bool isOnJoint(const HiddenFaces& hidden) const {
    for (const ContactFace& face : w_.faces_) {
      const std::uint64_t* bits = face.owner == Owner::kA ? hidden.a : hidden.b;
      if (bits && HiddenFaces::has(bits, face.index)) return true;
    }
    return false;
  }

  /// Vertices and the planes' foot points (nearest to o), about o in the axes R = R_AP.
  void project(const Matrix3& R) {
    const Lanes axes[3] = {
        {R(0, 0), R(0, 1), R(0, 2), 0}, {R(1, 0), R(1, 1), R(1, 2), 0}, {R(2, 0), R(2, 1), R(2, 2), 0}};
    w_.local_points_.clear();
    for (const Vector3& x : w_.vertices_) w_.local_points_.push_back(rotate(axes, x - o_));
    w_.feet_.clear();
    for (const ContactFace& f : w_.faces_)
      w_.feet_.push_back(lanes(f.offset - f.normal.dot(o_)) * rotate(axes, f.normal));
  }

  double depth() const {
    Lanes low = w_.local_points_[0], high = low;
    for (const Lanes& x : w_.local_points_) {
      low = minimum(low, x);
      high = maximum(high, x);
    }
    return high[2] - low[2];
  }

  void integrate(MomentSums& sums) {
    // Edges of no length fill up the last group: they add nothing.
    while (w_.edges_.size() % 4 != 0 && w_.edges_.push_back({0, 0, 0, 0})) ++padding_;
    LaneSums s;
    for (int i = 0; i + 4 <= w_.edges_.size(); i += 4) addGroup(&w_.edges_[i], s);
    w_.edges_.resize(w_.edges_.size() - padding_);
    sums.volume = sum(s.volume) / 6;
    sums.V1 = Vector3(sum(s.x), sum(s.y), sum(s.z)) / 24;
    sums.V2 = symmetric(sum(s.xx), sum(s.xy), sum(s.yy)) / 120;
    addSeam(sums);
  }

 private:
  /// A vertex about o, and something in the fourth lane (storage goes on beyond the last vertex).
  Lanes point(int i) const { return loadLanes(w_.vertices_[i].data()) - Lanes{o_.x(), o_.y(), o_.z(), 0}; }

  void addGroup(const ContactEdge* e, LaneSums& s) const {
    const LoadedVector<Lanes>&x = w_.local_points_, &m = w_.feet_;
    Lanes px, py, pz, qx, qy, qz, lx, ly, lz, rx, ry, rz;
    transpose(x[e[0].from], x[e[1].from], x[e[2].from], x[e[3].from], px, py, pz);
    transpose(x[e[0].to], x[e[1].to], x[e[2].to], x[e[3].to], qx, qy, qz);
    transpose(m[e[0].left], m[e[1].left], m[e[2].left], m[e[3].left], lx, ly, lz);
    transpose(m[e[0].right], m[e[1].right], m[e[2].right], m[e[3].right], rx, ry, rz);
    const Lanes wx = py * qz - pz * qy, wy = pz * qx - px * qz, wz = px * qy - py * qx;
    const Lanes sum_pq[3] = {px + qx, py + qy, pz + qz};
    const Lanes square[3] = {px * px + qx * qx, px * py + qx * qy, py * py + qy * qy};
    s.add(lx * wx + ly * wy + lz * wz, lx, ly, lz, sum_pq, square);
    s.add(-(rx * wx + ry * wy + rz * wz), rx, ry, rz, sum_pq, square);
  }

  void addSeam(MomentSums& sums) const {
    Lanes a0 = lanes(0), ax = a0, ay = a0, axx = a0, axy = a0, ayy = a0;
    static constexpr ContactEdge kNone{0, 0, 0, 0};
    for (int i = w_.seam_begin_; i < w_.edges_.size(); i += 4) {
      Lanes px, py, pz, qx, qy, qz;
      const auto edge = [&](int k) -> const ContactEdge& {
        return i + k < w_.edges_.size() ? w_.edges_[i + k] : kNone;
      };
      const LoadedVector<Lanes>& x = w_.local_points_;
      transpose(x[edge(0).from], x[edge(1).from], x[edge(2).from], x[edge(3).from], px, py, pz);
      transpose(x[edge(0).to], x[edge(1).to], x[edge(2).to], x[edge(3).to], qx, qy, qz);
      const Lanes a = px * qy - py * qx, sx = px + qx, sy = py + qy;
      a0 += a;
      ax += a * sx;
      ay += a * sy;
      axx += a * (sx * sx + px * px + qx * qx);
      axy += a * (sx * sy + px * py + qx * qy);
      ayy += a * (sy * sy + py * py + qy * qy);
    }
    sums.A0 = sum(a0) / 2;
    sums.A1 = Vector2(sum(ax), sum(ay)) / 6;
    sums.A2 = symmetric(sum(axx), sum(axy), sum(ayy)) / 24;
  }

  ContactWorkspace& w_;
  const Vector3 o_;  // a vertex of V: products then have V's size, not that of its distance from A's origin
  int padding_ = 0;
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
  integrator.project(R);
  integrator.integrate(sums);
  out.depth = integrator.depth();
  cache.normal = cache.direction = n;
  if (!(sums.volume > 0)) return false;
  const Vector3 centroid = sums.V1 / sums.volume;
  const MomentSums central = sums.about(centroid);
  out.X_AP = {R, w.vertices()[w.edges()[0].from] + R * centroid};
  out.volume = central.volume;
  out.V2 = central.V2;
  out.A0 = central.A0;
  out.A1 = central.A1;
  out.A2 = central.A2;
  return true;
}

}  // namespace haptic
