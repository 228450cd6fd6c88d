/// S x = b of a small positive semidefinite S of which some rows repeat others, or nearly: the solution of least norm.
///
/// For S = G A⁻¹ Gᵀ of constraints G. The rows of a planar ring repeat each other exactly; of a straight chain between two fixed points
/// the row along it vanishes, and a little beside the straight pose its force is as large as the way that it can close is small.
/// Tikhonov's regularisation, iterated once (Engl, Hanke, Neubauer, Regularization of Inverse Problems, 1996, section 5.1): with
/// B = S + ε D, D the scale of each row,
///     x = B⁻¹ b + B⁻¹ (ε D B⁻¹ b).
/// Of an eigenvalue λ (in D) it solves the share 1 - (ε/(λ + ε))²: all but ε² of an independent row, nothing of a redundant one, and
/// continuously between.
#pragma once
#include <vector>

namespace haptic {

/// A damped Cholesky factorisation of one matrix of up to `max_rows` rows at a time.
class DampedCholesky {
 public:
  /// Set-up: allocates for `max_rows` rows.
  explicit DampedCholesky(int max_rows = 0)
      : S_(max_rows * max_rows), L_(max_rows * max_rows), scale_(max_rows), missing_(max_rows) {}

  /// S, to fill before `factor`, rows × rows row-major; its lower triangle is read.
  double* matrix() noexcept { return S_.data(); }
  /// D, to fill before `factor`, by row; 0 where nothing moves the row.
  double* scale() noexcept { return scale_.data(); }
  /// (in realtime) `damping` is ε [1]. Of the same S as often as needed.
  void factor(int rows, double damping) noexcept;
  void solve(double* x) noexcept;  ///< (in realtime) x ← S⁻¹ x

 private:
  void solveOnce(double* x) const noexcept;
  std::vector<double> S_, L_, scale_, missing_;
  int rows_ = 0;
  double damping_ = 0;
};

}  // namespace haptic
