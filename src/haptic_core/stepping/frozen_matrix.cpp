#include "haptic_core/stepping/frozen_matrix.h"

#include <algorithm>

#include "haptic_core/base/lane_vector.h"
#include "haptic_core/base/transposed_product.h"
#include "haptic_core/dynamics/joint_space_inertia.h"
#include "haptic_core/dynamics/kinematics.h"

namespace haptic {
namespace {

/// Of the dense factor, 64 MB [doubles].
constexpr std::size_t kMostValues = std::size_t{8} << 20;

/// Doubles of the matrix of all trees and joins, without fill, at most: an island needs no more unless its bodies meet in many rings.
/// Two free bodies meet in a block of 6 × 6, one for each join; a tree on joints meets each other tree once.
std::size_t valuesWithoutFill(const Model& model, int join_capacity) {
  std::size_t sum = 36 * static_cast<std::size_t>(join_capacity);
  for (const ModelTree& tree : model.trees) {
    const auto nv = static_cast<std::size_t>(tree.model->nv());
    sum += nv * (tree.model->isFreeBody() ? nv : static_cast<std::size_t>(model.nv));
  }
  return sum;
}

using JacobianMap = Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>>;

}  // namespace

FrozenMatrix::FrozenMatrix(const Model& model, int join_capacity)
    : model_(model),
      blocks_(static_cast<int>(model.trees.size()), join_capacity,
              std::min<std::size_t>(static_cast<std::size_t>(model.nv) * (model.nv + 1), kMostValues),
              valuesWithoutFill(model, join_capacity)) {
  row_of_tree_.assign(model.trees.size(), -1);
  for (auto* x : {&trees_, &size_}) x->reserve(model.trees.size());
  std::size_t largest = 1, offset = 0;
  bool jointed = false;
  for (const ModelTree& tree : model.trees) {
    const std::size_t nv = static_cast<std::size_t>(tree.model->nv());
    mass_offset_.push_back(offset);
    offset += nv * nv;
    largest = std::max(largest, nv);
    jointed |= tree.has_laws;
  }
  masses_.resize(offset);
  edges_.reserve(join_capacity);
  block_.resize(largest * largest);
  for (auto* J : {&jacobian_a_, &jacobian_b_, &weighted_}) J->resize(6 * largest);
  if (jointed) blocks_.reserveKept();
}

void FrozenMatrix::freeze(int t, LinkWork* work) noexcept {
  const ModelTree& tree = model_.trees[t];
  double* M = masses_.data() + mass_offset_[t];
  if (!tree.model->isFreeBody()) {
    massMatrix(*tree.model, work + tree.link, M);
    return;
  }
  const LinkModel& body = tree.model->link(0);
  const Matrix3& R_WL = work[tree.link].X_WL.R;
  Eigen::Map<Matrix6> block(M);
  block.setZero();
  block.topLeftCorner<3, 3>() = R_WL * body.I_O * R_WL.transpose();
  block(3, 3) = block(4, 4) = block(5, 5) = body.mass;
}

double FrozenMatrix::massNorm2(const int* trees, int count, const double* u) const noexcept {
  double sum = 0;
  for (int n = 0; n < count; ++n) {
    const ModelTree& tree = model_.trees[trees[n]];
    const double *M = massOf(trees[n]), *p = u + tree.v;
    const int nv = tree.model->nv();
    if (nv == 6) {
      const Eigen::Map<const Vector6> x(p);
      sum += x.dot(Eigen::Map<const Matrix6>(M) * x);
      continue;
    }
    for (int j = 0; j < nv; ++j) {
      for (int i = 0; i < nv; ++i) sum += p[i] * M[i + j * nv] * p[j];
    }
  }
  return sum;
}

void FrozenMatrix::select(const IslandPart& part, LinkWork* work) noexcept {
  work_ = work;
  for (const int tree : trees_) row_of_tree_[tree] = -1;
  trees_.assign(part.trees, part.trees + part.tree_count);
  size_.resize(part.tree_count);
  for (int n = 0; n < part.tree_count; ++n) {
    row_of_tree_[trees_[n]] = n;
    size_[n] = model_.trees[trees_[n]].model->nv();
  }
}

bool FrozenMatrix::assemble(const IslandPart& part, LoadedVector<FrozenContact>& contacts, const LoadedVector<FrozenForce>& forces,
                            double g) noexcept {
  edges_.clear();
  const auto join = [this](int a, int b) {
    if (a >= 0 && b >= 0 && a != b) edges_.push_back({a, b});
  };
  for (int i = 0; i < part.contact_count; ++i) {
    const FrozenContact& c = contacts[part.contacts[i]];
    join(rowOf(c.link_a), rowOf(c.link_b));
  }
  for (int i = 0; i < part.force_count; ++i) {
    const FrozenForce& c = forces[part.forces[i]];
    join(rowOrWorld(c.link_a), rowOf(c.link_b));
  }
  if (!blocks_.analyze(size_.data(), part.tree_count, edges_.begin(), edges_.size())) return false;
  for (int n = 0; n < part.tree_count; ++n) blocks_.add(n, n, massOf(part.trees[n]));
  for (int i = 0; i < part.contact_count; ++i) addContact(contacts[part.contacts[i]]);
  for (int i = 0; i < part.force_count; ++i) addForce(forces[part.forces[i]], g);
  return true;
}

/// Rows: the twist at P in P's axes, angular first; columns: the degrees of the link's tree.
void FrozenMatrix::treeJacobian(int link, const Matrix3& R_WP, const Vector3& p_W, double* J) noexcept {
  const ModelLink& entry = model_.links[link];
  const ModelTree& tree = model_.trees[entry.articulation];
  const int nv = tree.model->nv();
  const Matrix3 R_PW = R_WP.transpose();
  JacobianMap map(J, 6, nv);
  map.setZero();
  pointJacobian(*tree.model, work_ + tree.link, entry.local, p_W, J, nv);
  for (int c = 0; c < nv; ++c) {
    map.col(c).head<3>() = Vector3(R_PW * Vector3(map.col(c).head<3>()));
    map.col(c).tail<3>() = Vector3(R_PW * Vector3(map.col(c).tail<3>()));
  }
}

void FrozenMatrix::addContact(FrozenContact& c) noexcept {
  const int a = rowOf(c.link_a), b = rowOf(c.link_b);
  c.G = c.patch.tangent(c.V, c.force);
  if ((a >= 0 && !isFree(c.link_a)) || (b >= 0 && !isFree(c.link_b))) {
    addLinks({{c.link_a, c.link_b}, {&c.X_WP.p, &c.X_WP.p}, c.X_WP.R}, c.G);
    return;
  }
  addFree(a, b, {{c.link_a, c.link_b}, {&c.X_WP.p, &c.X_WP.p}, c.X_WP.R}, c.G);
}

void FrozenMatrix::addForce(const FrozenForce& c, double g) noexcept {
  const int a = rowOrWorld(c.link_a), b = rowOf(c.link_b);
  const Matrix3 R = Matrix3::Identity();
  const Ends ends{{c.link_a, c.link_b}, {&c.p_WA, &c.p_WB}, R};
  Matrix6 G = Matrix6::Zero();
  G.topLeftCorner<3, 3>() = c.turn;
  G.bottomRightCorner<3, 3>() = c.way;
  if (c.lined) G.bottomRightCorner<3, 3>() += c.lineSlope(g) * c.line.n * c.line.n.transpose();
  if ((a >= 0 && !isFree(c.link_a)) || (b >= 0 && !isFree(c.link_b))) {
    addLinks(ends, G);
  } else {
    addFree(a, b, ends, G);
  }
}

/// Jᵀ G J of free bodies, row -1 for none. With G in W's axes in blocks [A B; Bᵀ D], a body's lever r to its point and X = [r]×,
/// J = [1 0; -X 1], so that with Q = B + X D the block of two bodies i, j is
///     J_iᵀ G J_j = [A - B X_j + X_i Q_jᵀ   Q_i; Q_jᵀ   D].
void FrozenMatrix::addFree(int a, int b, const Ends& ends, const Matrix6& G) noexcept {
  const LaneMatrix R(ends.R_WP), back = transposed(R);
  const auto inW = [&](int row, int column) { return R * LaneMatrix(Matrix3(G.block<3, 3>(row, column))) * back; };
  const LaneMatrix A = inW(0, 0), B = inW(0, 3), D = inW(3, 3);
  const int node[2] = {a, b};
  Lanes r[2] = {lanes(0), lanes(0)};
  LaneMatrix Q[2] = {B, B};
  for (int s = 0; s < 2; ++s) {
    if (node[s] < 0) continue;
    const Vector3 lever = *ends.p_W[s] - work_[ends.link[s]].p_WO;
    r[s] = laneVector(lever.x(), lever.y(), lever.z());
    Q[s] = B + cross(r[s], D);
  }
  double block[36 + 1];  // a fourth lane is written beyond each three, and then over
  for (int i = 0; i < 2; ++i) {
    for (int j = i; j < 2; ++j) {
      if (node[i] < 0 || node[j] < 0) continue;
      const LaneMatrix Q_j = transposed(Q[j]), turning = A - cross(B, r[j]) + cross(r[i], Q_j);
      const Lanes sign = lanes(i == j ? 1 : -1);
      for (int k = 0; k < 3; ++k) {
        storeLanes(sign * turning.column[k], block + 6 * k);
        storeLanes(sign * Q_j.column[k], block + 6 * k + 3);
      }
      for (int k = 0; k < 3; ++k) {
        storeLanes(sign * Q[i].column[k], block + 18 + 6 * k);
        storeLanes(sign * D.column[k], block + 18 + 6 * k + 3);
      }
      blocks_.add(node[i], node[j], block);
    }
  }
}

/// Jᵀ G J of a patch between two links, link A -1 for none; at least one of them is on joints.
void FrozenMatrix::addLinks(const Ends& ends, const Matrix6& G_P) noexcept {
  double* J[2] = {jacobian_a_.data(), jacobian_b_.data()};
  int node[2], size[2];
  for (int s = 0; s < 2; ++s) {
    node[s] = rowOrWorld(ends.link[s]);
    size[s] = node[s] >= 0 ? size_[node[s]] : 0;
    if (node[s] >= 0) treeJacobian(ends.link[s], ends.R_WP, *ends.p_W[s], J[s]);
  }
  if (node[0] >= 0 && node[0] == node[1]) {  // two links of one tree: J = J_b - J_a
    for (int i = 0; i < 6 * size[0]; ++i) J[1][i] -= J[0][i];
    node[0] = -1;
  }
  for (int s = 0; s < 2; ++s) {
    if (node[s] < 0) continue;
    transposedProduct(G_P.data(), 6, J[s], size[s], weighted_.data());  // G is stored by columns: Gᵀ by rows
    for (int t = 0; t <= s; ++t) {
      if (node[t] < 0) continue;
      transposedProduct(weighted_.data(), size[s], J[t], size[t], block_.data());  // by rows: the block by columns
      if (s != t) {
        for (int i = 0; i < size[s] * size[t]; ++i) block_[i] = -block_[i];
      }
      blocks_.add(node[t], node[s], block_.data());
    }
  }
}

}  // namespace haptic
