#include "haptic_core/geometry/volume/tube_on_plane.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/elementary.h"
#include "haptic_core/geometry/volume/circular_segment.h"
#include "haptic_core/geometry/volume/gauss_legendre.h"

namespace haptic {
namespace {

/// Range of θ up to which 8 points integrate degree 5 to rounding [rad]; beyond, 16 do. Four would not: however short the range, a
/// wedge's second moment along the axis goes with the eighth power of θ.
constexpr double kEightPoints = 0.5;

/// ∫ over w: chord, chord w, chord w² and v², v across the chord.
struct ChordSums {
  double m0 = 0, m1 = 0, m2 = 0, across = 0;
};

ChordSums segmentOf(double R, double theta) {
  const double sine = elementary::sin(0.5 * theta), s = 2 * sine * sine, scale = 2 * R * R * s * std::sqrt(s);
  const SegmentIntegrals j(s, theta);
  return {scale * j.j0, scale * R * j.j1, scale * R * R * j.j2, scale * R * R / 3 * (2 * j.j1 - j.j2)};
}

double angleAt(double w, double R) { return 2 * elementary::asin(std::sqrt(std::min(1.0, w / (2 * R)))); }

}  // namespace

bool TubeOnPlane::find(double R, double half, const Vector3& normal, double offset) noexcept {
  const double s = normal.head<2>().norm(), c = std::abs(normal.z()), L = 2 * half, D = offset + s * R + c * half;
  k = Vector3(0, 0, normal.z() < 0 ? -1 : 1);
  e = s > 0 ? Vector3(normal.x() / s, normal.y() / s, 0) : Vector3(1, 0, 0);
  f = k.cross(e);
  o = -R * e - half * k;
  if (!(D > 0) || D - s * 2 * R >= c * L) return false;
  // Where the plane cuts: from w0, where ℓ is l0, to w1, where it is l1; their differences by whichever does not cancel.
  const double w0 = D > c * L ? (D - c * L) / s : 0, w1 = D < s * 2 * R ? D / s : 2 * R;
  l0 = D < c * L ? D / c : L;
  l1 = D > s * 2 * R ? (D - s * 2 * R) / c : 0;
  const double dl = s >= c ? l0 - l1 : (w1 - w0) * s / c, dw = s >= c ? dl * c / s : w1 - w0, T = elementary::hypot(dl, dw);
  whole_end = l0 == L;
  theta0 = angleAt(w0, R);
  const double theta1 = angleAt(w1, R), middle = 0.5 * (theta0 + theta1);
  const bool inside = w0 > 0 && w1 < 2 * R;
  sweep = inside ? 2 * elementary::asin(std::min(1.0, dw / (2 * R * elementary::sin(middle)))) : theta1 - theta0;
  double volume = 0, e1 = 0, k1 = 0, ee = 0, ek = 0, kk = 0, ff = 0;
  if (w0 > 0) {
    const ChordSums m = segmentOf(R, theta0);
    volume = L * m.m0;
    e1 = L * m.m1, k1 = 0.5 * L * volume;
    ee = L * m.m2, ek = 0.5 * L * e1, kk = L * L / 3 * volume, ff = L * m.across;
  }
  double area = 0, ae = 0, ak = 0, aee = 0, aek = 0, akk = 0, aff = 0;
  // With η = (θ - θ0)/2 and H its end, cos θ0 - cos θ = 2 sin(θ0 + η) sin η: the share of w, and of ℓ, that has passed.
  const double H = 0.5 * sweep;
  const elementary::SineCosine whole0 = elementary::sinCos(theta0), half0 = elementary::sinCos(0.5 * theta0);
  const double all = elementary::sin(theta0 + H) * elementary::sin(H);
  const auto at = [&](double p, double weight) {
    const auto [sine, cosine] = elementary::sinCos(p * H);
    const double sine1 = whole0.sine * cosine + whole0.cosine * sine, cosine1 = whole0.cosine * cosine - whole0.sine * sine;  // of θ0 + η
    const double half_sine = half0.sine * cosine + half0.cosine * sine, sine2 = sine1 * cosine + cosine1 * sine;  // of θ/2, θ
    const double share = all != 0 ? sine1 * sine / all : p, rate = all != 0 ? H * sine2 / all : 1;
    const double w = 2 * R * half_sine * half_sine, l = l0 - share * dl, chord = 2 * R * std::max(0.0, sine2), side = chord * chord / 12;
    const double on_plane = weight * rate * T * chord, under = weight * rate * dw * chord * l;
    area += on_plane;
    ae += on_plane * w, ak += on_plane * l;
    aee += on_plane * w * w, aek += on_plane * w * l, akk += on_plane * l * l, aff += on_plane * side;
    volume += under;
    e1 += under * w, k1 += 0.5 * under * l;
    ee += under * w * w, ek += 0.5 * under * w * l, kk += under * l * l / 3, ff += under * side;
  };
  sweep < kEightPoints ? integrate(kGauss8, 0, 1, at) : integrate(kGauss16, 0, 1, at);
  const auto square = [&](double xx, double xz, double zz, double yy) -> Matrix3 {
    return xx * e * e.transpose() + xz * (e * k.transpose() + k * e.transpose()) + zz * k * k.transpose() + yy * f * f.transpose();
  };
  solid.volume = volume;
  solid.first = e1 * e + k1 * k;
  solid.second = square(ee, ek, kk, ff);
  face.area = area;
  face.first = ae * e + ak * k;
  face.second = square(aee, aek, akk, aff);
  return true;
}

}  // namespace haptic
