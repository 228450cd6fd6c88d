#include "haptic_core/stepping/implicit_joints.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

/// Inertia and contacts of an island: A p = −r + g (forces).
class IslandOperator final : public JointOperator {
 public:
  /// Where a row of the matrix stands.
  struct Rows {
    const int *velocity, *node, *local;
    int count;
  };
  /// Room by row: `diag`, `product`.
  IslandOperator(BlockCholesky& matrix, const Rows& rows, const double* residual, double g, double* diag, double* product)
      : matrix_(matrix), rows_(rows), residual_(residual), g_(g), diag_(diag), product_(product) {}

  bool factor(const double* diag) noexcept override {
    if (factored_) matrix_.recall();
    factored_ = true;
    for (int i = 0; i < rows_.count; ++i) {
      const bool prescribed = std::isinf(diag[i]);
      diag_[i] = prescribed ? matrix_.prescribe(rows_.node[i], rows_.local[i]) : 0;
      if (!prescribed && diag[i] != 0) matrix_.addDiagonal(rows_.node[i], rows_.local[i], diag[i]);
    }
    return matrix_.factor();
  }
  void solve(const double* force, double* p) noexcept override {
    for (int i = 0; i < rows_.count; ++i) {
      p[i] = diag_[i] != 0 ? diag_[i] * p[i] : -residual_[rows_.velocity[i]] + g_ * force[i];
    }
    matrix_.solve(p);
    multiplied_ = false;
  }
  void respond(const double* force, double* x) noexcept override {
    std::copy_n(force, rows_.count, x);
    matrix_.solve(x);
  }
  double required(int, int row, const double* p) noexcept override {
    if (!multiplied_) matrix_.multiplyKept(p, product_);
    multiplied_ = true;
    return (product_[row] + residual_[rows_.velocity[row]]) / g_;
  }

 private:
  BlockCholesky& matrix_;
  const Rows rows_;
  const double* residual_;
  const double g_;
  double *diag_, *product_;  ///< prescribed diagonals, else 0; A p of the last solve
  bool factored_ = false, multiplied_ = false;
};

}  // namespace

ImplicitJoints::ImplicitJoints(const Model& model) : model_(model), force_(model.links.size()), row_(model.nv) {
  for (const ModelTree& tree : model.trees) {
    if (tree.has_laws) joints_.add(*tree.model, tree.rings, {tree.link, tree.command, tree.q, tree.v});
  }
  if (joints_.empty()) return;
  joints_.reserveRows(model.nv);
  for (auto* by_row : {&velocity_, &node_, &local_}) by_row->resize(model.nv);
  for (auto* by_row : {&diag_, &product_, &p_}) by_row->resize(model.nv);
}

void ImplicitJoints::setNodes(const std::vector<int>& node_of_tree, int nodes) noexcept {
  rows_ = 0;
  std::fill(row_.begin(), row_.end(), JointSolver::kAbsent);
  for (std::size_t t = 0, n = 0; t < model_.trees.size() && static_cast<int>(n) < nodes; ++t) {
    if (node_of_tree[t] < 0) continue;
    const ModelTree& tree = model_.trees[t];
    for (int i = 0; i < tree.model->nv(); ++i, ++rows_) {
      velocity_[rows_] = tree.v + i;
      node_[rows_] = node_of_tree[t];
      local_[rows_] = i;
      row_[tree.v + i] = rows_;
    }
    ++n;
  }
  joints_.select(rows_, [this](int v) { return row_[v]; });
}

void ImplicitJoints::startStage(const State& state, const double* q_base, double g, double* v) noexcept {
  g_ = g;
  converged_ = true;
  commands_ = state.commands.data();
  joints_.start(commands_, q_base, g);
  joints_.putWithinLimits(v);
  joints_.standAt(v);
}

bool ImplicitJoints::solve(BlockCholesky& matrix, const LinkWork* work, const double* q, const double* v,
                           const double* residual, double open, double* p) noexcept {
  joints_.lookAtRings(work, q, open, nullptr);
  matrix.keep();
  IslandOperator island(matrix, {velocity_.data(), node_.data(), local_.data(), rows_}, residual, g_, diag_.data(),
                        product_.data());
  const JointSolver::Found found = joints_.solve(island, v, p_.data());
  for (int i = 0; i < rows_; ++i) p[velocity_[i]] = p_[i];
  converged_ = found != JointSolver::Found::kCycled;
  return found != JointSolver::Found::kUnsolved;
}

void ImplicitJoints::solveAgain(BlockCholesky& matrix, const double* v, const double* residual, double* p) noexcept {
  IslandOperator island(matrix, {velocity_.data(), node_.data(), local_.data(), rows_}, residual, g_, diag_.data(),
                        product_.data());
  joints_.solveAgain(island, v, p_.data());
  for (int i = 0; i < rows_; ++i) p[velocity_[i]] = p_[i];
}

void ImplicitJoints::closeAccount(State& state) const noexcept {
  state.energy.damping += work_.damping;
  state.energy.friction += work_.friction;
  state.energy.external += work_.drives;
}

}  // namespace haptic
