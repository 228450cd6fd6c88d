// GMRES against a dense solver, and its least residual against least squares over the Krylov space.
#include "haptic_core/base/gmres.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace haptic {
namespace gmres_test {

Eigen::MatrixXd randomMatrix(int n, double off, std::mt19937& random) {
  std::uniform_real_distribution<double> in(-off, off);
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) A(i, j) += in(random);
  }
  return A;
}

Eigen::VectorXd solve(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double tolerance, int& applied) {
  const int n = static_cast<int>(b.size());
  Gmres solver(static_cast<std::size_t>(n));
  Eigen::VectorXd x = b;
  applied = 0;
  solver.solve(n, tolerance, [&](const double* u, double* y) {
    ++applied;
    Eigen::Map<Eigen::VectorXd>(y, n) = A * Eigen::Map<const Eigen::VectorXd>(u, n);
  }, x.data());
  return x;
}

TEST(Gmres, EndsWithTheSolutionOfAsManyUnknownsAsVectors) {
  std::mt19937 random(3);
  for (int n = 1; n <= Gmres::kVectors; ++n) {
    const Eigen::MatrixXd A = randomMatrix(n, 2, random);
    const Eigen::VectorXd b = Eigen::VectorXd::Random(n);
    int applied = 0;
    const Eigen::VectorXd x = solve(A, b, 0, applied), exact = A.fullPivLu().solve(b);
    EXPECT_LE((A * x - b).norm(), 1e-10 * A.norm() * exact.norm()) << n;
    EXPECT_EQ(applied, n);
  }
}

TEST(Gmres, LeavesTheLeastResidualOfItsSpace) {
  std::mt19937 random(7);
  const int n = 40, k = Gmres::kVectors;
  const Eigen::MatrixXd A = randomMatrix(n, 0.3, random);
  const Eigen::VectorXd b = Eigen::VectorXd::Random(n);
  int applied = 0;
  const Eigen::VectorXd x = solve(A, b, 0, applied);
  Eigen::MatrixXd space(n, k);
  space.col(0) = b;
  for (int i = 1; i < k; ++i) space.col(i) = A * space.col(i - 1);
  const Eigen::MatrixXd image = A * space;
  const double least = (image * image.colPivHouseholderQr().solve(b) - b).norm();
  EXPECT_NEAR((A * x - b).norm(), least, 1e-9 * b.norm());
  EXPECT_EQ(applied, k);
}

TEST(Gmres, StopsAtTheToleranceAndAtZero) {
  std::mt19937 random(11);
  const int n = 40;
  const Eigen::MatrixXd A = randomMatrix(n, 0.01, random);
  const Eigen::VectorXd b = Eigen::VectorXd::Random(n);
  int applied = 0;
  const Eigen::VectorXd x = solve(A, b, 1e-3, applied);
  EXPECT_LT(applied, Gmres::kVectors);
  EXPECT_LE((A * x - b).norm(), 1e-3 * b.norm());
  EXPECT_EQ(solve(A, Eigen::VectorXd::Zero(n), 1e-3, applied), Eigen::VectorXd::Zero(n));
  EXPECT_EQ(applied, 0);
}

}  // namespace gmres_test
}  // namespace haptic
