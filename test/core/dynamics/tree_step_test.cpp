// The steps that a world takes of one articulation: the short way of a free body against the general one, order.
#include "haptic_core/dynamics/tree_step.h"

#include <gtest/gtest.h>

#include <cmath>

#include "chain.h"
#include "random_tree.h"

namespace haptic::test {
namespace tree_step_test {

const Vector3 kGravity(0.3, -0.2, -9.8);

/// A tree whose link 0 hangs on a spring and a damper from an anchor above it.
struct Sprung {
  explicit Sprung(const TreeDef& def)
      : tree(def), q(tree.nq()), v(tree.nv()), pull(tree.nv()), half(tree.nv()), work(tree.linkCount()) {
    tree.initialState(q.data(), v.data());
    scratch.fit(tree);
  }
  SteppedTree view() { return {&tree, nullptr, nullptr, q.data(), v.data(), pull.data(), half.data(), work.data()}; }
  void evaluate() {
    forwardKinematics(tree, q.data(), v.data(), work.data());
    const Vector3 p_WS = work[0].X_WL * Vector3(0.05, 0.03, -0.02), v_WS = work[0].twistAt(p_WS).linear;
    work[0].addWrench({Vector3::Zero(), 40 * (Vector3(0.1, 0.2, 0.3) - p_WS) - damping * v_WS}, p_WS);
  }
  void verlet(double seconds, double h) {
    evaluate();
    readPull(view(), gravity, scratch);
    for (long i = std::lround(seconds / h); i > 0; --i) {
      startVerlet(view(), gravity, h, scratch);
      evaluate();
      finishVerlet(view(), gravity, h, scratch);
    }
  }
  Vector3 gravity = kGravity;
  double damping = 0.3;  ///< of the spring's end [N·s/m]
  Articulation tree;
  std::vector<double> q, v, pull, half;
  std::vector<LinkWork> work;
  TreeStepScratch scratch;
};

/// One body in free flight; `general`: with a fixed stone beside it, so that no short way is taken.
TreeDef body(bool general) {
  Random random(5);
  TreeDef def = randomTree(random, 1, true);
  def.V_WA = {Vector3(1, -2, 3), Vector3(0.5, 0.1, -0.2)};
  if (general) {
    BodyDef stone;
    stone.joint.type = JointType::kFixed;
    def.links.push_back(stone);
  }
  return def;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

TEST(TreeStep, AFreeBodysShortWayEqualsTheGeneralOne) {
  Sprung fast(body(false)), general(body(true));
  ASSERT_TRUE(fast.tree.isFreeBody());
  ASSERT_FALSE(general.tree.isFreeBody());
  // A free body feels gravity in its kicks, a tree in its drift, and they predict v in different ways, both within the
  // scheme's order; without the two the drifts alone differ, by the general one's fourth order: (ω h)⁵/120 a step of
  // 0.25 ms at 30 rad/s is 4e-10 rad in 2000 steps, and ω times that in v.
  for (Sprung* s : {&fast, &general}) {
    s->gravity.setZero();
    s->damping = 0;
  }
  for (Sprung* s : {&fast, &general}) s->verlet(0.5, 0.25e-3);
  EXPECT_LT(distance(fast.v, general.v), 1e-7);
  EXPECT_LT(distance(fast.q, general.q), 1e-8);
}

TEST(TreeStep, VerletIsOfSecondOrder) {
  for (const TreeDef& def : {body(false), chain(4), chain(4, true)}) {
    Sprung reference(def);
    reference.verlet(0.128, 0.0625e-3);
    double error[2];
    for (int level = 0; level < 2; ++level) {
      Sprung s(def);
      s.verlet(0.128, level ? 1e-3 : 2e-3);
      error[level] = distance(s.q, reference.q);
    }
    EXPECT_NEAR(std::log2(error[0] / error[1]), 2, 0.25) << def.name << " " << error[1];
  }
}

TEST(TreeStep, StartVerletLeavesTheKinematicsOfWhereItEnds) {
  for (const TreeDef& def : {body(false), body(true), chain(4, true)}) {
    Sprung s(def);
    s.evaluate();
    readPull(s.view(), kGravity, s.scratch);
    startVerlet(s.view(), kGravity, 1e-3, s.scratch);
    const std::vector<LinkWork> left = s.work;
    forwardKinematics(s.tree, s.q.data(), s.v.data(), s.work.data());
    for (int i = 0; i < s.tree.linkCount(); ++i) {
      EXPECT_EQ(left[i].X_WL.R, s.work[i].X_WL.R) << def.name;
      EXPECT_EQ(left[i].X_WL.p, s.work[i].X_WL.p) << def.name;
      EXPECT_EQ(left[i].p_WO, s.work[i].p_WO) << def.name;
      EXPECT_EQ(left[i].omega, s.work[i].omega) << def.name;
      EXPECT_EQ(left[i].velocity, s.work[i].velocity) << def.name;
      EXPECT_EQ(left[i].F_ext.vector(), Vector6::Zero()) << def.name;
    }
  }
}

TEST(TreeStep, JointsWithLawsReportWhatTheyDid) {
  TreeDef def = chain(3);
  for (BodyDef& link : def.links) link.joint.damping = 1e-3;
  Sprung s(def);
  TreeMotion motion(s.tree);
  std::vector<JointCommand> commands(3);
  // Two ways to give the same force: a wrench, or the generalised force that the last evaluation left.
  Sprung pulled = s;
  SteppedTree verlet = pulled.view();
  TreeMotion second(pulled.tree);
  verlet.motion = &second;
  verlet.commands = commands.data();
  s.v = pulled.v = {1, 2, 3};
  for (Sprung* each : {&s, &pulled}) each->evaluate();
  const JointReport& report = motion.step(kGravity, 1e-3, commands.data(), s.q.data(), s.v.data(), s.work.data());
  EXPECT_GT(report.damping, 0);
  readPull(verlet, kGravity, pulled.scratch);
  startVerlet(verlet, kGravity, 1e-3, pulled.scratch);
  EXPECT_LT(distance(s.v, pulled.v), 1e-12);
  EXPECT_LT(distance(s.q, pulled.q), 1e-15);
}

}  // namespace tree_step_test
}  // namespace haptic::test
