#include "haptic_core/contact/sliding_friction.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/base/lanes.h"

namespace haptic {
namespace {

/// Faces steeper than this are left out: they carry less than kEdgeOn · depth/(2 · size) of the force, and their
/// heights, continued to a far instant centre, would cancel.
constexpr double kEdgeOn = 1e-3;

Vector2 turned(const Vector2& a) { return Vector2(-a.y(), a.x()); }

/// Second-order series in κ = ω/|v|: with ξ along the slip and η across, t̂ = (1 - κ²ξ²/2, κξ + κ²ξη).
SlidingIntegral nearTranslation(const PressureMoments& m, const Vector2& v, double w) {
  const double speed = v.norm(), kappa = w / speed;
  const Vector2 e = v / speed, across = turned(e);
  const double xx = e.dot(m.second * e), xy = e.dot(m.second * across);
  SlidingIntegral out;
  out.force = (m.force - 0.5 * kappa * kappa * xx) * e + (kappa * e.dot(m.first) + kappa * kappa * xy) * across;
  out.torque = kappa * xx - across.dot(m.first);
  return out;
}

/// Weight of a face as a polynomial of x = r - c: w0 + w1·x + xᵀ W x, times the projected area element.
struct FaceWeight {
  double w0 = 0;
  Vector2 w1 = Vector2::Zero();
  Matrix2 W = Matrix2::Zero();
};

/// Height of the face above P times the part of p that grows with d, plus p's other part on A's faces.
FaceWeight faceWeight(const Vector3& normal_P, double height0, bool of_a, const PressureField& p, const Vector2& c) {
  const Vector2 slope = -normal_P.head<2>() / normal_P.z();
  const double z = height0 + slope.dot(c);
  const double k = p.k0 + p.k1.dot(c);
  FaceWeight out;
  out.w0 = z * k;
  out.w1 = z * p.k1 + k * slope;
  out.W = 0.5 * (slope * p.k1.transpose() + p.k1 * slope.transpose());
  if (of_a) {
    out.w0 += p.b0 + p.b1.dot(c);
    out.w1 += p.b1;
  }
  return out;
}

/// ∫ uᵐ/R and ∫ uᵐ R from u0 to u1, R = sqrt(e² + u²), e > 0.
struct EdgeIntegrals {
  double I[4], K[3];
  EdgeIntegrals(double e, double u0, double u1) {
    const double e2 = e * e;
    const double R0 = std::sqrt(e2 + u0 * u0), R1 = std::sqrt(e2 + u1 * u1);
    const double cubes = (R1 * R1 * R1 - R0 * R0 * R0) / 3;
    const double product = u1 * R1 - u0 * R0;
    // asinh(u1/e) - asinh(u0/e) as one, without their cancellation.
    I[0] = elementary::asinh(u0 * u1 > 0 ? (u1 - u0) * (u1 + u0) / (u1 * R0 + u0 * R1) : (u1 * R0 - u0 * R1) / e2);
    I[1] = R1 - R0;
    I[2] = 0.5 * (product - e2 * I[0]);
    I[3] = cubes - e2 * I[1];
    K[0] = 0.5 * (product + e2 * I[0]);
    K[1] = cubes;
    K[2] = 0.25 * (u1 * R1 * R1 * R1 - u0 * R0 * R0 * R0) - 0.25 * e2 * K[0];
  }
};

/// ∫ p x/|x| and ∫ p |x| over the triangle from the instant centre to the edge from → to, signed.
struct CentreSums {
  Vector2 direction = Vector2::Zero();
  double distance = 0;

  void add(const FaceWeight& weight, const Vector2& normal, const Vector2& along, double e, const EdgeIntegrals& g,
           double sign) {
    const double a1 = weight.w1.dot(normal), b1 = weight.w1.dot(along);
    const double aa = normal.dot(weight.W * normal), ab = normal.dot(weight.W * along),
                 bb = along.dot(weight.W * along);
    // w0/2 + w1·x/3 + xᵀWx/4 with x = e normal + u along, as a polynomial of u.
    const double q0 = weight.w0 / 2 + e * a1 / 3 + e * e * aa / 4, q1 = b1 / 3 + e * ab / 2, q2 = bb / 4;
    direction += sign * e * (e * (q0 * g.I[0] + q1 * g.I[1] + q2 * g.I[2]) * normal +
                             (q0 * g.I[1] + q1 * g.I[2] + q2 * g.I[3]) * along);
    const double r0 = weight.w0 / 3 + e * a1 / 4 + e * e * aa / 5, r1 = b1 / 4 + 2 * e * ab / 5, r2 = bb / 5;
    distance += sign * e * (r0 * g.K[0] + r1 * g.K[1] + r2 * g.K[2]);
  }
};

/// Rule of degree 5 on a triangle (Radon 1948): weights and barycentric places of its seven points, four at a time; the
/// eighth counts nothing.
constexpr double kThird = 1.0 / 3, kInner = 0.10128650732345633, kOuter = 0.47014206410511508;
constexpr double kInnerWeight = 0.12593918054482717, kOuterWeight = 0.13239415278850616;
struct RulePoints {
  double weight[4], a[4], b[4], c[4];
};
constexpr RulePoints kTriangleRule[2] = {{{0.225, kInnerWeight, kInnerWeight, kInnerWeight},
                                          {kThird, 1 - 2 * kInner, kInner, kInner},
                                          {kThird, kInner, 1 - 2 * kInner, kInner},
                                          {kThird, kInner, kInner, 1 - 2 * kInner}},
                                         {{kOuterWeight, kOuterWeight, kOuterWeight, 0},
                                          {1 - 2 * kOuter, kOuter, kOuter, kThird},
                                          {kOuter, 1 - 2 * kOuter, kOuter, kThird},
                                          {kOuter, kOuter, 1 - 2 * kOuter, kThird}}};

/// The slip's traction by the rule, four points at a time.
struct RuleSums {
  Lanes vx, vy, w;
  Lanes x = lanes(0), y = x, torque = x;

  RuleSums(const Vector2& v, double spin) : vx(lanes(v.x())), vy(lanes(v.y())), w(lanes(spin)) {}

  /// Over the triangle (a, b, c) of signed area `area`.
  void add(const Vector2& a, const Vector2& b, const Vector2& c, double area, const FaceWeight& f) {
    const Lanes constant = lanes(area * f.w0), along_x = lanes(area * f.w1.x()), along_y = lanes(area * f.w1.y());
    const Lanes xx = lanes(area * f.W(0, 0)), xy = lanes(2 * area * f.W(0, 1)), yy = lanes(area * f.W(1, 1));
    for (const RulePoints& q : kTriangleRule) {
      const Lanes qa = loadLanes(q.a), qb = loadLanes(q.b), qc = loadLanes(q.c);
      const Lanes rx = qa * lanes(a.x()) + qb * lanes(b.x()) + qc * lanes(c.x());
      const Lanes ry = qa * lanes(a.y()) + qb * lanes(b.y()) + qc * lanes(c.y());
      const Lanes sx = vx - w * ry, sy = vy + w * rx;
      const Lanes load = loadLanes(q.weight) * (constant + rx * (along_x + xx * rx + xy * ry) + ry * (along_y + yy * ry));
      const Lanes scale = load / squareRoot(sx * sx + sy * sy);
      const Lanes tx = scale * sx, ty = scale * sy;
      x += tx;
      y += ty;
      torque += rx * ty - ry * tx;
    }
  }
};

/// Visits (from, to, left, right) for the edges of V, in P's frame. `clipped`: of the part of V over which k0 + k1·r is not negative; the
/// cut closes the outline of each face that it goes through, and has no other one: right is -1.
template <class Visit>
void eachEdge(ContactWorkspace& workspace, const ContactVolume& contact, const PressureField& pressure, bool clipped, Visit&& visit) {
  const Matrix3 R_PA = contact.X_AP.R.transpose();
  const auto place = [&](int vertex) -> Vector3 { return R_PA * (workspace.vertices()[vertex] - contact.X_AP.p); };
  if (!clipped) {
    for (const ContactEdge& edge : workspace.edges()) visit(place(edge.from), place(edge.to), edge.left, edge.right);
    return;
  }
  LoadedVector<Vector3> &leave = workspace.leaves(), &back = workspace.returns();
  leave.clear();
  back.clear();
  for (int f = 0; f < workspace.faces().size(); ++f) {
    leave.push_back(Vector3::Zero());
    back.push_back(Vector3::Zero());
  }
  for (const ContactEdge& edge : workspace.edges()) {
    Vector3 p = place(edge.from), q = place(edge.to);
    const double hp = pressure.k0 + pressure.k1.dot(p.head<2>()), hq = pressure.k0 + pressure.k1.dot(q.head<2>());
    if (hp < 0 && hq < 0) continue;
    if (hp < 0 || hq < 0) {
      const Vector3 x = p + hp / (hp - hq) * (q - p);
      (hq < 0 ? leave : back)[edge.left] = (hq < 0 ? back : leave)[edge.right] = x;
      (hq < 0 ? q : p) = x;
    }
    visit(p, q, edge.left, edge.right);
  }
  for (int f = 0; f < workspace.faces().size(); ++f) visit(leave[f], back[f], f, -1);
}

/// A face of V over the patch: its middle and its weight about P.
struct PatchFace {
  Vector2 middle = Vector2::Zero();
  FaceWeight weight;
  bool counts = false;
};

PatchFace patchFace(const ContactFace& face, const Vector3& middle_A, const Pose& X_AP, const Matrix3& R_PA,
                    const PressureField& pressure) {
  const Vector3 n = R_PA * face.normal;
  if (std::abs(n.z()) < kEdgeOn) return {};
  const Vector3 middle = R_PA * (middle_A - X_AP.p);
  return {middle.head<2>(), faceWeight(n, n.dot(middle) / n.z(), face.owner == Owner::kA, pressure, Vector2::Zero()), true};
}

/// The rule on the triangles from each face's middle to its edges, all about P: nothing cancels.
SlidingIntegral byRule(ContactWorkspace& workspace, const ContactVolume& contact, const PressureField& pressure, bool clipped,
                       const Vector2& v, double w) {
  constexpr int kKept = 64;  // faces that are prepared once; later ones at each of their edges
  const Matrix3 R_PA = contact.X_AP.R.transpose();
  const LoadedVector<Vector3>& middles = workspace.faceCentres();
  const auto prepared = [&](int f) { return patchFace(workspace.faces()[f], middles[f], contact.X_AP, R_PA, pressure); };
  PatchFace kept[kKept];
  for (int f = 0; f < std::min(kKept, workspace.faces().size()); ++f) kept[f] = prepared(f);
  RuleSums sums(v, w);
  eachEdge(workspace, contact, pressure, clipped, [&](const Vector3& from, const Vector3& to, int left, int right) {
    const Vector2 b = from.head<2>(), c = to.head<2>();
    for (int half : {0, 1}) {
      const int f = half == 0 ? left : right;
      if (f < 0) continue;
      const PatchFace& face = f < kKept ? kept[f] : prepared(f);
      if (!face.counts) continue;
      const Vector2 &a = face.middle, ab = b - a, ac = c - a;
      sums.add(a, b, c, (half == 0 ? 0.5 : -0.5) * (ab.x() * ac.y() - ab.y() * ac.x()), face.weight);
    }
  });
  SlidingIntegral out;
  out.force = Vector2(sum(sums.x), sum(sums.y));
  out.torque = sum(sums.torque);
  return out;
}

/// Instant centres nearer than this, in patch radii, need more points around a patch than rays from them.
constexpr double kNearRound = 1.7;

/// Points around a ring of `share` of the way to the instant centre: the direction of slip is a series in powers of it, of which
/// this many leave 1e-12. Four more for the pressure, the arm and the remainder.
int anglesFor(double share) { return 4 + static_cast<int>(std::ceil(elementary::log(1e-12) / elementary::log(share))); }

/// Over a round patch, on rays from the instant centre where that lies within it: along each the direction is constant. Where V is
/// round about n and the centre well outside, on rings.
SlidingIntegral overRound(const RoundPatch& patch, const PressureField& p, const Vector2& v, double w, double radius) {
  SlidingIntegral out;
  const auto add = [&](const Vector2& r, double weight, double d) {
    const Vector2 slip = v + w * turned(r);
    const double speed = slip.norm(), pressure = std::max(0.0, d * (p.k0 + p.k1.dot(r)) + p.b0 + p.b1.dot(r));
    if (!(speed > 0)) return;
    const Vector2 traction = weight * pressure / speed * slip;
    out.force += traction;
    out.torque += r.x() * traction.y() - r.y() * traction.x();
  };
  const double share = std::abs(w) * radius / v.norm();
  if (patch.isAxial() && share * kNearRound < 1) {
    patch.eachOnRings(anglesFor(share), add);
  } else if (share > 1) {
    patch.eachSampleAbout(turned(v) / w, add);
  } else {
    patch.eachSample(add);
  }
  return out;
}

}  // namespace

SlidingIntegral slidingIntegral(ContactWorkspace& workspace, const ContactVolume& contact, const PressureField& pressure,
                                const PressureMoments& moments, const Vector2& v, double w, double radius, bool clipped) noexcept {
  const double speed = v.norm();
  if (speed == 0 && w == 0) return {};
  if (std::abs(w) * radius * kFarCentre < speed) return nearTranslation(moments, v, w);
  if (workspace.round().filled) return overRound(RoundPatch(workspace.round(), contact).fit(), pressure, v, w, radius);
  if (std::abs(w) * radius * kNearCentre < speed) return byRule(workspace, contact, pressure, clipped, v, w);
  const Vector2 centre = turned(v) / w;  // v + ω ẑ × c = 0
  const Matrix3 R_PA = contact.X_AP.R.transpose();
  // An edge through the centre has no triangle; closer than this it adds less than rounding.
  const double smallest = 1e-12 * radius;
  CentreSums sums;
  eachEdge(workspace, contact, pressure, clipped, [&](const Vector3& from3, const Vector3& to3, int left, int right) {
    const Vector2 from = from3.head<2>() - centre, to = to3.head<2>() - centre;
    const double length = (to - from).norm();
    if (length <= smallest) return;
    const Vector2 along = (to - from) / length;
    Vector2 normal(along.y(), -along.x());  // right of the edge
    double e = normal.dot(from), side = 1;
    if (e < 0) {
      e = -e;
      normal = -normal;
      side = -1;
    }
    if (e <= smallest) return;
    const EdgeIntegrals g(e, along.dot(from), along.dot(to));
    for (int half : {0, 1}) {  // the loop of `left` runs from → to, that of `right` back
      const int f = half == 0 ? left : right;
      if (f < 0) continue;
      const ContactFace& face = workspace.faces()[f];
      const Vector3 n = R_PA * face.normal;
      if (std::abs(n.z()) < kEdgeOn) continue;
      const double height0 = n.dot(from3) / n.z();
      const FaceWeight weight = faceWeight(n, height0, face.owner == Owner::kA, pressure, centre);
      sums.add(weight, normal, along, e, g, half == 0 ? side : -side);
    }
  });
  const double turn = w > 0 ? 1.0 : -1.0;
  SlidingIntegral out;
  out.force = turn * turned(sums.direction);
  // About P: x × (ẑ × x/|x|) = |x|, plus the centre's arm.
  out.torque = turn * sums.distance + centre.x() * out.force.y() - centre.y() * out.force.x();
  return out;
}

}  // namespace haptic
