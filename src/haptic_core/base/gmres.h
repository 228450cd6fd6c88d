/// GMRES: the x that makes |b - A x| least over the Krylov space of b, for an A that is only applied, neither symmetric nor stored.
///
/// Source: Y. Saad, M. Schultz, SIAM J. Sci. Stat. Comput. 7, 1986, with Givens' rotations. In exact arithmetic it ends with the solution
/// after as many applications of A as A has distinct eigenvalues. Cost of k vectors of length n beside them: 2 n k² products.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace haptic {

/// Solver for up to so many unknowns.
class Gmres {
 public:
  static constexpr int kVectors = 8;  ///< applications of A at most

  explicit Gmres(std::size_t most) : most_(most), basis_((kVectors + 1) * most) {}  ///< set-up

  /// (in realtime) Takes x from b to A⁻¹ b, until |b - A x| ≤ tolerance |b| or after kVectors applications; apply(u, y) writes A u into y,
  /// for |u| = |b|.
  template <class Apply>
  void solve(int size, double tolerance, Apply&& apply, double* x) noexcept {
    const double norm = length(x, size);
    if (!(norm > 0)) return;
    double upper[kVectors][kVectors + 1] = {}, right[kVectors + 1] = {1}, cosine[kVectors], sine[kVectors];
    std::copy_n(x, size, basis_.data());  // all vectors have the length of b
    int n = 0;
    while (n < kVectors && n < size && right[n] != 0 && std::abs(right[n]) > tolerance) {
      double* next = vector(n + 1);
      double* column = upper[n];
      apply(vector(n), next);
      for (int j = 0; j <= n; ++j) {
        column[j] = dot(next, vector(j), size) / (norm * norm);
        for (int i = 0; i < size; ++i) next[i] -= column[j] * vector(j)[i];
      }
      const double rest = length(next, size) / norm;
      if (rest > 0) std::for_each(next, next + size, [rest](double& u) { u /= rest; });
      for (int j = 0; j < n; ++j) {
        const double above = column[j];
        column[j] = cosine[j] * above + sine[j] * column[j + 1];
        column[j + 1] = cosine[j] * column[j + 1] - sine[j] * above;
      }
      const double radius = std::sqrt(column[n] * column[n] + rest * rest);
      if (!(radius > 0)) break;  // A is singular there
      cosine[n] = column[n] / radius, sine[n] = rest / radius;
      column[n] = radius;
      right[n + 1] = -sine[n] * right[n];
      right[n] *= cosine[n];
      ++n;
    }
    std::fill_n(x, size, 0.0);
    for (int k = n - 1; k >= 0; --k) {
      for (int j = k + 1; j < n; ++j) right[k] -= upper[j][k] * right[j];
      right[k] /= upper[k][k];
      for (int i = 0; i < size; ++i) x[i] += right[k] * vector(k)[i];
    }
  }

 private:
  double* vector(int k) noexcept { return basis_.data() + k * most_; }
  static double dot(const double* a, const double* b, int size) noexcept {
    double sum = 0;
    for (int i = 0; i < size; ++i) sum += a[i] * b[i];
    return sum;
  }
  static double length(const double* a, int size) noexcept { return std::sqrt(dot(a, a, size)); }

  std::size_t most_;
  std::vector<double> basis_;  ///< kVectors + 1 of them
};

}  // namespace haptic
