// Sensors against statics, closed forms, inverse dynamics, Newton's law of each link, and a joint that is not merged.
#include "haptic_core/world/sensors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "../../comparators/velocity_verlet.h"
#include "../../scenes/blocks.h"
#include "../dynamics/chain.h"
#include "../dynamics/four_bar.h"
#include "../dynamics/random_tree.h"
#include "haptic_core/base/error.h"
#include "haptic_core/dynamics/joint_space_inertia.h"
#include "haptic_core/world/state.h"
#include "haptic_core/world/work.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace sensors_test {

constexpr double kEps = std::numeric_limits<double>::epsilon();

ArticulationDef articulationOf(const TreeDef& tree) {
  ArticulationDef def;
  def.name = tree.name;
  def.X_WA = tree.X_WA;
  for (const BodyDef& body : tree.links) {
    LinkDef link;
    static_cast<BodyDef&>(link) = body;
    def.links.push_back(link);
  }
  return def;
}

SensorDef sensorOn(SensorDef::Kind kind, const std::string& name, int articulation, int link, const Pose& X_LS = {}) {
  SensorDef def;
  def.kind = kind;
  def.name = def.frame = name;
  def.articulation = articulation;
  def.link = link;
  def.X_LS = X_LS;
  return def;
}

SensorDef wrenchOf(int articulation, int link, const Pose& X_LS = {}) {
  return sensorOn(SensorDef::Kind::kWrench, "joint" + std::to_string(link), articulation, link, X_LS);
}

/// A sample's wrench in W's axes, about S.
Wrench inWorld(const World& world, int sensor) {
  const SensorDef& def = world.sensor(sensor);
  const Pose X_WS = world.linkPose(world.model().link(def.articulation, def.link)) * def.X_LS;
  return world.sensorReading(sensor).F_S.rotated(X_WS.R);
}

Vector3 originOf(const World& world, int sensor) {
  const SensorDef& def = world.sensor(sensor);
  return (world.linkPose(world.model().link(def.articulation, def.link)) * def.X_LS).p;
}

/// A chain whose boxes collide, over a floor that its tip beats, with joint laws.
WorldDef beatingChain(Attempts attempts) {
  WorldDef def;
  def.name = "beating chain";
  def.settings.attempts = attempts;
  scenes::CubeParameters material;
  material.stiffness = 2e6;  // which explicit steps of 1 ms resolve
  def.settings.default_material = material.material();
  ArticulationDef chain = articulationOf(test::chain(4));
  chain.X_WA = Pose(Vector3(0, 0, 0.15));
  for (LinkDef& link : chain.links) {
    CollisionDef collision;
    collision.shape = scenes::box(Vector3(test::kChainLength, test::kChainWidth, test::kChainWidth));
    collision.X_LS = Pose(Vector3(test::kChainLength / 2, 0, 0));
    link.collisions.push_back(collision);
    link.joint.friction = 1e-3;
    link.joint.lower = -1.2;
    link.joint.upper = 1.2;
  }
  def.articulations = {scenes::floorBox(), chain};
  for (int l = 0; l < 4; ++l) def.sensors.push_back(wrenchOf(1, l));
  for (int l = 0; l < 4; ++l) def.sensors.push_back(sensorOn(SensorDef::Kind::kContact, "contact" + std::to_string(l), 1, l));
  return def;
}

class SensorsByIntegrator : public testing::TestWithParam<Attempts> {};
INSTANTIATE_TEST_SUITE_P(All, SensorsByIntegrator,
                         testing::Values(Attempts::kImplicitEuler,
                                         Attempts::kSdirk2, Attempts::kAll));

/// Two arms welded to one another and to the world: what stands needs its weight and its moment, and no more.
TEST(Sensors, StaticsOfAnArm) {
  WorldDef def;
  def.name = "arm";
  TreeDef tree = test::chain(2);
  tree.X_WA = Pose(rotationAbout(Vector3(1, 2, 3).normalized(), 0.7), Vector3(1, -2, 3));
  for (BodyDef& body : tree.links) body.joint.type = JointType::kFixed;
  def.articulations.push_back(articulationOf(tree));
  def.sensors = {wrenchOf(0, 0), wrenchOf(0, 1)};
  World world(def);
  EXPECT_EQ(world.sensorReading(0).step, 0u);
  EXPECT_TRUE(std::isnan(world.sensorReading(0).F_S.force.x()));
  world.step();
  for (int s = 0; s < 2; ++s) {
    const int links = 2 - s;
    const Vector3 weight = -links * test::kChainMass * def.settings.gravity;
    const Vector3 arm = tree.X_WA.R * Vector3(0.5 * links * test::kChainLength, 0, 0);
    const Wrench F = inWorld(world, s);
    EXPECT_LT((F.force - weight).norm(), 10 * kEps * weight.norm());
    EXPECT_LT((F.torque - arm.cross(weight)).norm(), 10 * kEps * weight.norm());
  }
}

/// Newton and Euler of each link: what goes through its joint, less what it passes on, with contacts and weight, is the change of its
/// momentum, in every step, impacts included.
TEST_P(SensorsByIntegrator, WrenchesOnALinkChangeItsMomentum) {
  const WorldDef def = beatingChain(GetParam());
  World world(def);
  const double h = def.settings.step;
  const Vector3 g = def.settings.gravity;
  const Matrix3 I_C = def.articulations[1].links[0].inertia.I_C;
  int touched = 0;
  for (int step = 0; step < 600; ++step) {
    std::vector<Pose> X_0;
    std::vector<Twist> V_0;
    for (int l = 1; l <= 4; ++l) X_0.push_back(world.linkPose(l)), V_0.push_back(world.linkTwist(l));
    world.step();
    ASSERT_TRUE(world.report().finite);
    touched += world.contactCount() > 0;
    for (int l = 0; l < 4; ++l) {
      const Vector3 a = originOf(world, l), p_LC(test::kChainLength / 2, 0, 0);
      const auto momentum = [&](const Pose& X, const Twist& V, Vector3& lever) {
        const Vector3 r = X.R * p_LC, p = test::kChainMass * (V.linear + V.angular.cross(r));
        lever = X.p + r - a;
        return Wrench{X.R * I_C * X.R.transpose() * V.angular + lever.cross(p), p};
      };
      Vector3 lever_0, lever_1;
      const Wrench before = momentum(X_0[l], V_0[l], lever_0), after = momentum(world.linkPose(l + 1), world.linkTwist(l + 1), lever_1);
      const Vector3 weight = test::kChainMass * g;
      Wrench sum = inWorld(world, l) + inWorld(world, 4 + l) + Wrench{(0.5 * (lever_0 + lever_1)).cross(weight), weight};
      if (l < 3) sum += -inWorld(world, l + 1).shifted(a - originOf(world, l + 1));
      const Wrench change = (after - before) * (1 / h);
      // Momenta of both ends over h and the wrenches that are summed, each to some roundings.
      const double passed = l < 3 ? inWorld(world, l + 1).force.norm() : 0;
      const double scale = (before.force.norm() + after.force.norm()) / h + inWorld(world, l).force.norm() +
                           inWorld(world, 4 + l).force.norm() + passed + weight.norm();
      ASSERT_LT((sum.force - change.force).norm(), 50 * kEps * scale) << "step " << step << " link " << l;
      ASSERT_LT((sum.torque - change.torque).norm(), 50 * kEps * scale) << "step " << step << " link " << l;
    }
  }
  EXPECT_GT(touched, 50);
}

/// The force along a joint's axes is that of inverse dynamics in the middle of the step: an error of order h².
TEST(Sensors, InverseDynamicsInTheMiddleOfTheStep) {
  test::Random random(7);
  TreeDef tree = test::randomTree(random, 12, false);
  const Articulation model(tree);
  std::vector<double> q_start, v_start;
  test::randomState(random, model, q_start, v_start);
  const auto worst = [&](double h) {
    WorldDef def;
    def.name = "tree";
    def.settings.step = h;
    def.settings.comparator = comparators::velocityVerlet;
    def.articulations.push_back(articulationOf(tree));
    for (int l = 0; l < 12; ++l) def.sensors.push_back(wrenchOf(0, l));
    World world(def);
    State state = world.state();
    state.q = q_start, state.v = v_start;
    world.restore(state.pack());
    double error = 0;
    std::vector<LinkWork> work(12);
    for (int step = 0; step < std::lround(0.02 / h); ++step) {
      const State before = world.state();
      world.step();
      std::vector<double> v_mid(model.nv()), v_dot(model.nv()), q_mid = before.q, tau(model.nv());
      for (int i = 0; i < model.nv(); ++i) {
        v_mid[i] = 0.5 * (before.v[i] + world.state().v[i]);
        v_dot[i] = (world.state().v[i] - before.v[i]) / h;
      }
      integratePositions(model, q_mid.data(), v_mid.data(), h / 2);
      forwardKinematics(model, q_mid.data(), v_mid.data(), work.data());
      inverseDynamics(model, def.settings.gravity, v_dot.data(), work.data(), tau.data());
      for (int l = 0; l < 12; ++l) {
        if (model.link(l).dof != 1) continue;
        const Wrench F = inWorld(world, l).shifted(work[l].p_WO - originOf(world, l));
        const double along = work[l].S.col(0).dot(model.link(l).slides ? F.force : F.torque);
        error = std::max(error, std::abs(along - tau[model.link(l).v]));
      }
    }
    return error;
  };
  const double coarse = worst(1e-3), fine = worst(5e-4);
  EXPECT_LT(coarse, 1e-2);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.2);
}

/// A pendulum's pivot holds its centre on the circle, by its angle and rate in the middle of the step.
TEST(Sensors, PendulumPullsItsPivot) {
  const auto error = [](double h) {
    WorldDef def;
    def.name = "pendulum";
    def.settings.step = h;
    def.articulations.push_back(articulationOf(test::chain(1)));
    def.sensors = {wrenchOf(0, 0)};
    World world(def);
    const double m = test::kChainMass, r = test::kChainLength / 2, g = 9.8, I = def.articulations[0].links[0].inertia.I_C(1, 1) + m * r * r;
    double worst = 0;
    for (int i = 0; i < std::lround(0.3 / h); ++i) {
      const double q_0 = world.joint(0).position, v_0 = world.joint(0).velocity;
      world.step();
      const double q = 0.5 * (q_0 + world.joint(0).position), v = 0.5 * (v_0 + world.joint(0).velocity);
      // From rest at θ = 0 along x; θ grows downwards about y. The rod's axis and the one across it, in the middle of the step.
      const double along = -m * r * v * v - m * g * std::sin(q), alpha = m * g * r * std::cos(q) / I;
      const double across = m * g * std::cos(q) - m * r * alpha;
      const Vector3 rod(std::cos(q), 0, -std::sin(q)), normal(std::sin(q), 0, std::cos(q));
      const Vector3 F = inWorld(world, 0).force;
      worst = std::max({worst, std::abs(F.dot(rod) - along), std::abs(F.dot(normal) - across)});
    }
    return worst;
  };
  const double coarse = error(1e-3), fine = error(5e-4);
  EXPECT_LT(coarse, 1e-3);
  EXPECT_NEAR(std::log2(coarse / fine), 2, 0.15);
}

/// What a merged fixed joint carries is what the same joint carries that was kept.
TEST(Sensors, APartOfALinkIsAsALinkOfItsOwn) {
  TreeDef kept = test::chain(3);
  kept.links[1].joint.type = JointType::kFixed;
  WorldDef separate;
  separate.name = "separate";
  separate.settings.comparator = comparators::velocityVerlet;
  separate.articulations.push_back(articulationOf(kept));
  separate.sensors = {wrenchOf(0, 1)};
  // Links 0 and 1 in one, by hand; link 2 hangs on the part.
  WorldDef merged = separate;
  std::vector<LinkDef>& links = merged.articulations[0].links;
  const Pose X_01 = links[1].joint.X_PJ;
  SensorDef sensor = wrenchOf(0, 0, X_01);
  sensor.on_part = true;
  sensor.part.inertia = links[1].inertia;
  sensor.part.inertia.p_LC = X_01 * links[1].inertia.p_LC;
  sensor.part.children = {1};
  const double m = test::kChainMass, L = test::kChainLength;
  LinkInertia both;
  both.mass = 2 * m;
  both.p_LC = Vector3(L, 0, 0);
  both.I_C = 2 * links[0].inertia.I_C;
  both.I_C(1, 1) += 2 * m * L * L / 4, both.I_C(2, 2) += 2 * m * L * L / 4;
  links[0].inertia = both;
  links.erase(links.begin() + 1);
  links[1].parent = 0;
  links[1].joint.X_PJ = X_01 * links[1].joint.X_PJ;
  merged.sensors = {sensor};
  World a(separate), b(merged);
  for (int i = 0; i < 200; ++i) {
    a.step(), b.step();
    const Wrench F = a.sensorReading(0).F_S, G = b.sensorReading(0).F_S;
    // Both motions are the same but for rounding, which 200 steps add up, over h.
    ASSERT_LT((F.force - G.force).norm(), 200 * 10 * kEps / separate.settings.step) << i;
    ASSERT_LT((F.torque - G.torque).norm(), 200 * 10 * kEps / separate.settings.step) << i;
  }
}

/// A cube over the edge of two floors: each carries its share, both the weight.
TEST(Sensors, ContactsOfALinkAndOfAPair) {
  scenes::CubeParameters c;
  WorldDef def = scenes::cubeOnFloor(c, {});
  def.articulations[0] = scenes::staticBox("left", Vector3(1, 1, 0.5), Pose(Vector3(-0.53, 0, -0.25)));
  def.articulations.insert(def.articulations.begin() + 1, scenes::staticBox("right", Vector3(1, 1, 0.5), Pose(Vector3(0.47, 0, -0.25))));
  def.sensors = {sensorOn(SensorDef::Kind::kContact, "all", 2, 0), sensorOn(SensorDef::Kind::kContact, "left", 2, 0),
                 sensorOn(SensorDef::Kind::kContact, "floor", 0, 0)};
  def.sensors[1].with_articulation = 0;
  def.sensors[1].with_link = 0;
  World world(def);
  for (int i = 0; i < 2000; ++i) world.step();
  const double weight = c.mass * scenes::kGravity;
  const Vector3 all = inWorld(world, 0).force, left = inWorld(world, 1).force, floor = inWorld(world, 2).force;
  EXPECT_NEAR(all.z(), weight, 1e-9 * weight);  // at rest to the solve's end
  EXPECT_NEAR(left.z(), 0.2 * weight, 1e-3 * weight);  // 20 mm of 100, tilted by less than the depth
  EXPECT_LT((left + floor).norm(), 10 * kEps * weight);
  // About the centre of a cube at rest the contacts have no moment.
  EXPECT_LT(inWorld(world, 0).torque.norm(), 1e-9 * weight * c.size);
}

TEST(Sensors, InertialUnitIntegratesToTheMotion) {
  WorldDef def;
  def.name = "thrown";
  Twist V;
  V.angular = Vector3(3, -2, 5);
  V.linear = Vector3(1, 2, 3);
  const Pose X_LS(rotationAbout(Vector3::UnitY(), 0.4), Vector3(0.03, 0.02, -0.05));
  def.articulations.push_back(scenes::freeBox("body", Vector3(0.1, 0.2, 0.3), 1, Pose(), V));
  def.sensors = {sensorOn(SensorDef::Kind::kImu, "imu", 0, 0, X_LS), sensorOn(SensorDef::Kind::kImu, "centre", 0, 0)};
  World world(def);
  for (int i = 0; i < 100; ++i) {
    const Vector3 v_0 = world.linkTwist(0).shifted(world.linkPose(0).R * X_LS.p).linear;
    world.step();
    const SensorReading& imu = world.sensorReading(0);
    const Matrix3 R = world.linkPose(0).R * X_LS.R;
    const Vector3 v_1 = world.linkTwist(0).shifted(world.linkPose(0).R * X_LS.p).linear;
    EXPECT_LT((imu.q_WS.toRotationMatrix() - R).norm(), 20 * kEps);
    EXPECT_LT((R * imu.omega_S - world.linkTwist(0).angular).norm(), 20 * kEps * 10);
    EXPECT_LT((v_0 + def.settings.step * (R * imu.specific_force_S + def.settings.gravity) - v_1).norm(), 50 * kEps * 10);
    // In free fall the centre feels nothing: its speed of some m/s, to rounding, over h.
    EXPECT_LT(world.sensorReading(1).specific_force_S.norm(), 20 * kEps * 10 / def.settings.step);
  }
}

TEST(Sensors, NoiseIsGaussianSeededAndOfNoState) {
  WorldDef def = scenes::cubeOnFloor({}, {});
  WorldDef quiet = def;
  def.sensors = {sensorOn(SensorDef::Kind::kContact, "a", 1, 0), sensorOn(SensorDef::Kind::kContact, "b", 1, 0),
                 sensorOn(SensorDef::Kind::kContact, "true", 1, 0)};
  for (int s = 0; s < 2; ++s) def.sensors[s].noise_force = 0.5, def.sensors[s].noise_torque = 0.02;
  World world(def), bare(quiet);
  constexpr int kSteps = 20000;
  double sum = 0, squares = 0, fourth = 0, lagged = 0, between = 0, last = 0;
  std::vector<double> kept;
  std::vector<Vector3> seen;
  for (int i = 0; i < kSteps; ++i) {
    if (i == 100) kept = world.save();
    world.step(), bare.step();
    const Vector3 truth = world.sensorReading(2).F_S.force;
    const double a = (world.sensorReading(0).F_S.force - truth).x() / 0.5, b = (world.sensorReading(1).F_S.force - truth).x() / 0.5;
    sum += a, squares += a * a, fourth += a * a * a * a, lagged += a * last, between += a * b;
    last = a;
    if (i >= 100 && i < 110) seen.push_back(world.sensorReading(0).F_S.torque);
  }
  // Five standard deviations of each estimate, of a normal distribution.
  const double n = kSteps, five = 5 / std::sqrt(n);
  EXPECT_LT(std::abs(sum / n), five);
  EXPECT_LT(std::abs(squares / n - 1), five * std::sqrt(2.0));
  EXPECT_LT(std::abs(fourth / n - 3), five * std::sqrt(96.0));
  EXPECT_LT(std::abs(lagged / n), five);
  EXPECT_LT(std::abs(between / n), five);
  EXPECT_EQ(world.hash(), bare.hash()) << "sensors move nothing";
  world.restore(kept);
  EXPECT_EQ(world.sensorReading(0).step, 0u);
  for (const Vector3& torque : seen) {
    world.step();
    EXPECT_EQ(world.sensorReading(0).F_S.torque, torque);
  }
}

TEST(Sensors, RateIsInStepsAndSamplesStay) {
  WorldDef def = beatingChain(Attempts::kAll);
  def.sensors.resize(2);
  def.sensors[1] = def.sensors[0];
  def.sensors[1].name = "slow";
  def.sensors[1].rate = 250;
  World world(def);
  for (int i = 1; i <= 100; ++i) {
    world.step();
    EXPECT_EQ(world.sensorReading(0).step, static_cast<std::uint64_t>(i));
    EXPECT_EQ(world.sensorReading(1).step, static_cast<std::uint64_t>(i / 4 * 4));
    if (i % 4 == 0) {
      EXPECT_EQ(world.sensorReading(0).F_S.vector(), world.sensorReading(1).F_S.vector());
    }
  }
}

/// A slide that a hand holds by its coupling: the bearing has what gravity and the hand leave.
TEST_P(SensorsByIntegrator, HandsThatPullCount) {
  WorldDef def;
  def.name = "slide";
  def.settings.attempts = GetParam();
  ArticulationDef slide = scenes::freeBox("slide", Vector3(0.1, 0.1, 0.1), 0.5, Pose());
  slide.links[0].joint.type = JointType::kPrismatic;
  slide.links[0].joint.axis = Vector3::UnitX();
  slide.links[0].joint.damping = 15;
  def.articulations.push_back(slide);
  PointerDef pointer;
  pointer.articulation = pointer.link = 0;
  pointer.coupling.mode = PointerCoupling::Mode::kVirtual;
  pointer.coupling.stiffness = 200;
  pointer.coupling.damping = 2;
  def.pointers.push_back(pointer);
  def.sensors = {wrenchOf(0, 0)};
  World world(def);
  for (int i = 0; i < 4000; ++i) {
    world.setPointerTarget(0, Pose(Vector3(0.02, 0.01, 0.03)), {});
    world.step();
  }
  const Vector3 pull(0, 0.01 * 200, 0.03 * 200), weight = 0.5 * def.settings.gravity;
  EXPECT_LT((inWorld(world, 0).force + pull + weight).norm(), 1e-9);  // 4 s of poles at 17/s: at rest but for the solves' ends
}

/// A slide that a wrench pushes across: the bearing has what gravity and the wrench leave, as long as it acts.
TEST_P(SensorsByIntegrator, AppliedWrenchesCount) {
  WorldDef def;
  def.name = "slide";
  def.settings.attempts = GetParam();
  ArticulationDef slide = scenes::freeBox("slide", Vector3(0.1, 0.1, 0.1), 0.5, Pose());
  slide.links[0].joint.type = JointType::kPrismatic;
  slide.links[0].joint.axis = Vector3::UnitX();
  def.articulations.push_back(slide);
  def.sensors = {wrenchOf(0, 0)};
  World world(def);
  const Vector3 p(0.02, 0.03, -0.04), push(0, 2, 5), turn(0.1, 0.2, 0.3), weight = 0.5 * def.settings.gravity;
  world.applyWrench(0, {Wrench{turn, push}, p, false}, 20 * def.settings.step);
  for (int i = 0; i < 20; ++i) world.step();
  EXPECT_LT((inWorld(world, 0).force + push + weight).norm(), 1e-12);
  EXPECT_LT((inWorld(world, 0).torque + turn + p.cross(push)).norm(), 1e-12);
  world.step();
  EXPECT_LT((inWorld(world, 0).force + weight).norm(), 1e-12);
  EXPECT_LT(inWorld(world, 0).torque.norm(), 1e-12);
}

TEST(Sensors, SayWhatIsWrong) {
  const auto refuses = [](const std::function<void(WorldDef&)>& spoil, const char* words) {
    WorldDef def = beatingChain(Attempts::kAll);
    spoil(def);
    try {
      World world(def);
      ADD_FAILURE() << words;
    } catch (const SetupError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  refuses([](WorldDef& def) { def.sensors[1].name = def.sensors[0].name; }, "is there twice");
  refuses([](WorldDef& def) { def.sensors[0].rate = -1; }, "no frequency");
  refuses([](WorldDef& def) { def.sensors[0].noise_force = -1; }, "no size");
  refuses([](WorldDef& def) { def.articulations[1].links[0].joint = {}, def.articulations[1].links[0].joint.name = "free"; }, "floats");
  refuses([](WorldDef& def) { def.sensors[0].link = 9; }, "is not there");
  refuses([](WorldDef& def) { def.sensors[5].with_articulation = 1, def.sensors[5].with_link = 7; }, "is not there");
}

}  // namespace sensors_test
}  // namespace haptic
