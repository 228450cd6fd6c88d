// Oracle: Eigen's dense Cholesky on the assembled matrix, over random graphs and block sizes.
#include "haptic_core/dynamics/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <random>

namespace haptic {
namespace block_cholesky_test {

struct Problem {
  std::vector<int> sizes, offsets{0};
  std::vector<BlockCholesky::Edge> edges;
  Eigen::MatrixXd A;
};

Problem randomProblem(std::mt19937& random, int nodes, double density, bool free_bodies) {
  Problem p;
  std::uniform_int_distribution<int> size(1, 9);
  std::uniform_real_distribution<double> real(-1, 1);
  for (int i = 0; i < nodes; ++i) {
    p.sizes.push_back(free_bodies ? 6 : size(random));
    p.offsets.push_back(p.offsets.back() + p.sizes.back());
  }
  const int n = p.offsets.back();
  p.A = 0.1 * Eigen::MatrixXd::Identity(n, n);
  const auto stiffness = [&](int a, int b) {  // Jᵀ J of a "contact" between a and b, or of a alone
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(4, n);
    for (int body : {a, b}) {
      for (int c = p.offsets[body]; c < p.offsets[body + 1]; ++c) {
        for (int r = 0; r < 4; ++r) J(r, c) = real(random);
      }
    }
    p.A += J.transpose() * J;
  };
  for (int a = 0; a < nodes; ++a) {
    stiffness(a, a);
    for (int b = 0; b < a; ++b) {
      if (real(random) < 2 * density - 1) {
        p.edges.push_back({a, b});
        stiffness(a, b);
      }
    }
  }
  return p;
}

void assemble(const Problem& p, BlockCholesky& solver, bool transposed) {
  const auto block = [&](int a, int b) -> Eigen::MatrixXd {
    return p.A.block(p.offsets[a], p.offsets[b], p.sizes[a], p.sizes[b]);
  };
  for (int i = 0; i < static_cast<int>(p.sizes.size()); ++i) solver.add(i, i, block(i, i).data());
  for (const auto& e : p.edges) {
    transposed ? solver.add(e.b, e.a, block(e.b, e.a).data()) : solver.add(e.a, e.b, block(e.a, e.b).data());
  }
}

TEST(BlockCholesky, SolvesLikeTheDenseFactorisation) {
  std::mt19937 random(1);
  BlockCholesky solver(30, 900, 1 << 16, 0);
  for (int trial = 0; trial < 200; ++trial) {
    const Problem p = randomProblem(random, 1 + trial % 30, (trial % 7) / 7.0, trial % 2);
    ASSERT_TRUE(solver.analyze(p.sizes.data(), p.sizes.size(), p.edges.data(), p.edges.size()));
    assemble(p, solver, trial % 3 == 0);
    ASSERT_TRUE(solver.factor());
    const Eigen::VectorXd b = Eigen::VectorXd::Random(p.A.rows());
    Eigen::VectorXd x = b;
    solver.solve(x.data());
    // Backward stable: |A x − b| ≤ c n ε |A| |x|; c n stays below 100 here.
    EXPECT_LE((p.A * x - b).norm(), 100 * 2.2e-16 * p.A.norm() * x.norm()) << "trial " << trial;
  }
}

TEST(BlockCholesky, AStackNeedsNoFill) {
  const int n = 15;
  std::vector<int> sizes(n, 6);
  std::vector<BlockCholesky::Edge> edges;
  for (int i = 1; i < n; ++i) edges.push_back({i - 1, i});
  BlockCholesky solver(n, n, 36 * (2 * n - 1), 0);  // exactly the blocks of the chain
  EXPECT_TRUE(solver.analyze(sizes.data(), n, edges.data(), edges.size()));
  EXPECT_EQ(solver.values(), 36u * (2 * n - 1));
}

TEST(BlockCholesky, RefusesWhatItCannotHold) {
  const std::vector<int> sizes(4, 6);
  std::vector<BlockCholesky::Edge> ring{{0, 1}, {1, 2}, {2, 3}, {3, 0}};  // one block of fill
  BlockCholesky exact(4, 4, 36 * 9, 0), small(4, 4, 36 * 8, 0), few(3, 4, 1000, 0);
  EXPECT_TRUE(exact.analyze(sizes.data(), 4, ring.data(), 4));
  EXPECT_FALSE(small.analyze(sizes.data(), 4, ring.data(), 4));
  EXPECT_FALSE(few.analyze(sizes.data(), 4, ring.data(), 4));
}

TEST(BlockCholesky, RefusesAnIndefiniteMatrix) {
  const int size = 2;
  const double indefinite[4] = {1, 2, 2, 1};
  BlockCholesky solver(1, 0, 4, 0);
  ASSERT_TRUE(solver.analyze(&size, 1, nullptr, 0));
  solver.add(0, 0, indefinite);
  EXPECT_FALSE(solver.factor());
}

TEST(BlockCholesky, AKeptAnalysisStartsFromZero) {
  std::mt19937 random(2);
  BlockCholesky solver(8, 64, 1 << 14, 0);
  const Problem p = randomProblem(random, 8, 0.4, true);
  const Eigen::VectorXd b = Eigen::VectorXd::Random(p.A.rows());
  Eigen::VectorXd first = b, second = b;
  for (Eigen::VectorXd* x : {&first, &second}) {
    ASSERT_TRUE(solver.analyze(p.sizes.data(), 8, p.edges.data(), p.edges.size()));
    assemble(p, solver, false);
    ASSERT_TRUE(solver.factor());
    solver.solve(x->data());
  }
  EXPECT_EQ(first, second);
}

TEST(BlockCholesky, PrescribedUnknownsAreMetAndTheRestSolvesAroundThem) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 50; ++trial) {
    const Problem p = randomProblem(random, 1 + trial % 8, 0.5, false);
    const int n = p.offsets.back();
    BlockCholesky solver(8, 64, 10000, 0);
    solver.reserveKept();
    ASSERT_TRUE(solver.analyze(p.sizes.data(), static_cast<int>(p.sizes.size()), p.edges.data(),
                               static_cast<int>(p.edges.size())));
    assemble(p, solver, trial % 2);
    solver.keep();
    Eigen::VectorXd x = Eigen::VectorXd::Random(n), b = Eigen::VectorXd::Random(n), y(n);
    solver.multiplyKept(x.data(), y.data());
    EXPECT_LT((y - p.A * x).norm(), 1e-13 * p.A.norm() * x.norm());
    for (int repeat = 0; repeat < 2; ++repeat) {  // recall brings A back
      if (repeat) solver.recall();
      Eigen::VectorXd rhs = b;
      std::vector<int> free;
      for (std::size_t node = 0; node < p.sizes.size(); ++node) {
        for (int i = 0; i < p.sizes[node]; ++i) {
          const int row = p.offsets[node] + i;
          if (row % 3 == 0) {
            rhs[row] = solver.prescribe(static_cast<int>(node), i) * x[row];
          } else {
            free.push_back(row);
          }
        }
      }
      ASSERT_TRUE(solver.factor());
      solver.solve(rhs.data());
      for (int row = 0; row < n; row += 3) EXPECT_DOUBLE_EQ(rhs[row], x[row]);
      const Eigen::VectorXd left = p.A * rhs - b;
      for (int row : free) EXPECT_NEAR(left[row], 0, 1e-11 * p.A.norm() * rhs.norm());
    }
  }
}

}  // namespace block_cholesky_test
}  // namespace haptic
