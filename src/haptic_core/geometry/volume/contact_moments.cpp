#include "haptic_core/geometry/volume/contact_moments.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "haptic_core/geometry/volume/covered_area.h"
#include "haptic_core/geometry/volume/moment_sums.h"

namespace haptic {
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

/// Cosine of an angle to a face's normal that is worth an exact look.
constexpr double kNearlyFlush = 1 - 1e-9;

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

/// ∫ 1, (x, y, z) and r rᵀ over V about o, times 6, 24 and 60, of four edges at a time.
///
/// An edge p → q of faces with feet l and r gives the tetrahedra (o, l, p, q) of six times the volume l·(p × q) and
/// (o, r, q, p) of -r·(p × q). With s = p + q, and a, b the volumes times l and r, their sums are a + b + u s and
/// a lᵀ + b rᵀ + ½ ((a + b) sᵀ + s (a + b)ᵀ) + u (s sᵀ - ½ (p qᵀ + q pᵀ)), u being both volumes together.
struct VolumeSums {
  Lanes volume = lanes(0), x = volume, y = volume, z = volume, xx = volume, xy = volume, yy = volume;

  /// Returns twice the projected areas of (o, p, q).
  Lanes add(const Vectors& p, const Vectors& q, const Vectors& l, const Vectors& r) {
    const Lanes pxqy = p.x * q.y, pyqx = p.y * q.x, half = lanes(0.5);
    const Vectors w{p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, pxqy - pyqx}, s = p + q;
    const Lanes left = dot(l, w), right = -dot(r, w), u = left + right;
    const Vectors a{left * l.x, left * l.y, left * l.z}, b{right * r.x, right * r.y, right * r.z}, c = a + b;
    volume += u;
    x += c.x + u * s.x;
    y += c.y + u * s.y;
    z += c.z + u * s.z;
    xx += a.x * l.x + b.x * r.x + (c.x * s.x + u * (s.x * s.x - p.x * q.x));
    yy += a.y * l.y + b.y * r.y + (c.y * s.y + u * (s.y * s.y - p.y * q.y));
    xy += a.x * l.y + b.x * r.y + (half * (c.x * s.y + c.y * s.x) + u * (s.x * s.y - half * (pxqy + pyqx)));
    return w.z;
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

/// Edges i … i + 3, where the last ones may be missing: edges of no length stand for them, which add nothing.
class FourEdges {
 public:
  FourEdges(const ContactEdge* edges, int i, int end) : first_(edges + i) {
    if (i + 4 <= end) return;
    std::fill(filled_, filled_ + 4, ContactEdge{0, 0, 0, 0});
    std::copy(edges + i, edges + end, filled_);
    first_ = filled_;
  }
  const ContactEdge& operator[](int k) const { return first_[k]; }

 private:
  const ContactEdge* first_;
  ContactEdge filled_[4];
};

/// The sums of `MomentSums`, four edges at a time, about a vertex o of V: products then have V's size, not that of its
/// distance from A's origin.
class ContactIntegrator {
 public:
  explicit ContactIntegrator(ContactWorkspace& w)
      : w_(w), edges_(w.edges_.begin()), seam_(w.seam_begin_), end_(w.edges_.size()),
        o_(w.vertices_[edges_[0].from]), origin_(spread(o_)) {}

  const Vector3& origin() const { return o_; }

  /// S_A = ½ Σ p × q over the seam, as A's side runs along it: all other edges of A's part are passed twice,
  /// in opposite directions. `scale` gets the sum of the terms' sizes.
  Vector3 seamAreaVector(double& scale) const {
    Vectors total{lanes(0), lanes(0), lanes(0)};
    Lanes sizes = lanes(0);
    for (int i = seam_; i < end_; i += 4) {
      const FourEdges e(edges_, i, end_);
      const Vectors p = gather(vertex(e[0].from), vertex(e[1].from), vertex(e[2].from), vertex(e[3].from)) - origin_;
      const Vectors q = gather(vertex(e[0].to), vertex(e[1].to), vertex(e[2].to), vertex(e[3].to)) - origin_;
      const Vectors c = cross(p, q);
      total = total + c;
      sizes += absolute(c.x) + absolute(c.y) + absolute(c.z);
    }
    scale = 0.5 * sum(sizes);
    return 0.5 * total.total();
  }

  /// Moments about o in the axes R = R_AP, and V's extent along the last of them.
  void integrate(const Matrix3& R, MomentSums& moments, double& depth) const {
    turnAll(R);
    VolumeSums v;
    AreaSums a;
    Lanes low = lanes(0), high = low;  // o is a vertex; each other one begins or ends an edge
    const auto add = [&](int i, int end, Vectors& p, Vectors& q) __attribute__((always_inline)) {
      const FourEdges e(edges_, i, end);
      p = turned(w_.turned_, e[0].from, e[1].from, e[2].from, e[3].from);
      q = turned(w_.turned_, e[0].to, e[1].to, e[2].to, e[3].to);
      low = minimum(low, minimum(p.z, q.z));
      high = maximum(high, maximum(p.z, q.z));
      const Lanes areas = v.add(p, q, turned(w_.feet_, e[0].left, e[1].left, e[2].left, e[3].left),
                                turned(w_.feet_, e[0].right, e[1].right, e[2].right, e[3].right));
      storeLanes(areas, w_.edge_areas_.begin() + i);
    };
    Vectors p, q;
    for (int i = 0; i < seam_; i += 4) add(i, seam_, p, q);
    for (int i = seam_; i < end_; i += 4) {
      add(i, end_, p, q);
      a.add(p.x, p.y, q.x, q.y);
    }
    depth = largest(high) + largest(-low);
    const Lanes first = sums(v.volume, v.x, v.y, v.z), second = sums(v.xx, v.xy, v.yy, a.area),
                area = sums(a.x, a.y, a.xx, a.xy);
    moments.volume = first[0] / 6;
    moments.V1 = Vector3(first[1], first[2], first[3]) / 24;
    moments.V2 = symmetric(second[0], second[1], second[2]) / 60;
    moments.A0 = second[3] / 2;
    moments.A1 = Vector2(area[0], area[1]) / 6;
    moments.A2 = symmetric(area[2], area[3], sum(a.yy)) / 24;
  }

  /// V's extent along the normal of the face that supports it, or `along_n`, the extent along n, if that is less. The supporting face
  /// holds the largest share of the patch: of A0 = n·S. If an edge of it crosses the patch, n leans by the depth over the patch's
  /// width, and the extent along n is up to twice that along the face's normal. After `integrate`.
  double supportedDepth(const Matrix3& R, double along_n) const {
    const int faces = w_.faces_.size();
    w_.face_areas_.resize(faces);
    double* const areas = w_.face_areas_.begin();
    for (int f = 0; f < faces; ++f) {
      if (std::abs(w_.feet_[f][3]) > kNearlyFlush && w_.faces_[f].normal.cross(R.col(2)).squaredNorm() < kFlush * kFlush) return along_n;
      areas[f] = 0;
    }
    for (int i = 0; i < end_; ++i) {
      const ContactEdge& e = edges_[i];
      areas[e.left] += w_.edge_areas_[i], areas[e.right] -= w_.edge_areas_[i];
    }
    int support = 0;
    for (int f = 1; f < faces; ++f) {
      if (std::abs(areas[f]) > std::abs(areas[support])) support = f;
    }
    const Vectors normal_P = spread(R.transpose() * w_.faces_[support].normal);
    Lanes low = lanes(0), high = low;  // o is a vertex
    const int last = w_.vertices_.size() - 1;
    for (int i = 0; i <= last; i += 4) {
      const Lanes heights =
          dot(normal_P, turned(w_.turned_, i, std::min(i + 1, last), std::min(i + 2, last), std::min(i + 3, last)));
      low = minimum(low, heights), high = maximum(high, heights);
    }
    return std::min(along_n, largest(high) + largest(-low));
  }

 private:
  const double* vertex(int i) const { return w_.vertices_[i].data(); }
  static Vectors turned(const LoadedVector<Lanes>& v, int a, int b, int c, int d) {
    Vectors four;
    transpose(v[a], v[b], v[c], v[d], four.x, four.y, four.z);
    return four;
  }

  /// V's vertices and the points of its faces' planes nearest to o, from o and in the axes R, four at a time. What lies
  /// behind the last one is worked on too, and never used.
  void turnAll(const Matrix3& R) const {
    const Vectors axes[3] = {spread(R.col(0)), spread(R.col(1)), spread(R.col(2))};
    const auto turnTo = [&](const Vectors& v, const Lanes& fourth, Lanes* to) {
      transpose(dot(v, axes[0]), dot(v, axes[1]), dot(v, axes[2]), fourth, to[0], to[1], to[2], to[3]);
    };
    for (int i = 0; i < w_.vertices_.size(); i += 4) {
      turnTo(gather(vertex(i), vertex(i + 1), vertex(i + 2), vertex(i + 3)) - origin_, lanes(0), w_.turned_.begin() + i);
    }
    const auto plane = [this](int f) { return loadLanes(w_.faces_[f].normal.data()); };  // the offset lies behind
    for (int f = 0; f < w_.faces_.size(); f += 4) {
      Vectors n;
      Lanes offset;
      transpose(plane(f), plane(f + 1), plane(f + 2), plane(f + 3), n.x, n.y, n.z, offset);
      const Lanes height = offset - dot(n, origin_);
      turnTo({height * n.x, height * n.y, height * n.z}, dot(n, axes[2]), w_.feet_.begin() + f);
    }
  }

  static Matrix2 symmetric(double xx, double xy, double yy) { return (Matrix2() << xx, xy, xy, yy).finished(); }

  ContactWorkspace& w_;
  const ContactEdge* const edges_;
  const int seam_, end_;
  const Vector3 o_;
  const Vectors origin_;
};

bool integrateContact(ContactWorkspace& w, const ConvexPolyhedron* A, const ConvexPolyhedron* B,
                      const Pose& X_AB, PairCache& cache, const ContactRequest& request,
                      ContactVolume& out) noexcept {
  if (w.edges().empty()) return false;
  ContactIntegrator integrator(w);
  double scale = 0;
  out.turns_with_b = -1;
  out.area_vector_A = integrator.seamAreaVector(scale);
  const CoveredArea covered_a = out.covered_a = coveredArea(w, Owner::kA, request.inner.a, Pose()),
                    covered_b = out.covered_b = coveredArea(w, Owner::kB, request.inner.b, X_AB);
  Vector3 surface = out.area_vector_A;
  if (covered_a.touched || covered_b.touched) out.flags |= ContactVolume::kOnSeam;
  if (covered_a.area + covered_b.area > 0) {
    const Vector3 seen = surface + (covered_b.area * covered_b.vector - covered_a.area * covered_a.vector) /
                                       (covered_a.area + covered_b.area);
    if (seen.norm() > kVanishing * scale) surface = seen;  // else nothing of V is surface
    // A side without its covered faces is one face mostly, which holds n.
    out.turns_with_b = covered_b.area / (covered_a.area + covered_b.area);
  }
  const double size = surface.norm();
  Vector3 n;
  const bool prescribed = request.normal.squaredNorm() > 0, remembered = cache.normal.squaredNorm() > 0;
  if (prescribed || (request.rule == NormalRule::kHistory && remembered)) {
    n = prescribed ? request.normal : cache.normal;
    out.turns_with_b = 0;
  } else if (size > kVanishing * scale) {
    n = surface / size;
  } else {
    n = remembered ? cache.normal : shortestWayOut(*A, *B, X_AB);
    out.flags |= ContactVolume::kNormalFromHistory;
    out.turns_with_b = 0;
  }
  const Matrix3 R = patchAxes(n);
  MomentSums sums;
  integrator.integrate(R, sums, out.depth);
  out.depth = integrator.supportedDepth(R, out.depth);
  cache.normal = cache.direction = n;
  // An edge that touches may leave a volume of rounding without extent: forces divide by it.
  if (!(sums.volume > 0) || !(out.depth > 0)) return false;
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
