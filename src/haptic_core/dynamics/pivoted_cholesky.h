/// Cholesky factorisation with pivoting of a small positive semidefinite matrix: rows that depend on others
/// drop out.
///
/// For S = G A⁻¹ Gᵀ of constraints G of which some repeat each other, as a planar ring's do. A row counts as
/// dependent when what is left of its diagonal is below 1e-9 of what it was: rows of length and of angle are
/// each compared with their own size. (Higham, Analysis of the Cholesky decomposition of a semi-definite
/// matrix, 1990.)
#pragma once
#include <vector>

namespace haptic {

/// A Cholesky factorisation with pivoting, of one matrix of up to `max_rows` rows at a time.
class PivotedCholesky {
 public:
  /// Set-up: allocates for `max_rows` rows.
  explicit PivotedCholesky(int max_rows = 0) : S_(max_rows * max_rows), size_(max_rows), pivot_(max_rows) {}

  /// The matrix to fill before `factor`, rows × rows row-major.
  double* matrix() noexcept { return S_.data(); }
  void factor(int rows) noexcept;  ///< (in realtime)
  /// (in realtime) x ← S⁻¹ x on the independent rows, 0 on the others.
  void solve(double* x) const noexcept;
  int rank() const { return rank_; }  ///< independent rows of the last `factor`

 private:
  std::vector<double> S_, size_;
  std::vector<int> pivot_;
  int rows_ = 0, rank_ = 0;
};

}  // namespace haptic
