#include "haptic_core/analysis/linearisation.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/dense_matrix.h"
#include "haptic_core/dynamics/joint_space_inertia.h"

namespace haptic {
namespace {

constexpr double kDifference = 1e-3;   ///< finite differences: share of the least depth
constexpr double kAside = 30;          ///< differences: how many steps aside of the rest state, 3 % of the depth

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

}  // namespace

Linearisation::Linearisation(const World& world, const std::function<bool()>& goOn)
    : model_(world.model()),
      state_(world.state()),
      pairs_(state_.pairs),
      seams_(model_),
      held_by_(model_.links.size(), -1),
      work_(model_.links.size()),
      X_WS_(model_.shapes.size()),
      shapes_of_(model_.trees.size()),
      pairs_of_(model_.trees.size()) {
  model_.reserve(workspace_);
  // A hand at rest holds its link, whatever its coupling.
  for (std::size_t i = 0; i < state_.pointers.size(); ++i) held_by_[state_.pointers[i].link] = static_cast<int>(i);
  for (const ModelMotion& motion : model_.motions) held_by_[motion.link] = static_cast<int>(state_.pointers.size());
  gravity_ = world.settings().gravity;
  for (const ModelTree& tree : model_.trees) moves_.push_back(!tree.model->isStatic() && held_by_[tree.link] < 0);
  for (std::size_t s = 0; s < model_.shapes.size(); ++s) shapes_of_[treeOf(static_cast<int>(s))].push_back(static_cast<int>(s));
  state_.pairs.each([this](int i) {
    const int a = treeOf(state_.pairs[i].shapeA()), b = treeOf(state_.pairs[i].shapeB());
    pairs_of_[a].push_back(i);
    if (b != a) pairs_of_[b].push_back(i);
  });
  linearise(goOn);
}

void Linearisation::place(int t, const double* q) {
  const ModelTree& tree = model_.trees[t];
  const std::vector<double> rest(static_cast<std::size_t>(tree.model->nv()), 0.0);
  forwardKinematics(*tree.model, q, rest.data(), work_.data() + tree.link);
  for (const int s : shapes_of_[t]) X_WS_[s] = work_[model_.shapes[s].link].X_WL * model_.shapes[s].X_LS;
}

void Linearisation::placeAll(const std::vector<double>& q) {
  for (std::size_t t = 0; t < model_.trees.size(); ++t) place(static_cast<int>(t), q.data() + model_.trees[t].q);
}

/// Calls `visit` with every pair that touches of those in `which`, its contact at rest, without friction's memory. The pairs of one body
/// with another are all in it, or none.
template <class Visit>
void Linearisation::eachContact(const std::vector<int>& which, Visit&& visit) {
  for (const int i : which) pairs_[i] = state_.pairs[i];
  if (seams_.any()) seams_.find(pairs_.data(), which, X_WS_.data(), workspace_);
  const ContactPlaces places{work_.data(), X_WS_.data(), held_by_.data()};
  ContactEvaluation contact;
  for (const int i : which) {
    if (!locateContact(model_, seams_, i, pairs_[i], places, workspace_, contact)) continue;
    contact.V_AB_P = Twist{};  // belts stand as well: their friction does not depend on poses
    contact.force = locatedForce(contact.volume, contact.X_AB, workspace_, contact.V_AB_P, FrictionMemory{}, contact.law, Advance{});
    visit(pairs_[i], contact);
  }
}

void Linearisation::addForces(int t, double factor, std::vector<Block>& on) {
  const auto push = [&](int link, const Wrench& F_W, const Vector3& p) {
    const int other = model_.links[link].articulation;
    const ModelTree& tree = model_.trees[other];
    for (Block& block : on) {
      if (block.tree != other || block.K.size() == 0) continue;
      Vector f = Vector::Zero(block.K.rows());
      addGeneralisedForce(*tree.model, work_.data() + tree.link, model_.links[link].local, F_W, p, f.data());
      block.K.col(0) += factor * f;
    }
  };
  eachContact(pairs_of_[t], [&](const ActivePair& pair, const ContactEvaluation& contact) {
    const Wrench F_BP_W = contact.force.F_BP_P.rotated(contact.X_WP.R);
    push(model_.shapes[pair.shapeB()].link, F_BP_W, contact.X_WP.p);
    push(model_.shapes[pair.shapeA()].link, -F_BP_W, contact.X_WP.p);
  });
  const ModelTree& tree = model_.trees[t];
  for (int l = tree.link; l < tree.link + tree.model->linkCount(); ++l) {
    Wrench weight;
    weight.force = model_.links[l].mass * gravity_;
    push(l, weight, work_[l].p_WC());
  }
}

Eigen::MatrixXd Linearisation::stiffness(const std::vector<int>& trees, const std::vector<int>& first, Eigen::Index rows) const {
  Matrix K = Matrix::Zero(rows, rows);
  for (const int t : trees) {
    for (const Block& block : K_[t]) {
      if (block.K.size() > 0) K.block(first[block.tree], first[t], block.K.rows(), block.K.cols()) = block.K;
    }
  }
  return 0.5 * (K + K.transpose());
}

void Linearisation::linearise(const std::function<bool()>& goOn) {
  placeAll(state_.q);
  for (std::size_t t = 0; t < model_.trees.size(); ++t) {
    const ModelTree& tree = model_.trees[t];
    const int n = tree.model->nv();
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> block(n, n);
    if (n > 0) massMatrix(*tree.model, work_.data() + tree.link, block.data());
    M.push_back(block);
  }
  std::vector<int> all;
  state_.pairs.each([&all](int i) { all.push_back(i); });
  double least_depth = 1e300;
  eachContact(all, [&](const ActivePair& pair, const ContactEvaluation& contact) {
    addContact(pair, contact);
    least_depth = std::min(least_depth, contact.volume.volume / contact.volume.A0);
  });
  K_.resize(model_.trees.size());
  contacts_of.resize(model_.trees.size());
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    contacts[c].eachTree([&](int t, const Matrix&) { contacts_of[t].push_back(static_cast<int>(c)); });
  }
  if (contacts.empty()) return;
  shareMobility();
  addDifferences(kDifference * least_depth, goOn);
  for (const Contact& c : contacts) {
    Matrix6 springs = Matrix6::Zero();  // friction: the normal part comes from the differences
    springs.block<3, 3>(2, 2) = c.stiffness.block<3, 3>(2, 2);
    c.eachTree([&](int column, const Matrix& J) {
      const Matrix pull = springs.lazyProduct(J);
      c.eachTree([&](int row, const Matrix& J_row) { blockOf(column, row).K += J_row.transpose().lazyProduct(pull); });
    });
  }
}

Linearisation::Block& Linearisation::blockOf(int column, int row) {
  std::vector<Block>& blocks = K_[column];
  return *std::find_if(blocks.begin(), blocks.end(), [row](const Block& block) { return block.tree == row; });
}

void Linearisation::shareMobility() {
  std::vector<int> count(model_.trees.size(), 0);
  for (const Contact& c : contacts) {
    ++count[c.tree_a];
    ++count[c.tree_b];
  }
  for (Contact& c : contacts) {
    c.parts = std::max(moves_[c.tree_a] ? count[c.tree_a] : 1, moves_[c.tree_b] ? count[c.tree_b] : 1);
    c.eachTree([&](int t, const Matrix& J) { c.mobility += count[t] * Matrix6(J.lazyProduct(solveSymmetric(M[t], J.transpose()))); });
  }
}

void Linearisation::addContact(const ActivePair& pair, const ContactEvaluation& contact) {
  Contact c;
  c.a = model_.shapes[pair.shapeA()].link;
  c.b = model_.shapes[pair.shapeB()].link;
  c.tree_a = model_.links[c.a].articulation;
  c.tree_b = model_.links[c.b].articulation;
  c.volume = contact.volume;
  c.law = contact.law;
  c.stiffness = contact.force.tangent.combined(1, 0);
  c.damping = contact.force.tangent.combined(0, 1);
  c.J_b = Matrix::Zero(6, degrees(c.tree_b));
  c.J_a = Matrix::Zero(6, c.tree_a == c.tree_b ? 0 : degrees(c.tree_a));
  addJacobian(c.b, contact.X_WP, 1, c.J_b);
  addJacobian(c.a, contact.X_WP, -1, c.tree_a == c.tree_b ? c.J_b : c.J_a);
  contacts.push_back(c);
}

void Linearisation::addJacobian(int link, const Pose& X_WP, double sign, Matrix& J) {
  const ModelTree& tree = model_.trees[model_.links[link].articulation];
  for (Eigen::Index i = 0; i < J.cols(); ++i) {
    Vector unit = Vector::Zero(tree.model->nv());
    unit[i] = 1;
    const Twist V = pointTwist(*tree.model, work_.data() + tree.link, model_.links[link].local, X_WP.p, unit.data());
    J.col(i) += sign * V.rotated(X_WP.R.transpose()).vector();
  }
}

void Linearisation::addDifferences(double epsilon, const std::function<bool()>& goOn) {
  std::vector<double> beside = state_.q;
  for (std::size_t t = 0; t < model_.trees.size(); ++t) {
    const ModelTree& tree = model_.trees[t];
    Vector aside(tree.model->nv());
    for (int i = 0; i < tree.model->nv(); ++i) {
      const double golden = 0.6180339887 * (tree.v + i + 1);  // neighbours differ by 0.29 at least
      const bool turns = tree.model->isFreeBody() && i < 3;   // a turn would shift faces back over one another
      aside[i] = turns ? 0 : kAside * (golden - std::floor(golden)) / reach(tree, i);
    }
    if (moves_[t]) integratePositions(*tree.model, beside.data() + tree.q, aside.data(), epsilon);
  }
  placeAll(beside);
  for (int t = 0; t < static_cast<int>(model_.trees.size()); ++t) {
    if (!moves_[t]) continue;
    if (goOn && !goOn()) throw Stopped{};
    differ(t, epsilon, beside.data() + model_.trees[t].q);
  }
  placeAll(state_.q);
}

void Linearisation::differ(int t, double epsilon, const double* beside) {
  const ModelTree& tree = model_.trees[t];
  std::vector<int> others{t};
  for (const int c : contacts_of[t]) {
    contacts[c].eachTree([&](int other, const Matrix&) {
      if (std::find(others.begin(), others.end(), other) == others.end()) others.push_back(other);
    });
  }
  std::vector<Block> change;  // a column each
  for (const int other : others) {
    K_[t].push_back({other, Matrix::Zero(degrees(other), degrees(t))});
    change.push_back({other, Matrix::Zero(degrees(other), 1)});
  }
  Vector direction = Vector::Zero(tree.model->nv());
  std::vector<double> q(static_cast<std::size_t>(tree.model->nq()));
  for (int i = 0; i < tree.model->nv(); ++i) {
    const double step = epsilon / reach(tree, i);
    for (Block& block : change) block.K.setZero();
    for (double sign : {1.0, -1.0}) {
      direction[i] = sign;
      std::copy_n(beside, q.size(), q.begin());
      integratePositions(*tree.model, q.data(), direction.data(), step);
      place(t, q.data());
      addForces(t, sign, change);
    }
    direction[i] = 0;
    for (std::size_t b = 0; b < change.size(); ++b) K_[t][b].K.col(i) = -change[b].K / (2 * step);
  }
  place(t, beside);
}

double Linearisation::reach(const ModelTree& tree, int degree) const {
  return !tree.model->isFreeBody() || degree < 3 ? model_.links[tree.link].size : 1;
}

}  // namespace haptic
