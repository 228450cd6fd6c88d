#include "haptic_core/stepping/implicit_joints.h"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

/// A joint moves by less than this within a stage where it counts as standing [rad] or [m]: rounding of a
/// position. Wider, steps that hit a limit would pass for smooth; narrower, joints at rest on a limit would
/// never.
constexpr double kStanding = 1e-12;

}  // namespace

ImplicitJoints::ImplicitJoints(const Model& model)
    : model_(model), row_(model.nv), velocity_(model.nv), drive_(model.links.size()) {
  std::size_t G_size = 0;
  for (int t = 0; t < static_cast<int>(model.trees.size()); ++t) {
    const ModelTree& tree = model.trees[t];
    if (!tree.has_laws) continue;
    laws_.add(*tree.model, tree.link, tree.command, tree.q, tree.v);
    for (std::size_t k = law_place_.size(); k < laws_.laws().size(); ++k) {
      law_place_.push_back({t, laws_.laws()[k].v - tree.v});
    }
    for (std::size_t k = damped_place_.size(); k < laws_.damped().size(); ++k) {
      damped_place_.push_back({t, laws_.damped()[k].v - tree.v});
    }
    Rings rings(*tree.model, tree.rings);
    if (rings.empty()) continue;
    G_size += static_cast<std::size_t>(rings.rows()) * tree.model->nv();
    rings_.push_back({t, rings, rows_, nullptr});
    rows_ += rings.rows();
  }
  law_force_.resize(laws_.laws().size());
  G_.resize(G_size);
  double* G = G_.data();
  for (TreeRings& r : rings_) {
    r.G = G;
    G += r.rings.rows() * model.trees[r.tree].model->nv();
  }
  if (empty()) return;
  for (auto* v : {&rhs_, &p_, &force_}) v->resize(model.nv);
  for (auto* v : {&phi_, &mu_, &rate_}) v->resize(rows_);
  Y_.resize(static_cast<std::size_t>(rows_) * model.nv);
  S_ = PivotedCholesky(rows_);
}

void ImplicitJoints::setNodes(const std::vector<int>& node_of_tree, int nodes) noexcept {
  matrix_rows_ = 0;
  std::fill(row_.begin(), row_.end(), -1);
  for (std::size_t t = 0, n = 0; t < model_.trees.size() && static_cast<int>(n) < nodes; ++t) {
    if (node_of_tree[t] < 0) continue;
    const ModelTree& tree = model_.trees[t];
    for (int i = tree.v; i < tree.v + tree.model->nv(); ++i) {
      velocity_[matrix_rows_] = i;
      row_[i] = matrix_rows_++;
    }
    ++n;
  }
  for (std::vector<Place>* places : {&law_place_, &damped_place_}) {
    for (Place& place : *places) {
      place.node = node_of_tree[place.tree];
      place.row = row_[model_.trees[place.tree].v + place.local];
    }
  }
  for (TreeRings& r : rings_) r.first = row_[model_.trees[r.tree].v];
}

void ImplicitJoints::startStage(const State& state, const double* q_base, double g, double* v) noexcept {
  g_ = g;
  converged_ = true;
  commands_ = state.commands.data();
  std::fill(mu_.begin(), mu_.end(), 0.0);
  std::fill(law_force_.begin(), law_force_.end(), 0.0);
  laws_.start(commands_, q_base, g);
  laws_.putWithinLimits(v);
  laws_.standAt(v);
}

bool ImplicitJoints::solve(BlockCholesky& matrix, const LinkWork* work, const double* q, const double* v,
                           const double* residual, double open, double* p) noexcept {
  matrix.keep();
  evaluateRings(work, q, open);
  const auto solve = [&](int pass) {
    if (pass > 0) matrix.recall();
    setUp(matrix, v, residual);
    if (!matrix.factor()) return false;
    std::copy(rhs_.begin(), rhs_.begin() + matrix_rows_, p_.begin());
    matrix.solve(p_.data());
    closeRings(matrix);
    for (int i = 0; i < matrix_rows_; ++i) p[velocity_[i]] = p_[i];
    matrix.multiplyKept(p_.data(), force_.data());
    for (int i = 0; i < matrix_rows_; ++i) force_[i] += residual[velocity_[i]];
    readForces();
    return true;
  };
  const auto outcome = [&](std::size_t k) -> JointLaws::Outcome {
    const double v0 = v[laws_.laws()[k].v];
    return {v0, v0 + p_[law_place_[k].row], law_force_[k]};
  };
  const JointLaws::Found found = laws_.search(solve, outcome);
  converged_ = found != JointLaws::Found::kCycled;
  return found != JointLaws::Found::kUnsolved;
}

/// Diagonal and right side of the pieces that the joints are on.
void ImplicitJoints::setUp(BlockCholesky& matrix, const double* v, const double* residual) noexcept {
  for (int i = 0; i < matrix_rows_; ++i) rhs_[i] = -residual[velocity_[i]];
  for (std::size_t k = 0; k < damped_place_.size(); ++k) {
    const Place& place = damped_place_[k];
    const JointLaws::Damped& d = laws_.damped()[k];
    matrix.addDiagonal(place.node, place.local, g_ * d.damping);
    rhs_[place.row] -= g_ * d.damping * v[d.v];
  }
  for (std::size_t k = 0; k < law_place_.size(); ++k) {
    const Place& place = law_place_[k];
    const ForcePiece& piece = laws_.laws()[k].now();
    const double rate = v[laws_.laws()[k].v];
    if (piece.vertical) {
      rhs_[place.row] = matrix.prescribe(place.node, place.local) * (piece.from - rate);
    } else {
      matrix.addDiagonal(place.node, place.local, g_ * piece.slope);
      rhs_[place.row] += g_ * (piece.offset - piece.slope * rate);
    }
  }
}

void ImplicitJoints::evaluateRings(const LinkWork* work, const double* q, double open) noexcept {
  for (const TreeRings& r : rings_) {
    const ModelTree& tree = model_.trees[r.tree];
    r.rings.residual(work + tree.link, q + tree.q, &phi_[r.row]);
    r.rings.jacobian(work + tree.link, r.G);
    for (int i = r.row; i < r.row + r.rings.rows(); ++i) phi_[i] *= open;
  }
}

/// p += A⁻¹ Gᵀ μ with μ such that G p = −φ/g.
void ImplicitJoints::closeRings(BlockCholesky& matrix) noexcept {
  if (rows_ == 0) return;
  for (const TreeRings& r : rings_) {
    const int nv = model_.trees[r.tree].model->nv();
    for (int i = 0; i < r.rings.rows(); ++i) {
      double* Y = &Y_[static_cast<std::size_t>(r.row + i) * model_.nv];
      std::fill(Y, Y + matrix_rows_, 0.0);
      std::copy(r.G + i * nv, r.G + (i + 1) * nv, Y + r.first);
      matrix.solve(Y);
    }
  }
  const auto dot = [&](const TreeRings& r, int i, const double* x) {  // row i of G times x
    const int nv = model_.trees[r.tree].model->nv();
    double sum = 0;
    for (int k = 0; k < nv; ++k) sum += r.G[i * nv + k] * x[r.first + k];
    return sum;
  };
  for (const TreeRings& r : rings_) {
    for (int i = 0; i < r.rings.rows(); ++i) {
      for (int c = 0; c < rows_; ++c) {
        S_.matrix()[(r.row + i) * rows_ + c] = dot(r, i, &Y_[static_cast<std::size_t>(c) * model_.nv]);
      }
      mu_[r.row + i] = -phi_[r.row + i] / g_ - dot(r, i, p_.data());
    }
  }
  S_.factor(rows_);
  S_.solve(mu_.data());
  for (int c = 0; c < rows_; ++c) {
    const double* Y = &Y_[static_cast<std::size_t>(c) * model_.nv];
    for (int k = 0; k < matrix_rows_; ++k) p_[k] += mu_[c] * Y[k];
  }
  for (const TreeRings& r : rings_) {
    for (int i = 0; i < r.rings.rows(); ++i) rate_[r.row + i] = dot(r, i, p_.data());
  }
}

/// `force_` holds A p + r: what the joints and rings have to give.
void ImplicitJoints::readForces() noexcept {
  for (const TreeRings& r : rings_) {
    const int nv = model_.trees[r.tree].model->nv();
    for (int i = 0; i < r.rings.rows(); ++i) {
      for (int k = 0; k < nv; ++k) force_[r.first + k] -= r.G[i * nv + k] * mu_[r.row + i];
    }
  }
  for (std::size_t k = 0; k < law_place_.size(); ++k) law_force_[k] = force_[law_place_[k].row] / g_;
}

double ImplicitJoints::slope(const double* v, const double* p) const noexcept {
  double sum = 0;
  for (const JointLaws::Damped& d : laws_.damped()) sum += g_ * d.damping * v[d.v] * p[d.v];
  for (std::size_t k = 0; k < law_force_.size(); ++k) {
    const JointLaws::Law& law = laws_.laws()[k];
    const ForcePiece& piece = law.graph.pieces[law.graph.at(v[law.v])];
    const double force = piece.vertical ? std::min(std::max(law_force_[k], piece.low), piece.high)
                                        : piece.offset - piece.slope * v[law.v];
    sum -= g_ * force * p[law.v];
  }
  for (int r = 0; r < rows_; ++r) sum -= mu_[r] * rate_[r];
  return sum;
}

bool ImplicitJoints::isSmooth(const double* v0) const noexcept {
  for (const JointLaws::Law& law : laws_.laws()) {
    const ForcePiece& piece = law.now();
    const double start = v0[law.v];
    const bool stood = std::abs(start) * g_ <= kStanding;
    if (piece.vertical && !(stood && std::abs(piece.from) * g_ <= kStanding)) return false;
    if (piece.vertical || law.joint.friction == 0) continue;
    if (stood || (start > 0 ? piece.to <= 0 : piece.from >= 0)) return false;
  }
  return true;
}

void ImplicitJoints::account(const double* v_way, const double* v, double weight) noexcept {
  const auto outcome = [&](std::size_t k) -> JointLaws::Outcome {
    const JointLaws::Law& law = laws_.laws()[k];
    const double rate = v[law.v];
    return {v_way[law.v], rate, law.now().vertical ? law_force_[k] : law.now().offset - law.now().slope * rate};
  };
  laws_.account(commands_, weight, outcome, v_way, v, drive_.data(), work_);
}

void ImplicitJoints::closeAccount(State& state) const noexcept {
  state.energy.damping += work_.damping;
  state.energy.friction += work_.friction;
  state.energy.external += work_.drives;
}

double ImplicitJoints::closure(const LinkWork* work) const noexcept {
  double largest = 0;
  for (const TreeRings& r : rings_) {
    largest = std::max(largest, r.rings.closure(work + model_.trees[r.tree].link));
  }
  return largest;
}

}  // namespace haptic
