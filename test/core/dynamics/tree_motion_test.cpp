// Joints with laws of their own: every force on its graph, nothing gained, nothing creeping, rings closed.
#include "haptic_core/dynamics/tree_motion.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "chain.h"
#include "four_bar.h"
#include "haptic_core/base/error.h"
#include "haptic_core/dynamics/articulated_body.h"
#include "haptic_core/dynamics/joint_space_inertia.h"
#include "random_tree.h"

namespace haptic::test {
namespace tree_motion_test {

const Vector3 kGravity(0, 0, -9.8);

struct Scene {
  explicit Scene(const TreeDef& def, std::vector<RingDef> rings = {})
      : tree(def), motion(tree, rings), work(tree.linkCount()), q(tree.nq()), v(tree.nv()) {
    tree.initialState(q.data(), v.data());
    for (const BodyDef& body : def.links) commands.push_back(initialCommand(body.joint));
  }
  const JointReport& step(double h, const Vector3& gravity = kGravity, const double* tau = nullptr) {
    forwardKinematics(tree, q.data(), v.data(), work.data());
    return motion.step(gravity, h, commands.data(), q.data(), v.data(), work.data(), tau);
  }
  double energy(const Vector3& gravity = kGravity) {
    forwardKinematics(tree, q.data(), v.data(), work.data());
    return kineticEnergy(tree, work.data()) + potentialEnergy(tree, work.data(), gravity);
  }
  Articulation tree;
  TreeMotion motion;
  std::vector<LinkWork> work;
  std::vector<double> q, v;
  std::vector<JointCommand> commands;
};

TEST(TreeMotion, EveryJointForceLiesOnItsGraph) {
  Random random(21);
  int most = 0;
  for (int trial = 0; trial < 400; ++trial) {
    TreeDef def = randomTree(random, 2 + trial % 20, trial % 2);
    for (BodyDef& body : def.links) {
      body.joint.damping = random() % 2 ? uniform(random, 0, 3) : 0;
      if (random() % 2) body.joint.friction = uniform(random, 0, 5);
      if (random() % 3 == 0) body.joint.lower = uniform(random, -2, 0);
      if (random() % 3 == 0) body.joint.upper = uniform(random, 0, 2);
      body.joint.drive = static_cast<JointDef::Drive>(random() % 4);
      body.joint.drive_stiffness = uniform(random, 0, 1e4);
      body.joint.drive_damping = uniform(random, 0, 1e2);
      if (random() % 2) body.joint.max_effort = uniform(random, 0, 10);
    }
    Scene s(def);
    randomState(random, s.tree, s.q, s.v);
    const double h = 1e-3;
    std::vector<ForceGraph> graphs(s.tree.linkCount());
    for (int i = 0; i < s.tree.linkCount(); ++i) {
      const JointCommand command{def.links[i].joint.drive, uniform(random), uniform(random), uniform(random)};
      s.commands[i] = command;
      if (s.tree.link(i).dof == 1)
        buildForceGraph(def.links[i].joint, frictionOf(def.links[i].joint), command, s.q[s.tree.link(i).q], h, graphs[i]);
    }
    forwardKinematics(s.tree, s.q.data(), s.v.data(), s.work.data());
    std::vector<double> v_dot(s.tree.nv()), tau(s.tree.nv());
    const JointReport report =
        s.motion.accelerate(kGravity, h, s.commands.data(), s.q.data(), s.v.data(), s.work.data(), v_dot.data());
    EXPECT_TRUE(report.converged);
    most = std::max(most, report.passes);
    inverseDynamics(s.tree, kGravity, v_dot.data(), s.work.data(), tau.data());
    for (int i = 0; i < s.tree.linkCount(); ++i) {
      if (s.tree.link(i).dof != 1) continue;
      const int dof = s.tree.link(i).v;
      const double v1 = s.v[dof] + h * v_dot[dof];
      // The graph falls: its values just left and right of v₁ bracket the force.
      const auto value = [&](double v) {
        const ForcePiece& piece = graphs[i].pieces[graphs[i].at(v)];
        if (piece.vertical) return v < piece.from ? piece.high : piece.low;
        return piece.offset - piece.slope * v;
      };
      const double width = 1e-7 * (1 + std::abs(v1));
      double above = value(v1 - width), below = value(v1 + width);
      if (v1 - width < graphs[i].pieces[0].from) above = 1e300;
      if (v1 + width > graphs[i].pieces[graphs[i].count - 1].to) below = -1e300;
      const double slack = 1e-6 * (1 + std::abs(tau[dof]));
      EXPECT_LT(tau[dof], above + slack);
      EXPECT_GT(tau[dof], below - slack);
    }
  }
  EXPECT_LT(most, 40);
}

TreeDef pendulum() {
  return chain(1);
}

TEST(TreeMotion, FrictionHoldsToTheLastBitAndSlipsAboveItsLimit) {
  TreeDef def = pendulum();
  const double weight = kChainMass * 9.8 * kChainLength / 2;
  def.links[0].joint.friction = 1.01 * weight;
  Scene held(def);
  const double start = held.q[0];
  for (int i = 0; i < 10000; ++i) held.step(1e-3);
  EXPECT_EQ(held.q[0], start);
  EXPECT_EQ(held.v[0], 0);
  def.links[0].joint.friction = 0.99 * weight;
  Scene slipping(def);
  for (int i = 0; i < 1000; ++i) slipping.step(1e-3);
  EXPECT_GT(slipping.q[0], 1e-3);
}

TEST(TreeMotion, FrictionStopsAMovingJointExactlyWhereTheEnergyIsSpent) {
  TreeDef def = pendulum();
  def.links[0].joint.friction = 0.01;
  Scene s(def);
  s.v[0] = 2;
  const double start = s.energy(Vector3::Zero());
  double dissipated = 0;
  for (int i = 0; i < 2000; ++i) dissipated += s.step(1e-3, Vector3::Zero()).friction;
  EXPECT_EQ(s.v[0], 0);
  EXPECT_NEAR(dissipated, start, 1e-12);
  EXPECT_NEAR(s.q[0], start / 0.01, 1e-3 * 2);  // one step's way
}

TEST(TreeMotion, LimitsStopWithoutGainAndPushTheParent) {
  TreeDef def = chain(3, true);
  for (int i = 1; i < 3; ++i) {
    def.links[i].joint.lower = -0.2;
    def.links[i].joint.upper = 0.3;
  }
  Scene s(def);
  s.v[6] = 8;
  s.v[7] = -5;
  double energy = s.energy(Vector3::Zero());
  const Wrench before = momentum(s.tree, s.work.data(), Vector3::Zero());
  const double start = energy;
  for (int i = 0; i < 1000; ++i) {
    s.step(1e-4, Vector3::Zero());
    for (int k : {7, 8}) {
      EXPECT_LE(s.q[k], 0.3 + 1e-12);
      EXPECT_GE(s.q[k], -0.2 - 1e-12);
    }
  }
  EXPECT_LT(s.energy(Vector3::Zero()), 0.98 * start);
  // A limit without reaction would leave the sum of momenta; linear momentum is exact, angular of first
  // order.
  const Wrench after = momentum(s.tree, s.work.data(), Vector3::Zero());
  EXPECT_LT((after.force - before.force).norm(), 1e-4);
  EXPECT_LT((after.torque - before.torque).norm(), 2e-3 * before.torque.norm());
}

TEST(TreeMotion, AFallOntoALimitLosesEnergyInEveryStepThatHitsIt) {
  TreeDef def = pendulum();
  def.links[0].joint.upper = 0.5;
  Scene s(def);
  double before = s.energy();
  for (int i = 0; i < 2000; ++i) {
    const JointReport report = s.step(1e-3);
    const double after = s.energy();
    if (s.q[0] == 0.5 || report.friction != 0) EXPECT_LE(after, before + 1e-15);
    before = after;
  }
  EXPECT_NEAR(s.q[0], 0.5, 1e-12);
  EXPECT_EQ(s.v[0], 0);
}

TEST(TreeMotion, AnyGainIsStableAndEffortIsBounded) {
  for (double stiffness : {1e2, 1e6, 1e12}) {
    TreeDef def = pendulum();
    def.links[0].joint.drive = JointDef::Drive::kPosition;
    def.links[0].joint.drive_stiffness = stiffness;
    def.links[0].joint.drive_damping = 1;
    Scene s(def);
    s.commands[0].position = -1;
    for (int i = 0; i < 3000; ++i) s.step(1e-2);
    const double sag = kChainMass * 9.8 * kChainLength / 2 * std::cos(1.0) / stiffness;
    EXPECT_NEAR(s.q[0], -1 + sag, 0.02 * sag + 1e-9) << stiffness;
  }
  TreeDef def = pendulum();
  def.links[0].joint.drive = JointDef::Drive::kPosition;
  def.links[0].joint.drive_stiffness = 1e6;
  def.links[0].joint.max_effort = 0.001;
  Scene s(def);
  s.commands[0].position = 10;
  for (int i = 0; i < 100; ++i) s.step(1e-3, Vector3::Zero());
  const LinkModel& link = s.tree.link(0);
  EXPECT_NEAR(s.v[0], 0.001 * 0.1 / link.I_O(1, 1), 1e-10);
  s.commands[0].position = std::nan("");
  EXPECT_FALSE(isFinite(s.commands[0]));
}

/// An arm of three links whose drives, springs, damping and friction move it within their kinks.
TreeDef drivenArm(bool floating = false) {
  TreeDef def = chain(floating ? 4 : 3, floating);
  for (BodyDef& body : def.links) {
    JointDef& joint = body.joint;
    if (joint.type == JointType::kFloating) continue;
    joint.drive = JointDef::Drive::kPosition;
    joint.drive_stiffness = 0.2;
    joint.drive_damping = 0.002;
    joint.spring_stiffness = 0.05;
    joint.spring_position = 0.3;
    joint.damping = 0.001;
    if (body.parent < 0) joint.friction = 0.01;  // the others turn back
    joint.position = 0.4;
    joint.velocity = body.parent < 0 ? 3 : 1;
    joint.lower = -3;
    joint.upper = 3;
  }
  return def;
}

/// q and v after 32 ms in steps of h, and the change of energy that the works of the joints do not say [J].
struct Moved {
  std::vector<double> state;
  double missing = 0;
  int passes = 0;
};

Moved moveArm(const TreeDef& def, double h, const Vector3& gravity = kGravity) {
  Scene s(def);
  for (JointCommand& command : s.commands) command.position = 1;
  const auto energy = [&] {
    double sum = s.energy(gravity);
    for (int i = 0; i < s.tree.linkCount(); ++i) {
      if (s.tree.link(i).dof == 1) sum += springEnergy(def.links[i].joint, s.q[s.tree.link(i).q]);
    }
    return sum;
  };
  Moved moved;
  moved.missing = -energy();
  for (int i = 0; i < std::lround(0.032 / h); ++i) {
    const JointReport& report = s.step(h, gravity);
    moved.missing -= report.drives - report.damping - report.friction;
    moved.passes += report.passes;
  }
  moved.missing += energy();
  moved.state = s.q;
  moved.state.insert(moved.state.end(), s.v.begin(), s.v.end());
  return moved;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum);
}

TEST(TreeMotion, SmoothJointsAreOfFourthOrderAndSoAreTheirWorks) {
  const TreeDef def = drivenArm();
  const Moved exact = moveArm(def, 6.25e-5), coarse = moveArm(def, 2e-3), fine = moveArm(def, 1e-3);
  EXPECT_EQ(coarse.passes + fine.passes, 0);  // no step of symplectic Euler
  const double order = std::log2(distance(coarse.state, exact.state) / distance(fine.state, exact.state));
  EXPECT_GT(order, 3.7);
  EXPECT_GT(std::log2(std::abs(coarse.missing / fine.missing)), 3.7);
  EXPECT_LT(std::abs(exact.missing), 1e-12);
}

/// One joint at the bound, between a spring alone and a damper alone: nothing grows; beyond it, implicit.
TEST(TreeMotion, AResolvedStepIsStable) {
  const double h = 1e-3;
  for (double damper = 0; damper <= 1; damper += 0.125) {
    for (const double rate : {2.99, 3.01}) {
      TreeDef def = chain(1);
      JointDef& joint = def.links[0].joint;
      Scene bare(def);
      double moment;
      forwardKinematics(bare.tree, bare.q.data(), bare.v.data(), bare.work.data());
      massMatrix(bare.tree, bare.work.data(), &moment);
      joint.drive = JointDef::Drive::kPosition;
      joint.drive_damping = damper * rate * moment / h;
      joint.drive_stiffness = (1 - damper) * rate * moment / (h * h);
      joint.velocity = 1;
      Scene s(def);
      double fastest = 0;
      for (int i = 0; i < 1000; ++i) {
        EXPECT_EQ(s.step(h, Vector3::Zero()).passes == 0, rate < 3 && std::abs(s.v[0]) * h > kStandingWay) << damper << " " << i;
        fastest = std::max(fastest, std::abs(s.v[0]));
        if (std::abs(s.v[0]) * h <= 10 * kStandingWay) break;
      }
      EXPECT_LE(fastest, 1) << damper;
    }
  }
}

TEST(TreeMotion, DrivesOfAFloatingTreeKeepItsMomentum) {
  const TreeDef def = drivenArm(true);
  Scene s(def);
  for (JointCommand& command : s.commands) command.position = 1;
  const auto momentum = [&] {
    forwardKinematics(s.tree, s.q.data(), s.v.data(), s.work.data());
    Wrench sum;
    for (int i = 0; i < s.tree.linkCount(); ++i) {
      const LinkWork& w = s.work[i];
      const LinkModel& link = s.tree.link(i);
      const Vector3 v_C = w.velocity + w.omega.cross(w.p_OC), p = link.mass * v_C;
      const Matrix3 I_C = w.X_WL.R * def.links[i].inertia.I_C * w.X_WL.R.transpose();
      sum += Wrench{I_C * w.omega + w.p_WC().cross(p), p};
    }
    return sum.vector().eval();
  };
  const Vector6 start = momentum();
  for (int i = 0; i < 32; ++i) EXPECT_EQ(s.step(1e-3, Vector3::Zero()).passes, 0);
  EXPECT_LT((momentum() - start).norm(), 1e-13 * (1 + start.norm()));
}

/// Where a law bends or jumps in a step, or is too stiff for it, the step is that of symplectic Euler to the last bit.
TEST(TreeMotion, KinksAndStiffnessTakeTheStepOfTheGraph) {
  const auto change = [](void (*act)(JointDef&)) {
    TreeDef def = drivenArm();
    act(def.links[1].joint);
    return def;
  };
  for (const TreeDef& def : {change([](JointDef& joint) { joint.upper = joint.position + 0.0005; }),
                             change([](JointDef& joint) { joint.friction = 20; }),
                             change([](JointDef& joint) { joint.drive_stiffness = 1e3; }),
                             change([](JointDef& joint) { joint.drive_damping = 10; }),
                             change([](JointDef& joint) { joint.max_effort = 0.1179; })}) {
    Scene s(def), euler(def);
    for (Scene* each : {&s, &euler}) {
      for (JointCommand& command : each->commands) command.position = 1;
    }
    std::vector<double> v_dot(s.tree.nv());
    forwardKinematics(euler.tree, euler.q.data(), euler.v.data(), euler.work.data());
    euler.motion.accelerate(kGravity, 1e-3, euler.commands.data(), euler.q.data(), euler.v.data(), euler.work.data(), v_dot.data());
    const std::vector<double> start = s.v;
    EXPECT_GT(s.step(1e-3).passes, 0);
    for (int k = 0; k < s.tree.nv(); ++k) EXPECT_NEAR(s.v[k], start[k] + 1e-3 * v_dot[k], 1e-13) << k;
  }
}

TEST(TreeMotion, MimicFollowsWithTheInertiaOfBoth) {
  TreeDef def;
  for (int i = 0; i < 2; ++i) {
    BodyDef wheel;
    wheel.name = i ? "follower" : "leader";
    wheel.joint.name = wheel.name;
    wheel.joint.type = JointType::kRevolute;
    wheel.joint.axis = Vector3::UnitZ();
    wheel.inertia.mass = 1;
    wheel.inertia.I_C = Vector3(1, 1, i ? 0.3 : 0.5).asDiagonal();
    def.links.push_back(wheel);
  }
  def.links[0].joint.drive = JointDef::Drive::kEffort;
  def.links[1].joint.mimic_joint = 0;
  def.links[1].joint.mimic_multiplier = -2;
  def.links[1].joint.mimic_offset = 0.25;
  Scene s(def);
  ASSERT_TRUE(s.motion.close(s.q.data(), s.v.data(), s.work.data()));
  const double gap = s.q[1] + 2 * s.q[0];
  EXPECT_NEAR(gap, 0.25, 1e-9);
  s.commands[0].effort = 1;
  for (int i = 0; i < 1000; ++i) s.step(1e-3);
  EXPECT_NEAR(s.v[0], 1 / (0.5 + 4 * 0.3), 1e-9);
  EXPECT_NEAR(s.q[1], -2 * s.q[0] + 0.25, 1e-9);
}

TEST(TreeMotion, FourBarStaysClosedAndSwingsLikeThePendulumItIs) {
  Scene s(fourBar(), fourBarRing());
  s.q[0] = 0.8;
  s.q[1] = -0.8;
  s.q[2] = 0.8;
  ASSERT_TRUE(s.motion.close(s.q.data(), s.v.data(), s.work.data()));
  // Parallelogram: one degree of freedom, (2 I + m_c l²) θ̈ = −g (2 m l/2 + m_c l) sin θ, here by leapfrog.
  double angle = s.q[0], rate = 0;
  const double h = 1e-3;
  for (int i = 0; i < 1000; ++i) {
    const JointReport& report = s.step(h);
    EXPECT_EQ(report.passes, 0);  // of fourth order
    EXPECT_LT(report.closure, 1e-7);
    constexpr int kFiner = 200;
    for (int k = 0; k < kFiner; ++k) {
      rate -= 0.5 * h / kFiner * fourBarStiffness() * std::sin(angle);
      angle += h / kFiner * rate;
      rate -= 0.5 * h / kFiner * fourBarStiffness() * std::sin(angle);
    }
  }
  // Leapfrog at 5 µs errs by (ω h)²/24 ω t, ω = 8/s: 5e-10. Merson's formula at 1 ms by less, and the links stay parallel.
  EXPECT_NEAR(s.q[0], angle, 1e-8);
  EXPECT_NEAR(s.q[1], -s.q[0], 1e-9);
}

/// A free ring of `links` hinged links that lie in a circle, turn and fold; oblique, so that no row of it vanishes to the last bit.
TreeDef freeRing(int links) {
  TreeDef def = chain(links, true);
  def.links[0].joint.X_PJ.R = Quaternion(0.7, 0.3, -0.5, 0.4).normalized().toRotationMatrix();
  for (int i = 0; i < links; ++i) {
    JointDef& joint = def.links[i].joint;
    joint.axis = Vector3::UnitZ();
    if (i > 0) joint.position = 2 * M_PI / links;
  }
  return def;
}

RingDef closureOf(const TreeDef& def, RingDef::Type type) {
  RingDef ring;
  ring.link_a = static_cast<int>(def.links.size()) - 1;
  ring.link_b = 0;
  ring.X_AF = Pose(Vector3(kChainLength, 0, 0));
  ring.type = type;
  return ring;
}

/// After .24 s of steps h; the first velocity does not fit the ring, which takes what opens it. `gained`: of its energy, the largest.
std::vector<double> moveRing(int links, RingDef::Type type, double h, double* gained = nullptr) {
  const TreeDef def = freeRing(links);
  Scene s(def, {closureOf(def, type)});
  Eigen::Map<Vector3>(s.v.data()) = 20 * def.links[0].joint.X_PJ.R.col(2);
  s.v[6] = -40;
  s.step(1e-6, Vector3::Zero());
  const double start = s.energy(Vector3::Zero());
  for (int i = 0; i < std::lround(0.24 / h); ++i) {
    const JointReport& report = s.step(h, Vector3::Zero());
    EXPECT_EQ(report.passes, 0) << i;
    EXPECT_LT(report.closure, 1e-7);
    if (gained) *gained = std::max(*gained, std::abs(s.energy(Vector3::Zero()) / start - 1));
  }
  std::vector<double> state = s.q;
  state.insert(state.end(), s.v.begin(), s.v.end());
  return state;
}

/// The rows of a hinge or a weld of a planar ring repeat others: its motion is that of the ring closed by a point.
TEST(TreeMotion, RingsAreOfFourthOrderAndKeepTheirEnergy) {
  for (const int links : {4, 6, 12}) {
    double gained = 0;
    const auto coarse = moveRing(links, RingDef::Type::kHinge, 4e-3), fine = moveRing(links, RingDef::Type::kHinge, 2e-3),
               exact = moveRing(links, RingDef::Type::kHinge, 2.5e-4, &gained);
    EXPECT_GT(std::log2(distance(coarse, exact) / distance(fine, exact)), 3.5) << links;
    EXPECT_LT(gained, 1e-7) << links;
    EXPECT_LT(distance(moveRing(links, RingDef::Type::kPoint, 2.5e-4), exact), 1e-7) << links;
  }
}

TEST(TreeMotion, ClosesARingInSpaceToTheWorld) {
  Random random(22);
  TreeDef def = chain(6);
  RingDef ring;
  ring.link_a = -1;
  ring.link_b = 5;
  ring.X_AF = Pose(Vector3(0.4, 0.05, -0.1));
  ring.X_BF = Pose(Vector3(kChainLength, 0, 0));
  Scene s(def, {ring});
  s.q = {0.3, -0.4, 0.5, 0.2, -0.3, 0.4};
  ASSERT_TRUE(s.motion.close(s.q.data(), s.v.data(), s.work.data()));
  const double start = s.energy();
  for (int i = 0; i < 2000; ++i) {
    ASSERT_LT(s.step(1e-3).closure, 1e-6);
    ASSERT_LT(s.energy(), start + 0.02 * kChainMass * 9.8 * 0.6 * 6);
  }
}

TEST(TreeMotion, GivenForcesActLikeTheWrenchesTheyComeFrom) {
  Random random(23);
  TreeDef def = chain(5);
  for (BodyDef& body : def.links) {
    body.joint.friction = 0.02;
    body.joint.damping = 0.01;
    body.joint.upper = 0.4;
  }
  Scene one(def), two(def);
  for (int i = 0; i < 400; ++i) {
    const Wrench F{randomVector(random, 0.05), randomVector(random)};
    forwardKinematics(one.tree, one.q.data(), one.v.data(), one.work.data());
    std::vector<double> tau(one.tree.nv(), 0);
    const Vector3 p = one.work[3].p_WO;
    addGeneralisedForce(one.tree, one.work.data(), 3, F, p, tau.data());
    one.work[3].addWrench(F, p);
    one.motion.step(kGravity, 1e-3, one.commands.data(), one.q.data(), one.v.data(), one.work.data());
    two.step(1e-3, kGravity, tau.data());
    // Rounding of one step; the whip of a chain amplifies it over the steps, so both start from one state again.
    for (int k = 0; k < one.tree.nv(); ++k) EXPECT_NEAR(two.v[k], one.v[k], 1e-11 * (1 + std::abs(one.v[k])));
    two.q = one.q;
    two.v = one.v;
  }
}

TEST(TreeMotion, RefusesRingsThatAreNotThere) {
  RingDef ring;
  ring.name = "ring";
  ring.link_b = 9;
  const Articulation tree(chain(3));
  EXPECT_THROW(TreeMotion(tree, {ring}), SetupError);
}

}  // namespace tree_motion_test
}  // namespace haptic::test
