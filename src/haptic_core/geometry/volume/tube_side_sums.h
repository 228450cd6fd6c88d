/// Sums over a tube's part that bounds a volume, from the points of its boundary.
#pragma once
#include <cmath>

#include "haptic_core/geometry/volume/circular_segment.h"
#include "haptic_core/geometry/volume/solid_moments.h"

namespace haptic {

/// ∫ cᵏ dψ and ∫ cᵏ sin ψ dψ from 0 to ψ, c = 1 - cos ψ.
struct TurnIntegrals {
  double C[4], D[3];  ///< without the sine for k = 0…3, with it for k = 0…2

  /// `half` and `cosine`: sine and cosine of ψ/2.
  TurnIntegrals(double psi, double half, double cosine) {
    const double s = 2 * half * cosine, c = 2 * half * half;
    D[0] = c;
    D[1] = 0.5 * c * c;
    D[2] = c * c * c / 3;
    if (std::abs(psi) < kSeries) {
      // dψ = dc/√(2c) (1 - c/2)^(-1/2), its coefficients in c/2; the lower ones follow without cancelling.
      constexpr double b[] = {1, 1.0 / 2, 3.0 / 8, 5.0 / 16, 35.0 / 128, 63.0 / 256, 231.0 / 1024, 429.0 / 2048, 6435.0 / 32768};
      const double x = 0.5 * c;
      double sum = 0;
      for (int j = 8; j >= 0; --j) sum = sum * x + b[j] / (j + 3.5);
      C[3] = c * c * c * half * sum;  // √(c/2) = |sin ψ/2|
      C[2] = (c * c * s + 3 * C[3]) / 5;
      C[1] = (c * s + 2 * C[2]) / 3;
      C[0] = psi;
    } else {
      C[0] = psi;
      C[1] = psi - s;
      C[2] = (3 * C[1] - c * s) / 2;
      C[3] = (5 * C[2] - c * c * s) / 3;
    }
  }
  static constexpr double kSeries = 0.3;  ///< [rad]: the series ends at 1e-17 there, and the closed forms lose two digits
};

/// Sums over the tube's part: cones from o = a ê, at height o_z. With c = 1 - cos ψ, ψ from ê, a point of the tube is
/// y = (b - R c) ê + R sin ψ t̂ + ζ ẑ from o, b = R - a, and y·N = b + a c.
class SideSums {
 public:
  /// Of the tube, from a point at the distance a of its axis [m].
  SideSums(double radius, double a) : R_(radius), a_(a), b_(radius - a) {}

  /// `turns`: whole turns that ψ has made, of whose half `half` and `cosine` are sine and cosine; `dz` weighs the point.
  void add(double psi, double half, double cosine, double turns, double zeta, double dz) {
    const double sign = static_cast<int>(turns) % 2 == 0 ? 1 : -1;
    const Weights w = at(TurnIntegrals(psi - turns * kTurn, sign * half, sign * cosine));
    const double z[3] = {dz, zeta * dz, zeta * zeta * dz};
    sum(w, -1, z);
    if (turns != 0) sum(turn(), -turns, z);
  }
  /// At an arc's end, ∫ dz of the turns that it has made there.
  void addTurns(double turns, double zeta) {
    const double z[3] = {zeta, zeta * zeta / 2, zeta * zeta * zeta / 3};
    sum(turn(), turns, z);
  }
  /// Adds volume and moments about o: `along` is ê, `across` is t̂, unit.
  void addTo(const Vector3& along, const Vector3& across, SolidMoments& out) const {
    const Vector3 up = Vector3::UnitZ();
    out.volume += R_ / 3 * v_[0];
    out.first += R_ / 4 * (x_[0] * along + y_[0] * across + v_[1] * up);
    const auto mixed = [](const Vector3& p, const Vector3& q) -> Matrix3 { return p * q.transpose() + q * p.transpose(); };
    out.second += R_ / 5 * (xx_ * along * along.transpose() + yy_ * across * across.transpose() + v_[2] * up * up.transpose() +
                            xy_ * mixed(along, across) + x_[1] * mixed(along, up) + y_[1] * mixed(across, up));
  }

 private:
  struct Weights {
    double v, x, y, xx, xy, yy;
  };
  Weights at(const TurnIntegrals& t) const {
    const double R = R_, a = a_, b = b_;
    return {b * t.C[0] + a * t.C[1],
            b * b * (t.C[0] - t.C[1]) - a * R * t.C[2],
            R * (b * t.D[0] + a * t.D[1]),
            b * b * b * t.C[0] + b * b * (a - 2 * R) * t.C[1] + b * R * (R - 2 * a) * t.C[2] + a * R * R * t.C[3],
            R * (b * b * (t.D[0] - t.D[1]) - a * R * t.D[2]),
            R * R * (2 * b * t.C[1] + (2 * a - b) * t.C[2] - a * t.C[3])};
  }
  /// Of a whole turn.
  Weights turn() const {
    const Weights half = at(TurnIntegrals(M_PI, 1, 0));
    return {2 * half.v, 2 * half.x, 0, 2 * half.xx, 0, 2 * half.yy};
  }
  void sum(const Weights& w, double sign, const double* z) {
    for (int k = 0; k < 3; ++k) v_[k] += sign * w.v * z[k];
    for (int k = 0; k < 2; ++k) x_[k] += sign * w.x * z[k], y_[k] += sign * w.y * z[k];
    xx_ += sign * w.xx * z[0];
    xy_ += sign * w.xy * z[0];
    yy_ += sign * w.yy * z[0];
  }

  double R_, a_, b_;
  double v_[3] = {0, 0, 0}, x_[2] = {0, 0}, y_[2] = {0, 0}, xx_ = 0, xy_ = 0, yy_ = 0;
};

}  // namespace haptic
