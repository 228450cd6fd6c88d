// Joints with laws of their own in a world: against the tree alone, against statics, with contact, saved and
// restored.
#include <gtest/gtest.h>

#include <cmath>

#include "../../scenes/blocks.h"
#include "../dynamics/chain.h"
#include "../dynamics/four_bar.h"
#include "../dynamics/random_tree.h"
#include "haptic_core/base/error.h"
#include "haptic_core/dynamics/joint_space_inertia.h"
#include "haptic_core/dynamics/tree_motion.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace joints_test {

ArticulationDef articulationOf(const TreeDef& tree) {
  ArticulationDef def;
  def.name = tree.name;
  def.X_WA = tree.X_WA;
  def.V_WA = tree.V_WA;
  for (const BodyDef& body : tree.links) {
    LinkDef link;
    static_cast<BodyDef&>(link) = body;
    def.links.push_back(link);
  }
  return def;
}

/// A chain with every law a joint can have.
TreeDef lawfulChain() {
  TreeDef tree = test::chain(4);
  for (BodyDef& body : tree.links) {
    body.joint.damping = 1e-3;
    body.joint.friction = 2e-3;
    body.joint.lower = -0.3;
    body.joint.upper = 0.4;
  }
  tree.links[1].joint.drive = JointDef::Drive::kPosition;
  tree.links[1].joint.drive_stiffness = 5;
  tree.links[1].joint.drive_damping = 0.01;
  tree.links[1].joint.max_effort = 0.3;
  tree.links[3].joint.mimic_joint = 2;
  tree.links[3].joint.mimic_multiplier = 0.5;
  return tree;
}

/// An arm of 0.2 m along x on a hinge about z at the origin, its tip a box; no gravity. A floor is not there.
WorldDef armAndBox(double friction, Attempts attempts) {
  WorldDef def;
  def.name = "arm";
  def.settings.attempts = attempts;
  def.settings.gravity.setZero();
  def.settings.default_material = scenes::CubeParameters{}.material();
  ArticulationDef arm = scenes::freeBox("arm", Vector3(0.2, 0.02, 0.02), 0.2, Pose());
  LinkDef& link = arm.links[0];
  link.joint.type = JointType::kRevolute;
  link.joint.name = "hinge";
  link.joint.axis = Vector3::UnitZ();
  link.joint.friction = friction;
  link.inertia.p_LC = Vector3(0.1, 0, 0);
  link.collisions[0].X_LS = Pose(Vector3(0.1, 0, 0));
  def.articulations.push_back(arm);
  // A block that is driven against the tip, 0.18 m from the hinge, along y.
  ArticulationDef block =
      scenes::freeBox("block", Vector3(0.02, 0.02, 0.02), 0.1, Pose(Vector3(0.18, -0.02, 0)));
  block.links[0].joint.type = JointType::kPrismatic;
  block.links[0].joint.name = "slide";
  block.links[0].joint.axis = Vector3::UnitY();
  block.links[0].joint.drive = JointDef::Drive::kEffort;
  block.links[0].joint.damping = 20;
  def.articulations.push_back(block);
  return def;
}

WorldDef worldOf(const TreeDef& tree, Attempts attempts = Attempts::kAll) {
  WorldDef def;
  def.name = "world";
  def.settings.attempts = attempts;
  def.articulations.push_back(articulationOf(tree));
  return def;
}

class EveryMethod : public testing::TestWithParam<Attempts> {};
INSTANTIATE_TEST_SUITE_P(All, EveryMethod,
                         testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2));

TEST(Joints, ThatFlowMoveAsTheTreeAloneDoes) {
  const TreeDef def = lawfulChain();
  World world(worldOf(def));
  const Articulation tree(def);
  TreeMotion motion(tree);
  std::vector<LinkWork> work(tree.linkCount());
  std::vector<double> q(tree.nq()), v(tree.nv());
  std::vector<JointCommand> commands;
  for (const BodyDef& body : def.links) commands.push_back(initialCommand(body.joint));
  tree.initialState(q.data(), v.data());
  ASSERT_EQ(world.jointCount(), 4);
  for (int i = 0; i < 1000; ++i) {
    if (i == 300) {
      commands[1] = {JointDef::Drive::kVelocity, 0, 0.7, 0.01};
      ASSERT_TRUE(world.setJointCommand(1, commands[1]));
    }
    forwardKinematics(tree, q.data(), v.data(), work.data());
    motion.step(Vector3(0, 0, -9.8), 1e-3, commands.data(), q.data(), v.data(), work.data());
    world.step();
    for (int k = 0; k < 4; ++k) {
      ASSERT_EQ(world.joint(k).position, q[k]) << i;
      ASSERT_EQ(world.joint(k).velocity, v[k]) << i;
      ASSERT_EQ(world.joint(k).drive, motion.forceOf(k).drive) << i;
      ASSERT_EQ(world.joint(k).effort, motion.forceOf(k).all) << i;
    }
  }
  EXPECT_EQ(world.report().flags, 0u);
}

TEST_P(EveryMethod, FrictionHoldsAgainstAContactUpToItsLimit) {
  const double arm = 0.18, limit = 0.5 / arm;  // [N] at the tip
  for (const double share : {0.9, 1.1}) {
    World world(armAndBox(0.5, GetParam()));
    const int slide = world.jointIndex("slide");
    for (int i = 0; i < 3000; ++i) {
      const double force = share * limit * std::min(1.0, i / 2000.0);
      ASSERT_TRUE(world.setJointCommand(slide, {JointDef::Drive::kEffort, 0, 0, force}));
      world.step();
    }
    const JointReading hinge = world.joint(world.jointIndex("hinge"));
    if (share < 1) {
      EXPECT_EQ(hinge.position, 0);  // to the last bit
      EXPECT_EQ(hinge.velocity, 0);
      ASSERT_EQ(world.contactCount(), 1);
      EXPECT_NEAR(world.contact(0).normal_force, share * limit, 0.01 * limit);  // the dampers still give way
    } else {
      EXPECT_GT(hinge.position, 1e-3);
    }
  }
}

TEST_P(EveryMethod, SaveAndRestoreContinueWithTheSameBits) {
  const WorldDef def = armAndBox(0.05, GetParam());
  World one(def), two(def);
  ASSERT_TRUE(one.setJointCommand(one.jointIndex("slide"), {JointDef::Drive::kEffort, 0, 0, 3}));
  for (int i = 0; i < 200; ++i) one.step();
  EXPECT_NE(one.hash(), two.hash());
  two.restore(one.save());
  EXPECT_EQ(one.hash(), two.hash());
  for (int i = 0; i < 500; ++i) {
    one.step();
    two.step();
    ASSERT_EQ(one.hash(), two.hash()) << "step " << i;
  }
  const std::uint64_t before = one.hash();
  ASSERT_TRUE(one.setJointCommand(one.jointIndex("slide"), {JointDef::Drive::kEffort, 0, 0, 3.5}));
  EXPECT_NE(one.hash(), before);  // commands are part of the state
}

TEST_P(EveryMethod, LedgerAccountsForEveryJouleUpToTheStep) {
  double error[2];
  for (int half = 0; half < 2; ++half) {
    WorldDef def = worldOf(lawfulChain(), GetParam());
    def.settings.step = half ? 5e-4 : 1e-3;
    World world(def);
    ASSERT_TRUE(world.setJointCommand(1, {JointDef::Drive::kPosition, 0.2, 0, 0}));
    world.step();
    const double start = world.report().energy.balance();
    while (world.time() < 0.5) world.step();
    const EnergyLedger& e = world.report().energy;
    EXPECT_GT(e.damping, 0);
    EXPECT_GT(e.friction, 0);
    error[half] = std::abs(e.balance() - start);
  }
  EXPECT_LT(error[1], 0.6 * error[0]);  // first order
}

/// The parallelogram of four_bar.h, its left bar and rod on one root, its right bar on another, closed by a
/// loop.
WorldDef twoRootedFourBar(Attempts attempts) {
  const TreeDef whole = test::fourBar();
  TreeDef left = whole, right = whole;
  left.links.resize(2);
  left.name = "left";
  right.links = {whole.links[2]};
  right.links[0].parent = -1;
  right.name = "right";
  WorldDef def = worldOf(left, attempts);
  // Something between them, so that joining changes the order of links.
  def.articulations.push_back(scenes::freeBox("stone", Vector3(0.01, 0.01, 0.01), 1, Pose(Vector3(9, 0, 0))));
  def.articulations.push_back(articulationOf(right));
  const RingDef ring = test::fourBarRing()[0];
  LoopDef loop;
  loop.name = "closure";
  loop.articulation_a = ring.link_a < 2 ? 0 : 2;
  loop.link_a = ring.link_a < 2 ? ring.link_a : 0;
  loop.articulation_b = ring.link_b < 2 ? 0 : 2;
  loop.link_b = ring.link_b < 2 ? ring.link_b : 0;
  loop.X_AF = ring.X_AF;
  loop.X_BF = ring.X_BF;
  loop.type = ring.type;
  loop.axis = ring.axis;
  def.loops.push_back(loop);
  return def;
}

TEST(Joints, ALoopOverTwoArticulationsMovesAsOneTree) {
  WorldDef def = twoRootedFourBar(Attempts::kAll);
  def.articulations[0].links[0].joint.position = 0.8;
  def.articulations[0].links[1].joint.position = -0.8;
  def.articulations[2].links[0].joint.position = 0.8;
  World world(def);
  TreeDef whole = test::fourBar();
  const Articulation tree(whole);
  TreeMotion motion(tree, test::fourBarRing());
  std::vector<LinkWork> work(3);
  std::vector<double> q = {0.8, -0.8, 0.8}, v(3);
  std::vector<JointCommand> commands(3);
  ASSERT_TRUE(motion.close(q.data(), v.data(), work.data()));
  for (int i = 0; i < 1000; ++i) {
    world.step();
    forwardKinematics(tree, q.data(), v.data(), work.data());
    motion.step(def.settings.gravity, 1e-3, commands.data(), q.data(), v.data(), work.data());
    EXPECT_LT(world.report().closure, 1e-6);
  }
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(world.joint(k).position, q[k], 1e-9);
  EXPECT_EQ(world.linkName(world.jointLink(2)), whole.links[2].name);
  EXPECT_GE(world.linkIndex("stone"), 0);
}

/// A random tree whose joints have random laws, in motion.
TreeDef randomLawfulTree(test::Random& random, int links, bool floating) {
  TreeDef def = test::randomTree(random, links, floating);
  for (BodyDef& body : def.links) {
    JointDef& joint = body.joint;
    if (joint.type != JointType::kRevolute && joint.type != JointType::kPrismatic) continue;
    joint.position = test::uniform(random, -1, 1);
    joint.velocity = test::uniform(random, -2, 2);
    joint.damping = random() % 2 ? test::uniform(random, 0, 3) : 0;
    if (random() % 2) joint.friction = test::uniform(random, 0, 5);
    if (random() % 3 == 0) joint.lower = test::uniform(random, -2, joint.position);
    if (random() % 3 == 0) joint.upper = test::uniform(random, joint.position, 2);
    joint.drive = static_cast<JointDef::Drive>(random() % 4);
    joint.drive_stiffness = test::uniform(random, 0, 1e4);
    joint.drive_damping = test::uniform(random, 0, 1e2);
    if (random() % 2) joint.max_effort = test::uniform(random, 0, 10);
  }
  return def;
}

/// Oracle: inverse dynamics at the end of the step says what force every joint had; it must be one of its
/// graph.
TEST(ImplicitJoints, EveryForceLiesOnItsGraph) {
  test::Random random(31);
  for (int trial = 0; trial < 120; ++trial) {
    const TreeDef def = randomLawfulTree(random, 2 + trial % 12, trial % 2);
    World world(worldOf(def, Attempts::kImplicitEuler));
    const Articulation tree(def);
    const double h = world.settings().step;
    std::vector<LinkWork> work(tree.linkCount());
    for (int step = 0; step < 20; ++step) {
      const State before = world.state();
      world.step();
      ASSERT_EQ(world.report().flags, 0u) << trial << " " << step;
      const State& after = world.state();
      std::vector<double> v_dot(tree.nv()), tau(tree.nv());
      for (int k = 0; k < tree.nv(); ++k) v_dot[k] = (after.v[k] - before.v[k]) / h;
      forwardKinematics(tree, after.q.data(), after.v.data(), work.data());
      inverseDynamics(tree, Vector3(0, 0, -9.8), v_dot.data(), work.data(), tau.data());
      for (int i = 0; i < tree.linkCount(); ++i) {
        const LinkModel& link = tree.link(i);
        if (link.dof != 1) {
          for (int k = 0; k < link.dof; ++k)
            EXPECT_NEAR(tau[link.v + k], 0, 1e-6 * (1 + std::abs(v_dot[link.v + k])));
          continue;
        }
        const double v1 = after.v[link.v];
        ForceGraph graph;
        buildForceGraph(def.links[i].joint, frictionOf(def.links[i].joint), initialCommand(def.links[i].joint), before.q[link.q], h, graph);
        const auto value = [&](double rate) {
          const ForcePiece& piece = graph.pieces[graph.at(rate)];
          if (piece.vertical) return rate < piece.from ? piece.high : piece.low;
          return piece.offset - piece.slope * rate;
        };
        // The graph falls: its values just left and right of v₁ bracket the force.
        const double width = 1e-7 * (1 + std::abs(v1)), slack = 1e-6 * (1 + std::abs(tau[link.v]));
        if (v1 - width > graph.pieces[0].from) EXPECT_LT(tau[link.v], value(v1 - width) + slack);
        if (v1 + width < graph.pieces[graph.count - 1].to) EXPECT_GT(tau[link.v], value(v1 + width) - slack);
      }
    }
  }
}

/// From one smooth motion of a driven and damped chain, against a step that is 64 times shorter.
TEST(ImplicitJoints, FollowTheirOrderWhereNothingJumps) {
  TreeDef tree = test::chain(3);
  for (BodyDef& body : tree.links) {
    body.joint.damping = 2e-3;
    body.joint.drive = JointDef::Drive::kPosition;
    body.joint.drive_stiffness = 1;
    body.joint.drive_damping = 0.01;
  }
  const auto end = [&](Attempts attempts, double h) {
    WorldDef def = worldOf(tree, attempts);
    def.settings.step = h;
    World world(def);
    for (int i = 0; i < std::lround(0.256 / h); ++i) world.step();
    return Vector3(world.joint(0).position, world.joint(1).position, world.joint(2).position);
  };
  const Vector3 exact = end(Attempts::kSdirk2, 1. / 16000);
  for (const auto& [attempts, order] :
       {std::pair{Attempts::kImplicitEuler, 1}, {Attempts::kSdirk2, 2}}) {
    const double coarse = (end(attempts, 4e-3) - exact).norm(),
                 fine = (end(attempts, 2e-3) - exact).norm();
    EXPECT_NEAR(std::log2(coarse / fine), order, 0.15);
  }
}

/// Robots that nothing connects are problems of their own: to the last bit what each does alone.
TEST(ImplicitJoints, RobotsThatDoNotMeetMoveAsEachAlone) {
  for (const Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2}) {
    TreeDef first = lawfulChain(), second = lawfulChain();
    second.links[0].joint.position = 0.2;
    second.links[1].joint.drive_stiffness = 50;
    WorldDef def = worldOf(first, attempts);
    def.articulations.push_back(articulationOf(second));
    for (LinkDef& link : def.articulations[1].links) link.name += "_2", link.joint.name += "_2";
    def.articulations[1].name += "_2";
    World both(def), one(worldOf(first, attempts)), other(worldOf(second, attempts));
    for (int i = 0; i < 500; ++i) {
      both.step(), one.step(), other.step();
      ASSERT_EQ(both.report().implicit_islands, 2);
      const std::vector<double>&v = both.state().v, &v1 = one.state().v, &v2 = other.state().v;
      ASSERT_TRUE(std::equal(v1.begin(), v1.end(), v.begin())) << i;
      ASSERT_TRUE(std::equal(v2.begin(), v2.end(), v.begin() + v1.size())) << i;
    }
    for (int k = 0; k < 4; ++k) EXPECT_EQ(both.joint(4 + k).effort, other.joint(k).effort);
  }
}

/// What one robot touches does not make another one implicit.
TEST(ImplicitJoints, ARobotThatTouchesNothingStaysExplicit) {
  WorldDef def = armAndBox(0.01, Attempts::kAll);
  def.settings.default_material.stiffness *= 1e6;
  def.articulations[1].links[0].joint.drive_effort = 1;
  TreeDef apart = lawfulChain();
  def.articulations.push_back(articulationOf(apart));
  def.articulations.back().name = "apart";
  World world(def);
  for (int i = 0; i < 20; ++i) world.step();
  EXPECT_EQ(world.state().mode[0], TreeMode::kImplicit);
  EXPECT_EQ(world.state().mode[1], TreeMode::kImplicit);
  EXPECT_NE(world.state().mode[2], TreeMode::kImplicit);
}

TEST(ImplicitJoints, AnyGainAndAnyStepAreStable) {
  for (double stiffness : {1e2, 1e6, 1e12}) {
    TreeDef tree = test::chain(1);
    tree.links[0].joint.drive = JointDef::Drive::kPosition;
    tree.links[0].joint.drive_stiffness = stiffness;
    tree.links[0].joint.drive_damping = 1;
    WorldDef def = worldOf(tree, Attempts::kImplicitEuler);
    def.settings.step = 1e-2;
    World world(def);
    ASSERT_TRUE(world.setJointCommand(0, {JointDef::Drive::kPosition, -1, 0, 0}));
    for (int i = 0; i < 3000; ++i) world.step();
    const double sag = test::kChainMass * 9.8 * test::kChainLength / 2 * std::cos(1.0) / stiffness;
    EXPECT_NEAR(world.joint(0).position, -1 + sag, 0.02 * sag + 1e-9) << stiffness;
    EXPECT_EQ(world.report().flags, 0u);
  }
}

TEST(ImplicitJoints, LimitsNeverAddEnergy) {
  // One hinge without gravity: its inertia is constant, so that nothing but the limit can change the energy.
  for (const Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2}) {
    for (double speed : {0.3, 9., 100.}) {
      TreeDef tree = test::chain(1);
      tree.links[0].joint.lower = -0.4;
      tree.links[0].joint.upper = 0.3;
      tree.links[0].joint.velocity = speed;
      WorldDef def = worldOf(tree, attempts);
      def.settings.gravity.setZero();
      World world(def);
      double before = 0.5 * (test::kChainMass / 12 * 1.04e-2 + test::kChainMass * 2.5e-3) * speed * speed;
      const double start = before;
      for (int i = 0; i < 2000; ++i) {
        world.step();
        const EnergyLedger& e = world.report().energy;
        EXPECT_LE(e.kinetic, before * (1 + 1e-13));
        EXPECT_NEAR(e.kinetic + e.friction, start, 1e-12 * start);
        before = e.kinetic;
        EXPECT_LE(world.joint(0).position, 0.3 + 1e-12);
      }
      EXPECT_EQ(world.joint(0).velocity, 0);
    }
  }
}

TEST(ImplicitJoints, LoopsStayClosedAndSwingAsTheyShould) {
  for (const Attempts attempts : {Attempts::kImplicitEuler, Attempts::kSdirk2}) {
    WorldDef def = twoRootedFourBar(attempts);
    def.settings.step = 1e-4;
    def.articulations[0].links[0].joint.position = 0.8;
    def.articulations[0].links[1].joint.position = -0.8;
    def.articulations[2].links[0].joint.position = 0.8;
    World world(def);
    double angle = 0.8, rate = 0;  // symplectic Euler at a tenth of the step
    for (int i = 0; i < 10000; ++i) {
      world.step();
      ASSERT_LT(world.report().closure, 1e-9);
      for (int s = 0; s < 10; ++s) {
        rate -= 1e-5 * test::fourBarStiffness() * std::sin(angle);
        angle += 1e-5 * rate;
      }
    }
    // Implicit Euler damps by h ω² t/2 = 2e-3; SDIRK2's velocities in loops are of first order as well.
    EXPECT_NEAR(world.joint(0).position, angle, attempts == Attempts::kSdirk2 ? 2e-3 : 2e-2);
    EXPECT_NEAR(world.joint(1).position, -world.joint(0).position, 1e-9);
  }
}

/// Trees without laws flow to fourth order: 4e-6 of m g L n²/2 is what the formula itself drifts
/// over five seconds at 1 ms (runge_kutta.h), where a first-order step gains most of it.
TEST(Joints, AFreeChainKeepsItsEnergy) {
  World world(worldOf(test::chain(10)));
  world.step();
  const double start = world.report().energy.balance(), scale = test::kChainMass * 9.8 * test::kChainLength * 50;
  while (world.time() < 3) {
    world.step();
    ASSERT_NEAR(world.report().energy.balance(), start, 1e-5 * scale);
  }
}

/// Straight between two points, across gravity, a chain's rows along it vanish: with the force that an exact solution gives them it ran
/// away within seven steps. It sags until its pull carries it, its n - 1 inner joints at heights as i (n - i), and comes to rest.
TEST(Joints, AStraightChainBetweenTwoPointsHolds) {
  constexpr int kLinks = 4;
  constexpr double kLength = 0.1, kMass = 0.1;
  WorldDef def;
  def.settings.step = 1e-3;
  ArticulationDef chain;
  chain.name = "chain";
  for (int i = 0; i < kLinks; ++i) {
    LinkDef link;
    link.name = "link" + std::to_string(i);
    link.parent = i - 1;
    link.joint.type = JointType::kSpherical;
    link.joint.X_PJ = Pose(Vector3(i > 0 ? kLength : 0, 0, 0));
    link.inertia = {kMass, Vector3(kLength / 2, 0, 0), kMass * kLength * kLength / 12 * Matrix3::Identity()};
    chain.links.push_back(link);
  }
  def.articulations.push_back(chain);
  LoopDef loop;
  loop.name = "end";
  loop.articulation_a = 0;
  loop.link_a = kLinks - 1;
  loop.X_AF = Pose(Vector3(kLength, 0, 0));
  loop.X_BF = Pose(Vector3(kLinks * kLength, 0, 0));
  def.loops.push_back(loop);
  World world(def);
  for (int i = 0; i < 10000; ++i) {
    world.step();
    ASSERT_TRUE(world.report().finite) << i;
    ASSERT_LT(world.report().closure, 1e-6) << i;
  }
  const auto height = [&](int joint) { return world.linkPose(joint).p.z(); };
  const double middle = height(2);
  EXPECT_LT(middle, -1e-5);
  for (const int joint : {1, 3}) EXPECT_NEAR(height(joint) / middle, 3.0 / 4, 1e-3) << joint;
  EXPECT_LT(world.report().energy.kinetic, 1e-6 * kLinks * kMass * 9.81 * std::fabs(middle));
}

TEST(Joints, ALoopToAFixedBodyIsOneToTheWorld) {
  const TreeDef chain = test::chain(3);
  const Vector3 tip(test::kChainLength, 0, 0), end(3 * test::kChainLength, 0, 0);
  WorldDef def = worldOf(chain);
  def.articulations.push_back(scenes::staticBox("wall", Vector3(0.1, 0.1, 0.1), Pose(Vector3(0.4, 0.2, 0))));
  LoopDef loop;
  loop.name = "pin";
  loop.articulation_a = 1;
  loop.link_a = 0;
  loop.X_AF = Pose(Vector3(end - Vector3(0.4, 0.2, 0)));
  loop.articulation_b = 0;
  loop.link_b = 2;
  loop.X_BF = Pose(tip);
  def.loops.push_back(loop);
  World world(def);
  for (int i = 0; i < 500; ++i) {
    world.step();
    const Vector3 gap = world.linkPose(2) * tip - end;
    ASSERT_LT(gap.norm(), 1e-6);
    ASSERT_NEAR(world.report().closure, gap.norm(), 1e-12);
  }
}

TEST(Joints, CommandsThatCannotBeObeyedAreRefused) {
  World world(worldOf(lawfulChain()));
  const std::uint64_t before = world.hash();
  EXPECT_FALSE(world.setJointCommand(1, {JointDef::Drive::kPosition, std::nan(""), 0, 0}));
  EXPECT_FALSE(world.setJointCommand(0, {JointDef::Drive::kEffort, 0, 0, 1}));  // no drive
  EXPECT_FALSE(world.setJointCommand(9, {}));
  EXPECT_EQ(world.hash(), before);
}

TEST(Joints, LoopsThatCannotBeAreRefused) {
  const auto refused = [](const WorldDef& def) {
    try {
      World world(def);
    } catch (const SetupError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  WorldDef def = twoRootedFourBar(Attempts::kAll);
  EXPECT_EQ(refused(def), "");
  WorldDef missing = def;
  missing.loops[0].link_b = 7;
  EXPECT_NE(refused(missing).find("closure"), std::string::npos);
  WorldDef still = def;
  still.loops[0].articulation_a = still.loops[0].articulation_b = -1;
  EXPECT_NE(refused(still).find("never move"), std::string::npos);
  WorldDef open = def;
  open.loops[0].X_BF.p += Vector3(5, 0, 0);
  EXPECT_NE(refused(open).find("do not close"), std::string::npos);
}

}  // namespace joints_test
}  // namespace haptic
