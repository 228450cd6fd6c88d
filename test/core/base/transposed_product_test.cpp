// Oracle: the definition of the product, summed in its order; and the same at every address.
#include "haptic_core/base/transposed_product.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace haptic {
namespace transposed_product_test {

constexpr int kPlaces = 8;  // doubles of the largest packet, of x86-64-v4

/// Numbers of all sizes, so that sums show their order; `place` doubles behind the start of their storage.
std::vector<double> numbers(int count, double seed, int place) {
  std::vector<double> x(place + count);
  for (int i = 0; i < count; ++i) x[place + i] = std::sin(seed + 1.7 * i) * std::exp(3 * std::sin(seed * i));
  return x;
}

TEST(TransposedProduct, SumsInItsOrderAtEveryAddress) {
  for (int rows = 0; rows <= 9; ++rows) {
    for (int cols = 0; cols <= 9; ++cols) {
      std::vector<double> expected(rows * cols, 0.0);
      const std::vector<double> A0 = numbers(6 * rows, 0.3, 0), B0 = numbers(6 * cols, 1.1, 0);
      for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < cols; ++j) {
          for (int k = 0; k < 6; ++k) expected[i * cols + j] += A0[k * rows + i] * B0[k * cols + j];
        }
      }
      for (int place = 0; place < kPlaces; ++place) {
        const std::vector<double> A = numbers(6 * rows, 0.3, place),
                                  B = numbers(6 * cols, 1.1, (3 * place) % kPlaces);
        std::vector<double> out((5 * place) % kPlaces + rows * cols);
        double* result = out.data() + (5 * place) % kPlaces;
        transposedProduct(A.data() + place, rows, B.data() + (3 * place) % kPlaces, cols, result);
        for (int i = 0; i < rows * cols; ++i)
          ASSERT_EQ(result[i], expected[i]) << rows << " × " << cols << ", " << place;
      }
    }
  }
}

}  // namespace transposed_product_test
}  // namespace haptic
