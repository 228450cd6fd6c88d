#include "haptic_core/dynamics/damped_cholesky.h"

#include <cmath>

namespace haptic {

void DampedCholesky::factor(int rows, double damping) noexcept {
  rows_ = rows;
  damping_ = damping;
  for (int c = 0; c < rows; ++c) {
    double pivot = S_[c * rows + c] + damping * scale_[c];
    for (int k = 0; k < c; ++k) pivot -= L_[c * rows + k] * L_[c * rows + k];
    // Rounding of a redundant row is far below ε D; a row that nothing moves has neither pivot nor force.
    const double root = pivot > 0 ? std::sqrt(pivot) : 0;
    L_[c * rows + c] = root;
    for (int r = c + 1; r < rows; ++r) {
      double x = S_[r * rows + c];
      for (int k = 0; k < c; ++k) x -= L_[r * rows + k] * L_[c * rows + k];
      L_[r * rows + c] = root > 0 ? x / root : 0;
    }
  }
}

void DampedCholesky::solveOnce(double* x) const noexcept {
  const auto divided = [&](int i, double value) { return L_[i * rows_ + i] > 0 ? value / L_[i * rows_ + i] : 0; };
  for (int i = 0; i < rows_; ++i) {
    for (int j = 0; j < i; ++j) x[i] -= L_[i * rows_ + j] * x[j];
    x[i] = divided(i, x[i]);
  }
  for (int i = rows_ - 1; i >= 0; --i) {
    for (int j = i + 1; j < rows_; ++j) x[i] -= L_[j * rows_ + i] * x[j];
    x[i] = divided(i, x[i]);
  }
}

void DampedCholesky::solve(double* x) noexcept {
  solveOnce(x);
  for (int i = 0; i < rows_; ++i) missing_[i] = damping_ * scale_[i] * x[i];
  solveOnce(missing_.data());
  for (int i = 0; i < rows_; ++i) x[i] += missing_[i];
}

}  // namespace haptic
