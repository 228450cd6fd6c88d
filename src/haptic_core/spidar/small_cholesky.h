/// LDLᵀ of a symmetric positive definite matrix of a few rows, unrolled by the compiler, without square
/// roots.
#pragma once
#include <array>

namespace haptic {

/// Factorisation S = L D Lᵀ, L unit lower triangular. Cost for kSize = 6: 70 multiplications, 6 divisions.
/// The loops are templates over the column: at run time their overhead would be three times the arithmetic.
template <int kSize>
class SmallCholesky {
 public:
  using Rows = std::array<std::array<double, kSize>, kSize>;  ///< row-major; only the lower triangle is read

  /// False when a pivot is not above `least_pivot`: S is not positive definite to that accuracy.
  bool factor(const Rows& s, double least_pivot) noexcept {
    Rows scaled;  // L D, below the diagonal
    return factorFrom<0>(s, scaled, least_pivot);
  }

  /// Replaces `b` by S⁻¹ b.
  template <class Vector>
  void solve(Vector& b) const noexcept {
    forward<0>(b);
    for (int j = 0; j < kSize; ++j) b[j] *= reciprocal_[j];
    backward<kSize - 1>(b);
  }

 private:
  template <int kColumn>
  bool factorFrom(const Rows& s, Rows& scaled, double least_pivot) noexcept {
    double pivot = s[kColumn][kColumn];
    for (int k = 0; k < kColumn; ++k) pivot -= lower_[kColumn][k] * scaled[kColumn][k];
    reciprocal_[kColumn] = 1.0 / pivot;
    for (int i = kColumn + 1; i < kSize; ++i) {
      double sum = s[i][kColumn];
      for (int k = 0; k < kColumn; ++k) sum -= lower_[kColumn][k] * scaled[i][k];
      scaled[i][kColumn] = sum;
      lower_[i][kColumn] = sum * reciprocal_[kColumn];
    }
    bool rest = true;
    if constexpr (kColumn + 1 < kSize) rest = factorFrom<kColumn + 1>(s, scaled, least_pivot);
    return rest && pivot > least_pivot;
  }

  template <int kColumn, class Vector>
  void forward(Vector& b) const noexcept {
    for (int i = kColumn + 1; i < kSize; ++i) b[i] -= lower_[i][kColumn] * b[kColumn];
    if constexpr (kColumn + 1 < kSize) forward<kColumn + 1>(b);
  }

  template <int kColumn, class Vector>
  void backward(Vector& b) const noexcept {
    for (int i = 0; i < kColumn; ++i) b[i] -= lower_[kColumn][i] * b[kColumn];
    if constexpr (kColumn > 0) backward<kColumn - 1>(b);
  }

  Rows lower_{};
  std::array<double, kSize> reciprocal_{};
};

}  // namespace haptic
