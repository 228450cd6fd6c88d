#include "haptic_core/dynamics/block_cholesky.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

// The kernels work on column-major blocks. N > 0 fixes a size at compile time: free bodies have 6.

/// A = L Lᵀ in place, lower triangle; false when a pivot is not positive.
template <int N>
bool factorDiagonal(double* a, int lda, int n_run) noexcept {
  const int n = N > 0 ? N : n_run;
  for (int j = 0; j < n; ++j) {
    double pivot = a[j + j * lda];
    for (int k = 0; k < j; ++k) pivot -= a[j + k * lda] * a[j + k * lda];
    if (!(pivot > 0)) return false;
    const double l = std::sqrt(pivot), inverse = 1 / l;
    a[j + j * lda] = l;
    for (int i = j + 1; i < n; ++i) {
      double sum = a[i + j * lda];
      for (int k = 0; k < j; ++k) sum -= a[i + k * lda] * a[j + k * lda];
      a[i + j * lda] = sum * inverse;
    }
  }
  return true;
}

/// X ← X L⁻ᵀ, X has `rows` rows and n columns.
template <int N>
void solvePanel(const double* l, int ldl, double* x, int ldx, int rows, int n_run) noexcept {
  const int n = N > 0 ? N : n_run;
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < j; ++k) {
      const double f = l[j + k * ldl];
      for (int i = 0; i < rows; ++i) x[i + j * ldx] -= f * x[i + k * ldx];
    }
    const double inverse = 1 / l[j + j * ldl];
    for (int i = 0; i < rows; ++i) x[i + j * ldx] *= inverse;
  }
}

/// C ← C − A Bᵀ with A ra×n, B rb×n.
template <int N>
void subtractOuter(const double* a, const double* b, int ld, double* c, int ldc, int ra, int rb, int n) noexcept {
  if constexpr (N > 0) {
    // Half the time of the loops below: the compiler cannot know that C is not a part of A, a column of its own is none.
    for (int j = 0; j < N; ++j) {
      double column[N];
      for (int i = 0; i < N; ++i) column[i] = c[i + j * ldc];
      for (int k = 0; k < N; ++k) {
        const double f = b[j + k * ld];
        for (int i = 0; i < N; ++i) column[i] -= a[i + k * ld] * f;
      }
      for (int i = 0; i < N; ++i) c[i + j * ldc] = column[i];
    }
    return;
  }
  for (int j = 0; j < rb; ++j) {
    for (int k = 0; k < n; ++k) {
      const double f = b[j + k * ld];
      for (int i = 0; i < ra; ++i) c[i + j * ldc] -= a[i + k * ld] * f;
    }
  }
}

/// x ← L⁻¹ x, of the lower triangle.
template <int N>
void solveLower(const double* l, int ldl, double* x, int n_run) noexcept {
  const int n = N > 0 ? N : n_run;
  for (int j = 0; j < n; ++j) {
    x[j] /= l[j + j * ldl];
    for (int i = j + 1; i < n; ++i) x[i] -= l[i + j * ldl] * x[j];
  }
}

/// x ← L⁻ᵀ x.
template <int N>
void solveUpper(const double* l, int ldl, double* x, int n_run) noexcept {
  const int n = N > 0 ? N : n_run;
  for (int j = n - 1; j >= 0; --j) {
    for (int i = j + 1; i < n; ++i) x[j] -= l[i + j * ldl] * x[i];
    x[j] /= l[j + j * ldl];
  }
}

/// y ← y − L x, L of rows × n.
template <int N>
void subtractProduct(const double* l, int ld, const double* x, double* y, int rows_run, int n_run) noexcept {
  const int n = N > 0 ? N : n_run, rows = N > 0 ? N : rows_run;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < rows; ++i) y[i] -= l[i + j * ld] * x[j];
  }
}

/// y ← y − Lᵀ x.
template <int N>
void subtractTransposed(const double* l, int ld, const double* x, double* y, int rows_run, int n_run) noexcept {
  const int n = N > 0 ? N : n_run, rows = N > 0 ? N : rows_run;
  for (int j = 0; j < n; ++j) {
    double sum = 0;
    for (int i = 0; i < rows; ++i) sum += l[i + j * ld] * x[i];
    y[j] -= sum;
  }
}

/// target ← target + block, or its transpose.
template <int N>
void addBlock(const double* block, int rows_run, int cols_run, bool transposed, double* target, int ld) noexcept {
  const int rows = N > 0 ? N : rows_run, cols = N > 0 ? N : cols_run;
  if (!transposed) {
    for (int j = 0; j < cols; ++j) {
      for (int i = 0; i < rows; ++i) target[i + j * ld] += block[i + j * rows];
    }
    return;
  }
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < cols; ++j) target[j + i * ld] += block[i + j * rows];
  }
}

/// Factor on a diagonal that leaves the rest of its row without any effect: beyond the square of a double's
/// resolution, far below its largest value.
constexpr double kPrescribed = 1e40;

void setBit(std::uint64_t* bits, int i) { bits[i >> 6] |= std::uint64_t{1} << (i & 63); }
void clearBit(std::uint64_t* bits, int i) { bits[i >> 6] &= ~(std::uint64_t{1} << (i & 63)); }

constexpr int kEliminated = std::numeric_limits<int>::max();

int countBits(const std::uint64_t* bits, int words) {
  int count = 0;
  for (int w = 0; w < words; ++w) count += __builtin_popcountll(bits[w]);
  return count;
}

/// Visits the bits that are set, in ascending order.
template <class Visit>
void eachBit(const std::uint64_t* bits, int words, Visit&& visit) {
  for (int w = 0; w < words; ++w) {
    for (std::uint64_t left = bits[w]; left != 0; left &= left - 1) visit(64 * w + __builtin_ctzll(left));
  }
}

}  // namespace

BlockCholesky::BlockCholesky(int max_nodes, int max_edges, std::size_t max_values, std::size_t usual_values)
    : max_nodes_(max_nodes), words_((max_nodes + 63) / 64), edges_(max_edges), size_(max_nodes),
      offset_(max_nodes + 1), position_(max_nodes), node_at_(max_nodes), degree_(max_nodes),
      adjacency_(static_cast<std::size_t>(max_nodes) * words_), columns_(max_nodes) {
  values_.reserve(max_values);
  values_.resize(std::min(usual_values, max_values));
  // A stored block has at least one value, so the structure cannot outgrow the values.
  const std::size_t dense = static_cast<std::size_t>(max_nodes) * (max_nodes + 1) / 2;
  structure_.resize(std::min(dense, max_values));
  row_offset_.resize(structure_.size());
}

void BlockCholesky::reserveKept() {
  kept_.reserve(values_.capacity());
  kept_.resize(values_.size());
}

bool BlockCholesky::sameStructure(const int* sizes, int nodes, const Edge* edges, int edge_count) const noexcept {
  return analyzed_ && nodes == nodes_ && edge_count == edge_count_ && std::equal(sizes, sizes + nodes, size_.begin()) &&
         std::equal(edges, edges + edge_count, edges_.begin(),
                    [](const Edge& x, const Edge& y) { return x.a == y.a && x.b == y.b; });
}

bool BlockCholesky::analyze(const int* sizes, int nodes, const Edge* edges, int edge_count) noexcept {
  if (!sameStructure(sizes, nodes, edges, edge_count)) {
    analyzed_ = false;
    if (nodes > max_nodes_ || edge_count > static_cast<int>(edges_.size())) return false;
    nodes_ = nodes;
    edge_count_ = edge_count;
    std::copy(edges, edges + edge_count, edges_.begin());
    offset_[0] = 0;
    for (int i = 0; i < nodes; ++i) {
      size_[i] = sizes[i];
      offset_[i + 1] = offset_[i] + sizes[i];
    }
    rows_ = offset_[nodes];
    order();
    if (!layOut()) return false;
    analyzed_ = true;
  }
  std::fill(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(used_), 0.0);
  return true;
}

/// Eliminates the node with the fewest neighbours left (the lowest index among equals, so that the order is a
/// function of the graph), and joins its neighbours. On return a node's bit row is the fill below its diagonal.
void BlockCholesky::order() noexcept {
  std::fill(adjacency_.begin(), adjacency_.begin() + static_cast<std::ptrdiff_t>(nodes_) * words_, 0);
  for (int e = 0; e < edge_count_; ++e) {
    setBit(bits(edges_[e].a), edges_[e].b);
    setBit(bits(edges_[e].b), edges_[e].a);
  }
  const int words = (nodes_ + 63) / 64;  // the rows are as long as the largest graph's
  for (int node = 0; node < nodes_; ++node) degree_[node] = countBits(bits(node), words);
  for (int step = 0; step < nodes_; ++step) {
    const int best = static_cast<int>(std::min_element(degree_.begin(), degree_.begin() + nodes_) - degree_.begin());
    position_[best] = step;
    node_at_[step] = best;
    degree_[best] = kEliminated;
    const std::uint64_t* eliminated = bits(best);
    eachBit(eliminated, words, [&](int node) {
      for (int w = 0; w < words; ++w) bits(node)[w] |= eliminated[w];
      clearBit(bits(node), node);
      clearBit(bits(node), best);
      degree_[node] = countBits(bits(node), words);
    });
  }
}

bool BlockCholesky::layOut() noexcept {
  const int words = (nodes_ + 63) / 64;
  std::size_t start = 0, entries = 0;
  products_ = 0;
  for (int p = 0; p < nodes_; ++p) {
    const int node = node_at_[p];
    Column& column = columns_[p];
    column = {size_[node], static_cast<int>(entries), 0, size_[node], start};
    column.count = countBits(bits(node), words);
    if (entries + column.count > structure_.size()) return false;
    eachBit(bits(node), words, [&](int other) { structure_[entries++] = position_[other]; });
    std::sort(structure_.begin() + column.first, structure_.begin() + column.first + column.count);
    for (int s = column.first; s < column.first + column.count; ++s) {
      row_offset_[s] = column.height;
      column.height += size_[node_at_[structure_[s]]];
    }
    start += static_cast<std::size_t>(column.height) * column.size;
    products_ += 0.5 * column.size * column.height * column.height;
    if (start > values_.capacity()) return false;
  }
  used_ = start;
  // Within the capacity, so nothing is allocated; pages that no matrix has needed before are new, once.
  if (used_ > values_.size()) values_.resize(used_);
  return true;
}

double* BlockCholesky::blockAt(int row_position, int p) noexcept {
  const Column& column = columns_[p];
  double* base = values_.data() + column.start;
  if (row_position == p) return base;
  const int* first = structure_.data() + column.first;
  const int* found = std::lower_bound(first, first + column.count, row_position);
  return base + row_offset_[column.first + (found - first)];
}

void BlockCholesky::add(int a, int b, const double* values) noexcept {
  const int pa = position_[a], pb = position_[b];
  const bool transposed = pa < pb;
  const int row = transposed ? pb : pa, column = transposed ? pa : pb;
  const auto addTo = size_[a] == 6 && size_[b] == 6 ? addBlock<6> : addBlock<0>;
  addTo(values, size_[a], size_[b], transposed, blockAt(row, column), columns_[column].height);
}

void BlockCholesky::keep() noexcept {
  if (used_ > kept_.size()) kept_.resize(used_);  // as in `layOut`
  std::copy(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(used_), kept_.begin());
}

void BlockCholesky::recall() noexcept {
  std::copy(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(used_), values_.begin());
}

void BlockCholesky::addDiagonal(int node, int i, double value) noexcept {
  const Column& column = columns_[position_[node]];
  values_[column.start + static_cast<std::size_t>(i) * (column.height + 1)] += value;
}

double BlockCholesky::prescribe(int node, int i) noexcept {
  const Column& column = columns_[position_[node]];
  double& diagonal = values_[column.start + static_cast<std::size_t>(i) * (column.height + 1)];
  return diagonal *= kPrescribed;
}

void BlockCholesky::multiplyKept(const double* x, double* y) noexcept {
  std::fill(y, y + rows_, 0.0);
  for (int p = 0; p < nodes_; ++p) {
    const Column& column = columns_[p];
    const int own = offset_[node_at_[p]];
    for (int j = 0; j < column.size; ++j) {
      const double* a = kept_.data() + column.start + static_cast<std::size_t>(j) * column.height;
      y[own + j] += a[j] * x[own + j];
      for (int i = j + 1; i < column.size; ++i) {
        y[own + i] += a[i] * x[own + j];
        y[own + j] += a[i] * x[own + i];
      }
      for (int s = column.first; s < column.first + column.count; ++s) {
        const int node = node_at_[structure_[s]];
        for (int i = 0; i < size_[node]; ++i) {
          y[offset_[node] + i] += a[row_offset_[s] + i] * x[own + j];
          y[own + j] += a[row_offset_[s] + i] * x[offset_[node] + i];
        }
      }
    }
  }
}

bool BlockCholesky::factor() noexcept {
  for (int p = 0; p < nodes_; ++p) {
    const Column& column = columns_[p];
    double* base = values_.data() + column.start;
    const int ld = column.height, n = column.size;
    const bool six = n == 6;
    if (!(six ? factorDiagonal<6>(base, ld, n) : factorDiagonal<0>(base, ld, n))) return false;
    (six ? solvePanel<6> : solvePanel<0>)(base, ld, base + n, ld, ld - n, n);
    for (int s = column.first; s < column.first + column.count; ++s) {
      const Column& target = columns_[structure_[s]];
      int below = target.first;  // its blocks hold all of these, in the same order
      for (int t = s; t < column.first + column.count; ++t) {
        const int ra = columns_[structure_[t]].size;
        double* c = values_.data() + target.start;
        if (t > s) {
          while (structure_[below] != structure_[t]) ++below;
          c += row_offset_[below];
        }
        const auto subtract = six && ra == 6 && target.size == 6 ? subtractOuter<6> : subtractOuter<0>;
        subtract(base + row_offset_[t], base + row_offset_[s], ld, c, target.height, ra, target.size, n);
      }
    }
  }
  return true;
}

void BlockCholesky::solve(double* x) noexcept {
  for (int p = 0; p < nodes_; ++p) {  // L y = x
    const Column& column = columns_[p];
    const double* l = values_.data() + column.start;
    const int ld = column.height, n = column.size;
    double* own = x + offset_[node_at_[p]];
    (n == 6 ? solveLower<6> : solveLower<0>)(l, ld, own, n);
    for (int s = column.first; s < column.first + column.count; ++s) {
      const int node = node_at_[structure_[s]], rows = size_[node];
      const auto subtract = n == 6 && rows == 6 ? subtractProduct<6> : subtractProduct<0>;
      subtract(l + row_offset_[s], ld, own, x + offset_[node], rows, n);
    }
  }
  for (int p = nodes_ - 1; p >= 0; --p) {  // Lᵀ x = y
    const Column& column = columns_[p];
    const double* l = values_.data() + column.start;
    const int ld = column.height, n = column.size;
    double* own = x + offset_[node_at_[p]];
    for (int s = column.first; s < column.first + column.count; ++s) {
      const int node = node_at_[structure_[s]], rows = size_[node];
      const auto subtract = n == 6 && rows == 6 ? subtractTransposed<6> : subtractTransposed<0>;
      subtract(l + row_offset_[s], ld, x + offset_[node], own, rows, n);
    }
    (n == 6 ? solveUpper<6> : solveUpper<0>)(l, ld, own, n);
  }
}

}  // namespace haptic
