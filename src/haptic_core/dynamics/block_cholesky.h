/// Cholesky factorisation of a symmetric positive definite matrix whose blocks follow a graph.
///
/// Nodes are the trees of an island (block size = its degrees of freedom), edges its contacts. The implicit step
/// solves (M + h D + h² K) Δv = r with it. A stack of n free bodies costs about 600 n flops.
///
/// Method. Greedy minimum-degree ordering on the block graph, symbolic elimination, then a right-looking block
/// factorisation A = L Lᵀ: for each column, factor the diagonal block, solve the panel below it, subtract the
/// panel's outer product from the columns to come (George & Liu, Computer Solution of Large Sparse Positive
/// Definite Systems, 1981). The analysis is kept while the graph stays the same; it is a function of sizes and
/// edges alone, so keeping it cannot change a bit.
///
/// No heap after construction. `analyze` fails, and says so, when the capacity does not hold the fill.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace haptic {

/// A sparse Cholesky factorisation by blocks: one matrix at a time, of any graph within the capacity.
class BlockCholesky {
 public:
  /// Two nodes with a block between them.
  struct Edge {
    int a = 0, b = 0;  ///< node indices, a ≠ b; repeated edges are fine
  };

  /// At most `max_nodes` blocks, `max_edges` edges and `max_values` doubles in the factor. Of these `usual_values` are in memory from now
  /// on; further ones take address space alone until a matrix needs them.
  BlockCholesky(int max_nodes, int max_edges, std::size_t max_values, std::size_t usual_values);
  void reserveKept();  ///< before the first `keep`: the same room for it

  /// (in realtime) Fixes the structure and zeroes the matrix. False: more nodes, edges or fill than the capacity.
  bool analyze(const int* block_sizes, int nodes, const Edge* edges, int edge_count) noexcept;

  /// (in realtime) Adds to A: `values` is a column-major block at (node a, node b), a and b on an edge or equal.
  /// Of an off-diagonal pair one of (a, b), (b, a) is given; of a diagonal block all of it.
  void add(int a, int b, const double* values) noexcept;

  /// (in realtime) Keeps A as it stands, so that `recall` brings it back after `factor` has overwritten it.
  void keep() noexcept;
  void recall() noexcept;  ///< (in realtime) A becomes what `keep` kept
  /// (in realtime) Adds to the diagonal at row i of a node.
  void addDiagonal(int node, int i, double value) noexcept;
  /// (in realtime) Makes the diagonal at row i of a node so large that b there, times what this returns, is x there to
  /// the last bit: a prescribed unknown. Cholesky loses nothing by it, being invariant to the scale of rows.
  double prescribe(int node, int i) noexcept;
  /// (in realtime) y = A x with the A that `keep` kept.
  void multiplyKept(const double* x, double* y) noexcept;

  /// (in realtime) Factors in place. False: a pivot is not positive (the matrix is not positive definite).
  bool factor() noexcept;

  /// (in realtime) x ← A⁻¹ x; x is ordered by node as given to `analyze`.
  void solve(double* x) noexcept;

  int rows() const { return rows_; }            ///< of A: the sum of the block sizes
  std::size_t values() const { return used_; }  ///< doubles that the factor holds, fill included
  double products() const { return products_; }  ///< multiplications of `factor`, to a factor of 1.5

 private:
  struct Column {
    int size = 0;              ///< of the diagonal block
    int first = 0, count = 0;  ///< range in `structure_`: the blocks below the diagonal
    int height = 0;            ///< rows of the panel, diagonal block included = leading dimension
    std::size_t start = 0;     ///< in `values_`
  };
  bool sameStructure(const int* sizes, int nodes, const Edge* edges, int edge_count) const noexcept;
  void order() noexcept;
  bool layOut() noexcept;
  double* blockAt(int row_position, int column) noexcept;
  std::uint64_t* bits(int node) noexcept { return adjacency_.data() + static_cast<std::size_t>(node) * words_; }

  int max_nodes_, words_;
  int nodes_ = 0, edge_count_ = 0, rows_ = 0;
  std::size_t used_ = 0;
  double products_ = 0;
  bool analyzed_ = false;
  std::vector<Edge> edges_;
  std::vector<int> size_, offset_, position_, node_at_;  // by node, by node, node → position, position → node
  std::vector<int> degree_;                              // within `order`, by node: neighbours left; kEliminated
  std::vector<std::uint64_t> adjacency_;                 // a bit row per node; after `order` its fill
  std::vector<Column> columns_;                          // by position
  std::vector<int> structure_, row_offset_;              // positions below a diagonal block; their panel rows
  std::vector<double> values_, kept_;                    // their sizes grow within their capacities
};

}  // namespace haptic
