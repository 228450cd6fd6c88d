// The damped solution of S x = b against its eigenvalues: every one of them lets its share 1 - (ε/(λ + ε))² through.
#include "haptic_core/dynamics/damped_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

namespace haptic {
namespace damped_cholesky_test {

constexpr int kRows = 6;
constexpr double kDamping = 1e-5;

TEST(DampedCholesky, SolvesTheShareOfEachEigenvalue) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  DampedCholesky solver(kRows);
  for (int trial = 0; trial < 100; ++trial) {
    // Rank 1 to 6, rows nearly dependent by 1e-8 to 1, in units D of their own.
    Eigen::MatrixXd G(kRows, 1 + trial % kRows);
    for (int i = 0; i < G.size(); ++i) G.data()[i] = normal(random) * std::pow(10.0, trial % 5 * (i % 3 == 0 ? -1 : 0));
    Eigen::VectorXd unit(kRows), b(kRows);
    for (int i = 0; i < kRows; ++i) unit[i] = std::pow(10.0, normal(random)), b[i] = normal(random);
    const Eigen::MatrixXd S = G * G.transpose();
    for (int i = 0; i < kRows; ++i) {
      solver.scale()[i] = unit[i] * unit[i];
      for (int j = 0; j < kRows; ++j) solver.matrix()[i * kRows + j] = unit[i] * S(i, j) * unit[j];
    }
    for (const double damping : {0.1, kDamping}) {  // of the same S twice
      solver.factor(kRows, damping);
      Eigen::VectorXd x = unit.cwiseProduct(b);
      solver.solve(x.data());
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(S);
      Eigen::VectorXd expected = eigen.eigenvectors().transpose() * b;
      for (int i = 0; i < kRows; ++i) {
        const double lambda = std::max(0.0, eigen.eigenvalues()[i]);
        expected[i] *= (1 + damping / (lambda + damping)) / (lambda + damping);
      }
      const Eigen::VectorXd y = eigen.eigenvectors() * expected;
      // Rounding of S over ε, twice.
      const double tolerance = 100 * 2.2e-16 * S.norm() / damping * y.norm();
      EXPECT_LE((unit.cwiseProduct(x) - y).norm(), tolerance + 1e-14 * y.norm()) << trial << ' ' << damping;
    }
  }
}

// A row that nothing moves, and that has no scale, gets no force and disturbs no other.
TEST(DampedCholesky, ARowThatNothingMovesGetsNoForce) {
  DampedCholesky solver(2);
  const double S[] = {0, 0, 0, 4};
  std::copy(S, S + 4, solver.matrix());
  solver.scale()[0] = 0, solver.scale()[1] = 4;
  solver.factor(2, kDamping);
  double x[] = {3, 8};
  solver.solve(x);
  EXPECT_EQ(x[0], 0);
  EXPECT_NEAR(x[1], 2, 2 * kDamping * kDamping);
}

}  // namespace damped_cholesky_test
}  // namespace haptic
