// Motion without contact: convergence order, conservation, exact free rotation.
#include "haptic_core/dynamics/runge_kutta.h"

#include <gtest/gtest.h>

#include <cmath>

#include "haptic_core/dynamics/free_momentum.h"
#include "chain.h"
#include "free_rotation_reference.h"
#include "haptic_core/dynamics/free_body.h"
#include "random_tree.h"

namespace haptic::test {
namespace runge_kutta_test {

struct Motion {
  explicit Motion(const TreeDef& def)
      : tree(def), work(tree.linkCount()), q(tree.nq()), v(tree.nv()), scratch(rungeKuttaScratch(tree)) {
    tree.initialState(q.data(), v.data());
  }
  void run(double seconds, double h, const Vector3& gravity) {
    const int steps = static_cast<int>(std::lround(seconds / h));
    for (int i = 0; i < steps; ++i) {
      if (tree.isFreeBody()) {
        stepFreeBody(tree.link(0), gravity, h, q.data(), v.data());
      } else {
        stepRungeKutta(tree, gravity, h, q.data(), v.data(), work.data(), scratch.data());
      }
    }
    forwardKinematics(tree, q.data(), v.data(), work.data());
  }
  double energy(const Vector3& gravity) {
    forwardKinematics(tree, q.data(), v.data(), work.data());
    return kineticEnergy(tree, work.data()) + potentialEnergy(tree, work.data(), gravity);
  }
  Articulation tree;
  std::vector<LinkWork> work;
  std::vector<double> q, v, scratch;
};

TreeDef freeBody(const Vector3& moments) {
  TreeDef def;
  BodyDef body;
  body.name = "body";
  body.joint.type = JointType::kFloating;
  body.inertia.mass = 1;
  body.inertia.p_LC = Vector3(0.1, -0.2, 0.05);
  body.inertia.I_C = moments.asDiagonal();
  def.links = {body};
  return def;
}

TEST(RungeKutta, TreesOfEveryJointConvergeWithFourthOrder) {
  const Vector3 gravity(0, 0, -9.8);
  Random random(11);
  for (int trial = 0; trial < 4; ++trial) {
    const TreeDef def = randomTree(random, 8, trial % 2);
    Motion start(def);
    randomState(random, start.tree, start.q, start.v);
    double error[2];
    Motion reference = start;
    reference.run(0.064, 0.25e-3, gravity);
    for (int level = 0; level < 2; ++level) {
      Motion motion = start;
      motion.run(0.064, level ? 4e-3 : 8e-3, gravity);
      const Eigen::Map<Eigen::VectorXd> v(motion.v.data(), motion.tree.nv());
      error[level] = (v - Eigen::Map<Eigen::VectorXd>(reference.v.data(), reference.tree.nv())).norm();
    }
    EXPECT_GT(std::log2(error[0] / error[1]), 3.5) << error[0] << " " << error[1];
  }
}

TEST(RungeKutta, ChainKeepsItsEnergy) {
  const Vector3 gravity(0, 0, -9.8);
  Motion motion(chain(10));
  const double start = motion.energy(gravity), scale = kChainMass * 9.8 * kChainLength * 100 / 2;
  for (int i = 0; i < 10; ++i) {
    motion.run(0.5, 1e-3, gravity);
    EXPECT_LT(std::abs(motion.energy(gravity) - start) / scale, 5e-6);
  }
}

TEST(RungeKutta, FloatingChainKeepsItsMomentum) {
  Motion motion(chain(10, true));
  Random random(12);
  for (double& v : motion.v) v = uniform(random, -3, 3);
  forwardKinematics(motion.tree, motion.q.data(), motion.v.data(), motion.work.data());
  const Wrench start = momentum(motion.tree, motion.work.data(), Vector3::Zero());
  motion.run(2, 1e-3, Vector3::Zero());
  const Wrench end = momentum(motion.tree, motion.work.data(), Vector3::Zero());
  // Momentum is not a state here, so the truncation error of the step shows: about 1e-12 of it.
  EXPECT_LT((end.torque - start.torque).norm() / start.torque.norm(), 1e-10);
  EXPECT_LT((end.force - start.force).norm() / start.force.norm(), 1e-10);
}

TEST(FreeBody, FlipsLikeTheReference) {
  // The unstable axis; one flip in 10 s.
  Motion motion(freeBody({1, 2, 2.5}));
  motion.v = {0.01, 5, 0.01, 0, 0, 0};
  const double start = motion.energy(Vector3::Zero());
  motion.run(10, 1e-3, Vector3::Zero());
  const Quaternion r(motion.q[3], motion.q[4], motion.q[5], motion.q[6]);
  const Quaternion expected = freeRotation({1, 2, 2.5}, {0.01, 5, 0.01}, 10);
  EXPECT_LT(vectorFromRotation(r.conjugate() * expected).norm(), 1e-8);
  EXPECT_LT(std::abs(motion.energy(Vector3::Zero()) / start - 1), 1e-11);
}

TEST(FreeBody, SpinsLikeTheTree) {
  TreeDef def = freeBody({1, 2, 2.5});
  def.links[0].inertia.I_C(0, 1) = def.links[0].inertia.I_C(1, 0) = 0.3;
  TreeDef tree = def;
  BodyDef stone;  // a second root: the general way
  stone.joint.type = JointType::kFixed;
  tree.links.push_back(stone);
  Motion fast(def), general(tree);
  for (Motion* m : {&fast, &general}) {
    m->v = {1, -2, 3, 0, 0, 0};
    m->run(1, 1e-3, {0, 0, -9.8});
  }
  // Merson's fourth order: (ω h)^4 · ω t = 2e-10 · 3.7, over 120 at least.
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(fast.v[k], general.v[k], 1e-10);
  for (int k = 0; k < 7; ++k) EXPECT_NEAR(fast.q[k], general.q[k], 1e-10);
}

/// Wobbles so small that their terms are rounding of a turn, and larger ones, are as near the reference: rounding of 100 steps.
TEST(FreeBody, EndsItsSeriesWhereThatIsRounding) {
  for (double wobble = 1e-18; wobble < 1e-6; wobble *= 10) {
    Motion motion(freeBody({1, 2, 2.5}));
    motion.v = {wobble, 0.5, wobble, 0, 0, 0};
    motion.run(0.1, 1e-3, Vector3::Zero());
    const Quaternion r(motion.q[3], motion.q[4], motion.q[5], motion.q[6]);
    const Quaternion expected = freeRotation({1, 2, 2.5}, {wobble, 0.5, wobble}, 0.1);
    EXPECT_LT(vectorFromRotation(r.conjugate() * expected).norm(), 100 * 2e-16) << wobble;
  }
}

TEST(FreeBody, TakesFastSpinsInParts) {
  Motion fast(freeBody({1, 2, 2.5})), fine = fast;
  for (Motion* m : {&fast, &fine}) m->v = {40, 90, -60, 0, 0, 0};
  fast.run(0.02, 1e-2, Vector3::Zero());  // 1.1 rad a step
  fine.run(0.02, 1e-4, Vector3::Zero());
  // The part's bound of 0.3 rad: 0.3⁵/100 per radian turned, 2 rad.
  for (int k = 3; k < 7; ++k) EXPECT_NEAR(fast.q[k], fine.q[k], 1e-4);
}

TEST(FreeBody, SpinsAboutAPrincipalAxisAndFallsExactly) {
  const Vector3 gravity(0, 0, -9.8);
  Motion motion(freeBody({1, 2, 2.5}));
  const Vector3 p0(motion.q[0], motion.q[1], motion.q[2]);
  motion.v = {0, 0, 3, 1, 0, 2};
  motion.run(1, 1e-3, gravity);
  const Quaternion r(motion.q[3], motion.q[4], motion.q[5], motion.q[6]);
  // No term of the expansion is left out on a fixed axis; rounding 1000 eps.
  EXPECT_LT((vectorFromRotation(r) - Vector3(0, 0, 3)).norm(), 1e-12);
  const Vector3 p(motion.q[0], motion.q[1], motion.q[2]);
  EXPECT_LT((p - (p0 + Vector3(1, 0, 2) + 0.5 * gravity)).norm(), 1e-12);
}

TEST(RungeKutta, FloatingTreesKeepTheirMomentumUnderGravity) {
  Random random(71);
  const Vector3 gravity(0.3, 0.1, -9.8);
  for (int trial = 0; trial < 10; ++trial) {
    const Articulation tree(randomTree(random, 2 + trial, true));
    std::vector<double> q, v, scratch(rungeKuttaScratch(tree));
    std::vector<LinkWork> work(tree.linkCount());
    randomState(random, tree, q, v);
    forwardKinematics(tree, q.data(), v.data(), work.data());
    const FreeMomentum start = freeMomentum(tree, work.data(), 0);
    const double h = 1e-3;
    for (int i = 0; i < 500; ++i) stepRungeKutta(tree, gravity, h, q.data(), v.data(), work.data(), scratch.data());
    forwardKinematics(tree, q.data(), v.data(), work.data());
    const FreeMomentum end = freeMomentum(tree, work.data(), 0);
    const double t = 500 * h, P = start.H_C.force.norm() + t * start.mass * gravity.norm();
    EXPECT_LT((end.H_C.force - start.H_C.force - t * start.mass * gravity).norm(), 1e-12 * P);
    EXPECT_LT((end.H_C.torque - start.H_C.torque).norm(), 1e-11 * start.H_C.torque.norm());
    const Vector3 fall = start.p_WC + t / start.mass * start.H_C.force + 0.5 * t * t * gravity;
    EXPECT_LT((end.p_WC - fall).norm(), 1e-11 * (1 + fall.norm()));
  }
}

}  // namespace runge_kutta_test
}  // namespace haptic::test
