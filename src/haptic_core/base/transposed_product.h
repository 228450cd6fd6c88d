/// The product of two matrices of six rows, to bits that do not depend on where they lie.
///
/// Eigen writes a product of dynamic size packet by packet from the first aligned row on, and number by
/// number before and behind. A packet sums in another order than a single number does, and fuses
/// multiplications and additions where the build can, in spite of -ffp-contract=off. The heap aligns to 16
/// bytes and a packet of x86-64-v3 wants 32: which rows packets wrote was chance. Fixed sizes are safe: how
/// they are cut is known when they are compiled.
#pragma once

namespace haptic {

/// (in realtime) out = Aᵀ B; A is 6 × rows, B is 6 × cols, all three row by row, and `out` apart from both.
/// Every number sums from A's first row to its last, whatever stands beside it. Cost: 12 rows · cols
/// operations.
inline void transposedProduct(const double* A, int rows, const double* B, int cols,
                              double* __restrict out) noexcept {
  const double *b0 = B, *b1 = b0 + cols, *b2 = b1 + cols, *b3 = b2 + cols, *b4 = b3 + cols, *b5 = b4 + cols;
  for (int i = 0; i < rows; ++i, out += cols) {
    const double a0 = A[i], a1 = A[rows + i], a2 = A[2 * rows + i], a3 = A[3 * rows + i],
                 a4 = A[4 * rows + i], a5 = A[5 * rows + i];
    for (int j = 0; j < cols; ++j) {
      out[j] = a0 * b0[j] + a1 * b1[j] + a2 * b2[j] + a3 * b3[j] + a4 * b4[j] + a5 * b5[j];
    }
  }
}

}  // namespace haptic
