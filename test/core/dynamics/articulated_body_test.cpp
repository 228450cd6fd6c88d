// Forward dynamics against an independent route: composite inertia, inverse dynamics, dense solve.
#include "haptic_core/dynamics/articulated_body.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "haptic_core/base/error.h"
#include "haptic_core/dynamics/joint_space_inertia.h"
#include "random_tree.h"

namespace haptic::test {
namespace articulated_body_test {

using Dense = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
const Vector3 kGravity(0.3, -0.2, -9.8);

struct Case {
  explicit Case(const TreeDef& def) : tree(def), work(tree.linkCount()), vdot(tree.nv()), tau(tree.nv()) {}
  void move(Random& random) {
    randomState(random, tree, q, v);
    forwardKinematics(tree, q.data(), v.data(), work.data());
    for (LinkWork& w : work)
      w.addWrench({randomVector(random), randomVector(random)}, w.p_WO + randomVector(random));
    for (double& t : tau) t = uniform(random);
  }
  Eigen::VectorXd oracle(const Eigen::VectorXd& diag) {
    Dense M(tree.nv(), tree.nv());
    massMatrix(tree, work.data(), M.data());
    M.diagonal() += diag;
    Eigen::VectorXd c(tree.nv());
    inverseDynamics(tree, kGravity, nullptr, work.data(), c.data());
    return M.ldlt().solve(Eigen::Map<Eigen::VectorXd>(tau.data(), tree.nv()) - c);
  }
  Articulation tree;
  std::vector<LinkWork> work;
  std::vector<double> q, v, vdot, tau;
};

TEST(ArticulatedBody, AgreesWithCompositeInertiaAndDenseSolve) {
  Random random(1);
  double worst = 0;
  for (int trial = 0; trial < 300; ++trial) {
    Case c(randomTree(random, 1 + trial % 60, trial % 2));
    c.move(random);
    Eigen::VectorXd diag(c.tree.nv());
    for (int i = 0; i < diag.size(); ++i) diag[i] = trial % 3 ? 0 : uniform(random, 0, 0.1);
    accelerations(c.tree, kGravity, c.tau.data(), diag.data(), c.work.data(), c.vdot.data());
    const Eigen::VectorXd expected = c.oracle(diag);
    const Eigen::Map<Eigen::VectorXd> vdot(c.vdot.data(), c.tree.nv());
    // Both routes lose what the condition of M costs (1e3 to 1e7 here), times a few roundings.
    Dense M(c.tree.nv(), c.tree.nv());
    massMatrix(c.tree, c.work.data(), M.data());
    const Eigen::VectorXd moments =
        Eigen::SelfAdjointEigenSolver<Dense>(M, Eigen::EigenvaluesOnly).eigenvalues();
    const double condition = moments[moments.size() - 1] / moments[0];
    worst = std::max(worst, (vdot - expected).norm() / expected.norm() / condition);
  }
  EXPECT_LT(worst, 10 * std::numeric_limits<double>::epsilon());
}

TEST(ArticulatedBody, JointMobilitiesAreTheDiagonalOfTheInverse) {
  Random random(8);
  for (int trial = 0; trial < 200; ++trial) {
    Case c(randomTree(random, 2 + trial % 40, trial % 2));
    c.move(random);
    const int nv = c.tree.nv();
    std::vector<double> diag(nv), mobility(nv), scratch(36 * c.tree.linkCount());
    for (double& d : diag) d = trial % 3 ? 0 : uniform(random, 0, 0.1);
    accelerations(c.tree, kGravity, c.tau.data(), diag.data(), c.work.data(), c.vdot.data());
    jointMobilities(c.tree, c.work.data(), scratch.data(), mobility.data());
    Dense M(nv, nv);
    massMatrix(c.tree, c.work.data(), M.data());
    M.diagonal() += Eigen::Map<const Eigen::VectorXd>(diag.data(), nv);
    const Eigen::SelfAdjointEigenSolver<Dense> modes(M);
    const Eigen::VectorXd expected = modes.eigenvectors().cwiseAbs2() * modes.eigenvalues().cwiseInverse();
    const double condition = modes.eigenvalues()[nv - 1] / modes.eigenvalues()[0];
    const double rounding = 10 * condition * std::numeric_limits<double>::epsilon();
    for (int k = 0; k < nv; ++k) EXPECT_NEAR(mobility[k], expected[k], rounding * expected.maxCoeff()) << trial << " " << k;
  }
}

TEST(ArticulatedBody, PrescribedJointsMoveAsTold) {
  Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    Case c(randomTree(random, 2 + trial % 20, trial % 2));
    c.move(random);
    std::vector<double> diag(c.tree.nv(), 0);
    for (int i = 0; i < c.tree.linkCount(); ++i)
      if (random() % 3 == 0)
        for (int k = 0; k < c.tree.link(i).dof; ++k)
          diag[c.tree.link(i).v + k] = std::numeric_limits<double>::infinity();
    for (double& a : c.vdot) a = uniform(random);
    const std::vector<double> told = c.vdot;
    for (int repeat = 0; repeat < 2; ++repeat)
      accelerations(c.tree, kGravity, c.tau.data(), diag.data(), c.work.data(), c.vdot.data());
    std::vector<double> tau(c.tree.nv());
    // The joints that were told pass what their joint wrench says, the others what was applied.
    std::vector<double> held(c.tree.nv());
    for (int i = 0; i < c.tree.linkCount(); ++i) {
      const LinkModel& link = c.tree.link(i);
      const Wrench F = jointWrench(c.tree, c.work.data(), i, kGravity);
      std::vector<double> g(c.tree.nv(), 0);
      addGeneralisedForce(c.tree, c.work.data(), i, F, c.work[i].p_WO, g.data());
      for (int k = 0; k < link.dof; ++k) held[link.v + k] = g[link.v + k];
    }
    inverseDynamics(c.tree, kGravity, c.vdot.data(), c.work.data(), tau.data());
    for (int i = 0; i < c.tree.nv(); ++i) {
      if (std::isinf(diag[i])) {
        EXPECT_EQ(c.vdot[i], told[i]);
        if (!c.tree.isFreeBody()) EXPECT_NEAR(tau[i], held[i], 1e-9 * (1 + std::abs(tau[i])));
      } else {
        EXPECT_NEAR(tau[i], c.tau[i], 1e-9 * (1 + std::abs(tau[i])));
      }
    }
  }
}

TEST(ArticulatedBody, FreeBodyShortWayAgreesWithTheTree) {
  Random random(3);
  TreeDef def = randomTree(random, 1, true);
  Case alone(def);
  alone.move(random);
  BodyDef stone;  // a second root makes it a tree
  stone.name = "stone";
  stone.joint.type = JointType::kFixed;
  def.links.push_back(stone);
  Case tree(def);
  forwardKinematics(tree.tree, alone.q.data(), alone.v.data(), tree.work.data());
  tree.work[0].F_ext = alone.work[0].F_ext;
  accelerations(alone.tree, kGravity, nullptr, nullptr, alone.work.data(), alone.vdot.data());
  accelerations(tree.tree, kGravity, nullptr, nullptr, tree.work.data(), tree.vdot.data());
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(alone.vdot[i], tree.vdot[i], 1e-11 * (1 + std::abs(alone.vdot[i])));
}

TEST(JointSpaceInertia, GivesTheKineticEnergy) {
  Random random(4);
  for (int trial = 0; trial < 40; ++trial) {
    Case c(randomTree(random, 1 + trial, trial % 2));
    c.move(random);
    const int nv = c.tree.nv();
    Dense M(nv, nv);
    massMatrix(c.tree, c.work.data(), M.data());
    const Eigen::Map<Eigen::VectorXd> v(c.v.data(), nv);
    const double energy = kineticEnergy(c.tree, c.work.data());
    EXPECT_NEAR(0.5 * v.dot(M * v), energy, 1e-11 * energy);
  }
}

TEST(Kinematics, JacobianProductsAreTheTwistsOfFiniteSteps) {
  Random random(5);
  for (int trial = 0; trial < 20; ++trial) {
    Case c(randomTree(random, 1 + trial, trial % 2));
    c.move(random);
    const int link = c.tree.linkCount() - 1, nv = c.tree.nv();
    const Vector3 p = c.work[link].p_WO + randomVector(random, 0.2);
    const Twist V = pointTwist(c.tree, c.work.data(), link, p, c.v.data());
    const Twist direct = c.work[link].twistAt(p);
    EXPECT_LT((V.vector() - direct.vector()).norm(), 1e-12 * (1 + V.vector().norm()));
    Dense J = Dense::Zero(6, nv);
    pointJacobian(c.tree, c.work.data(), link, p, J.data(), nv);
    EXPECT_LT((J * Eigen::Map<Eigen::VectorXd>(c.v.data(), nv) - V.vector()).norm(),
              1e-12 * (1 + V.vector().norm()));
    const Wrench F{randomVector(random), randomVector(random)};
    Eigen::VectorXd g = Eigen::VectorXd::Zero(nv);
    addGeneralisedForce(c.tree, c.work.data(), link, F, p, g.data());
    EXPECT_LT((g - J.transpose() * F.vector()).norm(), 1e-12 * (1 + g.norm()));
    // Central difference of the link's pose along the motion: error h²/6 times third derivatives below 1e4.
    const double h = 1e-5;
    Pose X[2];
    for (int side = 0; side < 2; ++side) {
      std::vector<double> q = c.q;
      std::vector<LinkWork> work(c.tree.linkCount());
      integratePositions(c.tree, q.data(), c.v.data(), side ? h : -h);
      forwardKinematics(c.tree, q.data(), c.v.data(), work.data());
      X[side] = work[link].X_WL;
    }
    const Vector3 velocity = (X[1].p - X[0].p) / (2 * h);
    EXPECT_LT((velocity - c.work[link].twistAtOrigin().linear).norm(), 1e-5);
    const Vector3 turned = vectorFromRotation(Quaternion(X[1].R * X[0].R.transpose())) / (2 * h);
    EXPECT_LT((turned - c.work[link].omega).norm(), 1e-5);
  }
}

TEST(Articulation, RefusesWhatIsNotABody) {
  Random random(6);
  const auto refused = [](const TreeDef& def) {
    try {
      Articulation tree(def);
    } catch (const SetupError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  TreeDef good = randomTree(random, 5, true);
  EXPECT_EQ(refused(good), "");
  TreeDef bad = good;
  bad.links[3].parent = 4;
  EXPECT_NE(refused(bad).find("link3"), std::string::npos);
  bad = good;
  bad.links[2].joint.type = JointType::kRevolute;
  bad.links[2].joint.axis = Vector3(0, 0, 0);
  EXPECT_NE(refused(bad).find("joint2"), std::string::npos);
  bad = good;
  bad.links[1].inertia.I_C = Vector3(1, 1, -0.5).asDiagonal();
  EXPECT_NE(refused(bad).find("link1"), std::string::npos);
  bad = good;
  bad.links[0].inertia.mass = std::nan("");
  EXPECT_NE(refused(bad).find("link0"), std::string::npos);
  bad = good;
  bad.links[4].joint.lower = 1;
  bad.links[4].joint.upper = -1;
  EXPECT_NE(refused(bad).find("joint4"), std::string::npos);
}

}  // namespace articulated_body_test
}  // namespace haptic::test
