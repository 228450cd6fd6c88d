/// Volume and moments of a solid piece by piece, as cones from one point.
#pragma once
#include "haptic_core/geometry/volume/ball_cut.h"

namespace haptic {

/// ∫ 1, y, y yᵀ dV, y from a point o.
struct SolidMoments {
  double volume = 0;                   ///< [m³]
  Vector3 first = Vector3::Zero();     ///< [m⁴]
  Matrix3 second = Matrix3::Zero();    ///< [m⁵]

  /// A ball's, about its centre.
  static SolidMoments ofBall(double radius) {
    SolidMoments m;
    m.volume = 4 * M_PI / 3 * radius * radius * radius;
    m.second = 0.2 * m.volume * radius * radius * Matrix3::Identity();
    return m;
  }
  /// The cone from o over a part of a plane at `height` over o.
  void addCone(const PlaneMoments& base, double height) {
    volume += height / 3 * base.area;
    first += height / 4 * base.first;
    second += height / 5 * base.second;
  }
  /// Adds those of another piece, whose point lies `by` beyond o.
  void add(const SolidMoments& piece, const Vector3& by) {
    const Matrix3 mixed = by * piece.first.transpose();
    volume += piece.volume;
    first += piece.first + piece.volume * by;
    second += piece.second + mixed + mixed.transpose() + piece.volume * by * by.transpose();
  }
};

/// A spherical cap of height `depth` on a ball of `radius`, from the middle of its flat side, z towards its pole.
struct CapMoments {
  double volume, z, across;            ///< ∫ 1, z and x² dV [m³, m⁴, m⁵]

  /// Both in [m]; 0 ≤ depth ≤ 2 radius.
  CapMoments(double radius, double depth) {
    const double d2 = depth * depth;
    volume = M_PI * d2 * (radius - depth / 3);
    z = M_PI * d2 * depth * (radius / 3 - depth / 12);
    across = 0.25 * M_PI * d2 * depth * (4.0 / 3 * radius * radius - depth * (radius - 0.2 * depth));
  }
};

/// (in realtime) Adds the cones from o = distance · u over the part of the sphere about the origin inside the faces of
/// `cut`, whose circles bound it. `u`: unit, the antipode -u R is not inside.
void addSphericalPart(const BallCut& cut, const Vector3& u, double distance, SolidMoments& sums) noexcept;

}  // namespace haptic
