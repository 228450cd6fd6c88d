#include "haptic_core/base/dense_matrix.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace haptic {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd solveSymmetric(const MatrixXd& A, const MatrixXd& B) { return Eigen::LDLT<MatrixXd>(A).solve(B); }

MatrixXd inverse(const MatrixXd& A) { return A.inverse(); }

MatrixXd projectorOnto(const MatrixXd& A) { return A.lazyProduct(solveSymmetric(A.transpose().lazyProduct(A), A.transpose())); }

VectorXd eigenvalues(const MatrixXd& A) { return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues(); }

VectorXd singularValues(const MatrixXd& A) {
  return eigenvalues(A.transpose().lazyProduct(A)).cwiseMax(0).cwiseSqrt().reverse();
}

Modes modesOf(const MatrixXd& K, const MatrixXd& M) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> solver(K, M);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace haptic
