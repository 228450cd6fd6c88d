/// A box of poses, and the rows of the structure matrix over it: value, derivative, and bounds that hold throughout.
///
/// Row i of the scaled structure matrix (string_kinematics.h) is a = [d, (Rk × d)/r, d · R dk], with k the knot in G, v = E - p - Rk,
/// l = |v|, d = v/l. A pose of the cell is the centre's plus u = (u_p, u_θ), |u_j| ≤ w_j, where θ is the rotation vector of R. With
/// φ = |w_θ| and s = |w_p| + |k| φ, along any straight way u in the cell:
///   |R' x| ≤ φ |x| and |R'' x| ≤ φ² |x|: the derivatives of exp along a line of skew matrices are integrals over products of rotations
///     and the line's direction, over a segment (first) and a triangle of area ½, twice (second);
///   the knot moves by at most s, |v'| ≤ s, |v''| ≤ |k| φ², and l ≥ l(centre) - s =: l_min;
///   d = v/|v|: its first derivative along h is h_⊥/l, its second -(2 h_∥ h_⊥ + |h_⊥|² d)/l², of norm |h_⊥| √(4 h_∥² + h_⊥²)/l²
///     ≤ (2/√3) |h|²/l² (at h_⊥² = ⅔ |h|²). So |d'| ≤ s/l_min =: D₁ and |d''| ≤ (2/√3) D₁² + |k| φ²/l_min =: D₂;
///   the product rule gives |a''| ≤ √(D₂² + (|k|/r)² M² + |dk|² M²) with M = D₂ + 2 φ D₁ + φ².
/// Taylor: a(u) = a(0) + J u + e with |e| ≤ ½ |a''| =: bend, and |a(u) - a(0)| ≤ Σ_j |J_j| w_j + bend =: spread.
#pragma once
#include <array>

#include "haptic_core/spidar/string_kinematics.h"

namespace haptic {

/// A box of poses at one opening: translation and rotation vector, each within ± half of the centre.
struct PoseCell {
  Vector6 centre = Vector6::Zero();  ///< p_BG [m], then the rotation vector of R_BG [rad]
  Vector6 half = Vector6::Zero();    ///< half widths, likewise; 0: that coordinate is fixed

  GripPose pose(const Vector6& at) const;                ///< the pose with these coordinates, opening 0
  GripPose pose() const { return pose(centre); }         ///< the centre's
  double volume() const;                                 ///< product of the widths that are not zero
  bool contains(const Vector6& at) const { return ((at - centre).cwiseAbs() - half).maxCoeff() <= 0; }  ///< borders included
};

/// Rows of the scaled structure matrix over a cell.
struct RowBounds {
  using Row = Eigen::Matrix<double, kMaxDof, 1>;  ///< a row, its unused columns 0
  int strings = 0;                                ///< rows in use
  bool bounded = false;                           ///< false: some string may have no length in the cell; nothing else is valid
  std::array<int, 6> moving{};                    ///< coordinates of the cell that are not fixed
  int moves = 0;                                  ///< entries of `moving`
  std::array<double, 6> half{};                   ///< their half widths, in the order of `moving`
  std::array<Row, kMaxStrings> row;               ///< at the centre
  std::array<std::array<Row, 6>, kMaxStrings> slope;  ///< derivative by each moving coordinate
  std::array<double, kMaxStrings> bend, spread;       ///< see above
};

/// Rows over cells, for one device.
class CellRows {
 public:
  explicit CellRows(const DeviceDef& def);              ///< copies exits and knots
  void evaluate(const PoseCell& cell, RowBounds& out) const;  ///< fills `out`
  int strings() const { return strings_; }              ///< rows
  int dof() const { return dof_; }                      ///< columns
  double knotRadius() const { return radius_; }         ///< r [m]; 1 for a point grip

 private:
  void evaluateString(int i, const Matrix3& R, const std::array<Matrix3, 3>& turned, const PoseCell& cell, RowBounds& out) const;

  int strings_, dof_;
  double radius_;
  std::array<Vector3, kMaxStrings> exit_, knot_, knot_per_opening_;
};

}  // namespace haptic
