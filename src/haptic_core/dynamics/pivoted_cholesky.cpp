#include "haptic_core/dynamics/pivoted_cholesky.h"

#include <cmath>
#include <utility>

namespace haptic {
namespace {

// Rows whose pivot falls below this share of its own start are redundant [1]. Larger: real constraints are
// lost; smaller: rounding of a redundant row is inverted.
constexpr double kRedundant = 1e-9;

}  // namespace

void PivotedCholesky::factor(int rows) noexcept {
  rows_ = rows;
  for (int r = 0; r < rows; ++r) {
    pivot_[r] = r;
    size_[r] = S_[r * rows + r];
  }
  for (rank_ = 0; rank_ < rows; ++rank_) {
    int best = rank_;
    double best_share = -1;
    for (int r = rank_; r < rows; ++r) {
      const double share = size_[pivot_[r]] > 0 ? S_[pivot_[r] * rows + pivot_[r]] / size_[pivot_[r]] : 0;
      if (share > best_share) {
        best_share = share;
        best = r;
      }
    }
    if (!(best_share > kRedundant)) break;
    std::swap(pivot_[rank_], pivot_[best]);
    const int p = pivot_[rank_];
    const double root = std::sqrt(S_[p * rows + p]);
    S_[p * rows + p] = root;
    for (int r = rank_ + 1; r < rows; ++r) S_[pivot_[r] * rows + p] /= root;
    for (int r = rank_ + 1; r < rows; ++r) {
      for (int c = rank_ + 1; c < rows; ++c) {
        S_[pivot_[r] * rows + pivot_[c]] -= S_[pivot_[r] * rows + p] * S_[pivot_[c] * rows + p];
      }
    }
  }
}

void PivotedCholesky::solve(double* x) const noexcept {
  for (int i = 0; i < rank_; ++i) {
    const int p = pivot_[i];
    for (int j = 0; j < i; ++j) x[p] -= S_[p * rows_ + pivot_[j]] * x[pivot_[j]];
    x[p] /= S_[p * rows_ + p];
  }
  for (int i = rank_ - 1; i >= 0; --i) {
    const int p = pivot_[i];
    for (int j = i + 1; j < rank_; ++j) x[p] -= S_[pivot_[j] * rows_ + p] * x[pivot_[j]];
    x[p] /= S_[p * rows_ + p];
  }
  for (int i = rank_; i < rows_; ++i) x[pivot_[i]] = 0;
}

}  // namespace haptic
