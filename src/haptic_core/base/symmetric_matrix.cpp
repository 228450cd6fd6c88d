#include "haptic_core/base/symmetric_matrix.h"

#include <Eigen/Eigenvalues>

namespace haptic {

PrincipalAxes principalAxes(const Matrix3& A) {
  const Eigen::SelfAdjointEigenSolver<Matrix3> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace haptic
