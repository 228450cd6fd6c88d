/// Volume, first moment and area vector of ball ∩ polyhedron in 113 bits, by another way than the code under test.
///
/// Everything is seen from the ball's centre. On each face the signed sum over the polygon's edges of what the triangle
/// (foot of the centre, p, q) has in common with the disc needs no topology. The part of the sphere inside has the solid
/// angle 4π (centre inside) or 0, less those of the faces' parts, and the area vector that closes the surface. The terms of
/// these sums cancel where an overlap is small; 113 bits bear it.
#pragma once
#include <quadmath.h>

#include <array>

#include "haptic_core/geometry/shapes/convex_polyhedron.h"

namespace haptic::oracle {

struct BallOverlap {
  using Real = __float128;
  using Vec = std::array<Real, 3>;
  Real volume = 0;
  Vec first{};        ///< ∫ y dV about the ball's centre
  Vec area_vector{};  ///< of the faces' parts, outward

  BallOverlap(const ConvexPolyhedron& shape, const Vector3& centre, double radius) {
    const Real R = radius;
    const Vec c = wide(centre);
    Real solid = 0;
    bool inside = true;
    for (int f = 0; f < shape.faceCount(); ++f) {
      const auto& face = shape.faces()[f];
      // The plane by its corners, not by its rounded normal.
      Vec n{};
      const Vec o = corner(shape, f, 0);
      for (int i = 1; i + 1 < face.count; ++i) {
        const Vec m = cross(sub(corner(shape, f, i), o), sub(corner(shape, f, i + 1), o));
        for (int k = 0; k < 3; ++k) n[k] += m[k];
      }
      const Real length = sqrtq(dot(n, n));
      for (int k = 0; k < 3; ++k) n[k] /= length;
      const Real h = dot(n, sub(o, c));
      inside = inside && h >= 0;
      if (h >= R || h <= -R) continue;
      Vec axis{};
      axis[fabsq(n[0]) < Real(0.6) ? 0 : 1] = 1;
      Vec x = cross(axis, n);
      const Real across = sqrtq(dot(x, x));
      for (int k = 0; k < 3; ++k) x[k] /= across;
      const Vec y = cross(n, x);
      const Real a2 = (R - h) * (R + h);
      FaceSums sums{R, h, a2, sqrtq(a2)};
      for (int i = 0; i < face.count; ++i) {
        const Vec p = sub(corner(shape, f, i), c), q = sub(corner(shape, f, (i + 1) % face.count), c);
        sums.addEdge(dot(x, p), dot(y, p), dot(x, q), dot(y, q));
      }
      solid -= sums.solid;
      volume += h / 3 * sums.area;
      for (int k = 0; k < 3; ++k) {
        first[k] += h / 4 * (h * n[k] * sums.area + x[k] * sums.mx + y[k] * sums.my);
        area_vector[k] += n[k] * sums.area;
      }
    }
    if (inside) solid += 4 * acosq(-1);
    volume += R * R * R / 3 * solid;
    for (int k = 0; k < 3; ++k) first[k] -= R * R / 4 * area_vector[k];  // R⁴/4 ∫ n dΩ, and R² ∫ n dΩ = -Σ S
  }

 private:
  struct FaceSums {
    Real R, h, a2, a;
    Real area = 0, mx = 0, my = 0, solid = 0;

    /// Inside the disc from p to q (seen from its centre).
    void addLine(Real px, Real py, Real qx, Real qy) {
      const Real turn = px * qy - py * qx;
      area += turn / 2;
      mx += turn / 6 * (px + qx);
      my += turn / 6 * (py + qy);
      // ∫ (1 - h/√(h² + ρ²)) dφ along the line at distance e: Δφ - [asin(h sin φ/√(h² + e²))], h of either sign.
      const Real dx = qx - px, dy = qy - py, length2 = dx * dx + dy * dy;
      if (length2 == 0 || turn == 0) return;
      const Real length = sqrtq(length2), e = turn / length;
      const Real up = (px * dx + py * dy) / length, uq = (qx * dx + qy * dy) / length;
      const Real away = fabsq(e);
      const auto part = [&](Real u) { return atan2q(u * h, away * sqrtq(h * h + e * e + u * u)); };
      const Real seen = part(uq) - part(up);
      solid += atan2q(turn, px * qx + py * qy) * (h < 0 ? -1 : 1) - (e < 0 ? -seen : seen);
    }

    void addArc(Real px, Real py, Real qx, Real qy) {
      const Real sweep = atan2q(px * qy - py * qx, px * qx + py * qy);
      const Real p = atan2q(py, px), q = p + sweep;
      area += a2 / 2 * sweep;
      mx += a2 * a / 3 * (sinq(q) - sinq(p));
      my += a2 * a / 3 * (cosq(p) - cosq(q));
      solid += sweep * ((h < 0 ? -1 : 1) - h / R);
    }

    void addEdge(Real px, Real py, Real qx, Real qy) {
      const Real dx = qx - px, dy = qy - py, A = dx * dx + dy * dy, B = px * dx + py * dy, C = px * px + py * py - a2;
      const Real D = B * B - A * C;
      Real t0 = 1, t1 = 1;
      if (D > 0) {
        t0 = (-B - sqrtq(D)) / A;
        t1 = (-B + sqrtq(D)) / A;
      }
      if (!(D > 0) || t1 <= 0 || t0 >= 1) return addArc(px, py, qx, qy);
      t0 = t0 < 0 ? 0 : t0;
      t1 = t1 > 1 ? 1 : t1;
      const Real ax = px + t0 * dx, ay = py + t0 * dy, bx = px + t1 * dx, by = py + t1 * dy;
      if (t0 > 0) addArc(px, py, ax, ay);
      addLine(ax, ay, bx, by);
      if (t1 < 1) addArc(bx, by, qx, qy);
    }
  };

  static Vec wide(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
  static Vec corner(const ConvexPolyhedron& shape, int face, int i) {
    return wide(shape.vertices()[shape.loopVertex(shape.faces()[face].first + i)]);
  }
  static Vec sub(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
  static Real dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
  static Vec cross(const Vec& a, const Vec& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
};

}  // namespace haptic::oracle
