// Sums in a fixed order: the same bits whichever numbers were set anew, and the sum by another way to rounding.
#include "haptic_core/base/sum_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace haptic {
namespace sum_tree_test {

TEST(SumTree, IsTheSameWhicheverRowsAreSetAnew) {
  std::mt19937 random(5);
  const auto number = [&] { return 2.0 * random() / random.max() - 1; };
  for (const std::size_t rows : {1u, 2u, 3u, 100u, 1025u}) {
    SumTree<2> some(rows);
    std::vector<SumTree<2>::Row> row(rows, {0, 0});
    for (int round = 0; round < 300; ++round) {
      const std::size_t i = random() % rows;
      row[i] = {number(), 1e10 * number()};
      some.set(i, row[i]);
      SumTree<2> all(rows);
      long double exact[2] = {0, 0};
      for (std::size_t k = 0; k < rows; ++k) {
        all.set(k, row[k]);
        for (int c = 0; c < 2; ++c) exact[c] += row[k][c];
      }
      ASSERT_EQ(some.sum(), all.sum());
      // As many roundings as levels, of sums no larger than all numbers together.
      const double tolerance = 2.3e-16 * (std::log2(rows) + 1) * static_cast<double>(rows);
      ASSERT_NEAR(some.sum()[0], static_cast<double>(exact[0]), tolerance);
      ASSERT_NEAR(some.sum()[1], static_cast<double>(exact[1]), 1e10 * tolerance);
    }
  }
}

}  // namespace sum_tree_test
}  // namespace haptic
