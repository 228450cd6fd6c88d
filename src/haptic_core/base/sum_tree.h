/// Sums of many numbers of which few change: in one fixed order, whichever are set anew.
///
/// Numbers are the leaves of a binary tree whose nodes are sums of their two children. To change one costs log₂ N additions; numbers
/// that are not set anew contribute the same bits as before. So a sum is the same whether all numbers were computed or only those that
/// changed.
#pragma once
#include <array>
#include <vector>

namespace haptic {

/// N rows of `kColumns` numbers, and the sum of each column.
template <int kColumns>
class SumTree {
 public:
  using Row = std::array<double, kColumns>;  ///< one number of each column

  explicit SumTree(std::size_t rows = 1) {  ///< set-up: all zero
    while (leaves_ < rows) leaves_ *= 2;
    node_.assign(2 * leaves_, Row{});
  }

  /// (in realtime) O(log N), or O(1) where the row does not change.
  void set(std::size_t i, const Row& row) noexcept {
    std::size_t n = leaves_ + i;
    if (node_[n] == row) return;
    node_[n] = row;
    while ((n /= 2) > 0) {
      for (int c = 0; c < kColumns; ++c) node_[n][c] = node_[2 * n][c] + node_[2 * n + 1][c];
    }
  }
  const Row& sum() const { return node_[1]; }  ///< of each column

 private:
  std::size_t leaves_ = 1;
  std::vector<Row> node_;  ///< 1 is the root; the children of n are 2 n and 2 n + 1
};

}  // namespace haptic
