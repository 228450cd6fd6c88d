/// Eigenvalues and axes of a symmetric 3×3 matrix. Eigen's solver takes ten seconds to compile wherever it is used: once, here.
#pragma once

#include "haptic_core/base/spatial.h"

namespace haptic {

/// A = axes · diag(value) · axesᵀ.
struct PrincipalAxes {
  Vector3 value;  ///< ascending, in A's unit
  Matrix3 axes;   ///< columns, orthonormal; of either hand
};

/// Of a finite A, whose upper triangle is not read. Errors are rounding: 1e-15 of the largest value. Source: Eigen's implicit QR steps.
PrincipalAxes principalAxes(const Matrix3& A);

}  // namespace haptic
