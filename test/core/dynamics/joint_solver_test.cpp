// One solver for all operators: the articulated-body recursion and a dense matrix give joints the same motion.
#include "haptic_core/dynamics/joint_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "four_bar.h"
#include "haptic_core/dynamics/joint_space_inertia.h"
#include "haptic_core/dynamics/tree_motion.h"
#include "random_tree.h"

namespace haptic::test {
namespace joint_solver_test {

const Vector3 kGravity(0, 0, -9.8);

/// M as a dense matrix behind two rows that belong to nobody; prescribed degrees are taken out of the system.
class DenseInertia final : public JointOperator {
 public:
  static constexpr int kBefore = 2;
  DenseInertia(const Articulation& tree, LinkWork* work, double h) : n_(tree.nv() + kBefore), h_(h) {
    Eigen::MatrixXd M(tree.nv(), tree.nv());
    massMatrix(tree, work, M.data());
    A_ = Eigen::MatrixXd::Identity(n_, n_);
    A_.bottomRightCorner(tree.nv(), tree.nv()) = M.selfadjointView<Eigen::Lower>();
    const std::vector<double> none(tree.nv(), 0);
    own_ = Eigen::VectorXd::Zero(n_);
    inverseDynamics(tree, kGravity, none.data(), work, own_.data() + kBefore);
    own_ *= -1;
  }
  int rows() const { return n_; }
  bool factor(const double* diag) noexcept override {
    diag_ = Eigen::Map<const Eigen::VectorXd>(diag, n_);
    return true;
  }
  void solve(const double* force, double* u) noexcept override {
    Eigen::Map<Eigen::VectorXd> x(u, n_);
    x = solved(h_ * (own_ + Eigen::Map<const Eigen::VectorXd>(force, n_)), x);
  }
  void respond(const double* force, double* x) noexcept override {
    Eigen::Map<Eigen::VectorXd>(x, n_) = solved(Eigen::Map<const Eigen::VectorXd>(force, n_), Eigen::VectorXd::Zero(n_));
  }
  double required(int, int row, const double* u) noexcept override {
    return A_.row(row).dot(Eigen::Map<const Eigen::VectorXd>(u, n_)) / h_ - own_[row];
  }

 private:
  Eigen::VectorXd solved(Eigen::VectorXd b, const Eigen::VectorXd& given) const {
    Eigen::MatrixXd A = A_;
    for (int i = 0; i < n_; ++i) {
      if (!std::isinf(diag_[i])) A(i, i) += diag_[i];
    }
    for (int i = 0; i < n_; ++i) {
      if (!std::isinf(diag_[i])) continue;
      b -= A.col(i) * given[i];
      A.col(i).setZero(), A.row(i).setZero();
      A(i, i) = 1;
      b[i] = given[i];
    }
    for (int i = 0; i < n_; ++i) b[i] = std::isinf(diag_[i]) ? given[i] : b[i];
    return A.ldlt().solve(b);
  }
  int n_;
  double h_;
  Eigen::MatrixXd A_;
  Eigen::VectorXd own_, diag_;
};

/// The same step over both operators; q and v are those of a tree that is nowhere near rest.
void expectSameMotion(const TreeDef& def, const std::vector<RingDef>& rings, const std::vector<double>& q,
                      const std::vector<double>& v, double h) {
  const Articulation tree(def);
  std::vector<LinkWork> work(tree.linkCount());
  std::vector<JointCommand> commands;
  for (const BodyDef& body : def.links) commands.push_back(initialCommand(body.joint));
  forwardKinematics(tree, q.data(), v.data(), work.data());
  DenseInertia dense(tree, work.data(), h);
  JointSolver solver;
  solver.add(tree, rings);
  solver.reserveRows(dense.rows());
  solver.select(dense.rows(), [](int degree) { return degree + DenseInertia::kBefore; });
  solver.start(commands.data(), q.data(), h);
  solver.standAt(v.data());
  solver.lookAtRings(work.data(), q.data(), 1, v.data());
  std::vector<double> u(dense.rows());
  ASSERT_EQ(solver.solve(dense, v.data(), u.data()), JointSolver::Found::kAll);

  TreeMotion motion(tree, rings);
  std::vector<double> v_dot(tree.nv());
  const JointReport report = motion.accelerate(kGravity, h, commands.data(), q.data(), v.data(), work.data(), v_dot.data());
  ASSERT_TRUE(report.converged);
  EXPECT_EQ(solver.passes(), report.passes);
  double largest = 0;
  for (int k = 0; k < tree.nv(); ++k) largest = std::max(largest, std::abs(h * v_dot[k]));
  // Rounding, times the condition of a tree of a dozen links.
  for (int k = 0; k < tree.nv(); ++k) EXPECT_NEAR(u[k + DenseInertia::kBefore], h * v_dot[k], 1e-9 * largest) << k;
}

TEST(JointSolver, MovesTreesAlikeOverARecursionAndOverAMatrix) {
  Random random(41);
  for (int trial = 0; trial < 200; ++trial) {
    TreeDef def = randomTree(random, 2 + trial % 12, trial % 2);
    for (BodyDef& body : def.links) {
      JointDef& joint = body.joint;
      joint.damping = random() % 2 ? uniform(random, 0, 3) : 0;
      if (joint.type != JointType::kRevolute && joint.type != JointType::kPrismatic) continue;
      if (random() % 2) joint.friction = uniform(random, 0, 5);
      if (random() % 3 == 0) joint.lower = uniform(random, -2, 0);
      if (random() % 3 == 0) joint.upper = uniform(random, 0, 2);
      joint.drive = static_cast<JointDef::Drive>(random() % 4);
      joint.drive_stiffness = uniform(random, 0, 1e4);
      joint.drive_damping = uniform(random, 0, 1e2);
      if (random() % 2) joint.max_effort = uniform(random, 0, 10);
    }
    const Articulation tree(def);
    std::vector<double> q(tree.nq()), v(tree.nv());
    randomState(random, tree, q, v);
    expectSameMotion(def, {}, q, v, 1e-3);
  }
}

TEST(JointSolver, ClosesRingsAlikeOverARecursionAndOverAMatrix) {
  TreeDef def = fourBar();
  for (BodyDef& body : def.links) body.joint.friction = 1e-3, body.joint.damping = 1e-3;
  expectSameMotion(def, fourBarRing(), {0.8, -0.8, 0.8}, {1, -1, 1}, 1e-3);
  expectSameMotion(def, fourBarRing(), {0.8, -0.81, 0.79}, {1, -1, 0.5}, 1e-4);  // a gap, and one that grows
}

}  // namespace joint_solver_test
}  // namespace haptic::test
