/// Matrices of any size, at set-up: they allocate. Each of Eigen's decompositions takes seconds to compile wherever it is used: once, here.
#pragma once

#include "haptic_core/base/eigen.h"

namespace haptic {

/// X of A X = B, for a symmetric A that is positive definite. By LDLᵀ.
Eigen::MatrixXd solveSymmetric(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// Of a regular A. By LU with partial pivots.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& A);

/// P with P x the part of x in the space of A's columns, which are independent: A (AᵀA)⁻¹ Aᵀ. Error: rounding times the square of A's
/// condition.
Eigen::MatrixXd projectorOnto(const Eigen::MatrixXd& A);

/// Of a symmetric A, ascending.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& A);

/// Of A, largest first; below 1e-8 of the largest they are rounding.
Eigen::VectorXd singularValues(const Eigen::MatrixXd& A);

/// K x = λ M x.
struct Modes {
  Eigen::VectorXd values;   ///< λ, ascending
  Eigen::MatrixXd vectors;  ///< columns x, with xᵀ M x = 1
};
Modes modesOf(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M);  ///< symmetric K, positive definite M

}  // namespace haptic
