// What a hand cannot bear is weakened in the loop: a stiff pointer rests, one within the bound keeps its bits.
#include "haptic_core/world/hand_bound.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <cmath>
#include <complex>

#include "../../scenes/touch.h"
#include "haptic_core/analysis/hand_certificate.h"
#include "haptic_core/geometry/volume/contact_moments.h"
#include "haptic_core/loop/hand.h"
#include "haptic_core/loop/haptic_loop.h"
#include "haptic_core/spidar/device_twin.h"
#include "haptic_core/spidar/spidar.h"
#include "haptic_core/spidar/wall_bound.h"

namespace haptic {
namespace hand_bound_test {

constexpr double kPeriod = 1e-3, kPress = 2, kRadius = 0.005, kSide = 0.01;  // [s], [N], [m], [m]

DeviceDef device() { return loadDevice(std::string(HAPTIC_SOURCE_DIR) + "/urdf/devices/spidar_g6x3r.yaml"); }
double bearable() {
  return largestWallStiffness(device().grip_damping + kRelaxedHandDamping, 0, kPeriod, loopDelay(kPeriod, device().delay_s));
}
double bearableCoupling() {
  const double B = device().grip_damping + kRelaxedHandDamping, filter = 1 / (2 * M_PI * SpidarSettings{}.velocity_cutoff_hz);
  return stiffestCoupling({B, B / bearable(), kPeriod, std::fabs(device().strings[0].length_per_count), filter}).stiffness;
}
double quantum() { return std::fabs(device().strings[0].length_per_count); }

WorldDef overWall(const ConvexPolyhedron& shape, double stiffness) {
  return scenes::pointerOverWall(shape, 0.015, stiffness, kPeriod);
}

/// A relaxed hand, its goal `press` of force below the pointer's touch with the wall.
struct Presser {
  Presser(const WorldDef& def, PassivityMode mode, double press = kPress, double home = 0.015, double height = kRadius,
          double slowly = 0)
      : world(def) {
    TwinSettings settings;
    settings.period = kPeriod;
    const Vector3 goal(0, 0, height - home - press / settings.hand_stiffness);
    if (slowly > 0) settings.path.keys = {{1, Vector3::Zero(), Vector3::Zero(), 0}, {1 + slowly, goal, Vector3::Zero(), 0}};
    twin = std::make_unique<DeviceTwin>(device(), settings);
    HandSettings hand;
    hand.workspace.X_WB.p = Vector3(0, 0, home);
    hand.passivity.mode = mode;
    loop.attach(spidar, 0, hand);
    spidar.calibrateAtHome();
    spidar.setForceEnabled(true);
    HandTarget target;
    target.active = slowly == 0;
    target.pose.X_BG.p = goal;
    twin->setHandTarget(target);
  }
  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const DeviceSample sample = twin->exchange(loop.drive(0));
      loop.tick(&sample, kPeriod);
    }
  }
  const HandReport& hand() const { return loop.report().hand[0]; }

  /// Travel of the grip in the last quarter of two seconds [m].
  double restlessness() {
    double low = INFINITY, high = -INFINITY;
    run(1500);
    for (int i = 0; i < 500; ++i) {
      run(1);
      low = std::min(low, twin->pose().X_BG.p.z());
      high = std::max(high, twin->pose().X_BG.p.z());
    }
    return high - low;
  }

  World world;
  Spidar spidar{device()};
  std::unique_ptr<DeviceTwin> twin;
  HapticLoop loop{world};
};

// Without any damper in the contact. K of a ball grows with the root of k, that of a flat face with k.
TEST(HandBound, WhatRangRests) {
  const HandCertificate ball = certifyHand(overWall(makeSphere(kRadius), 1e9), 0, {}, device(), kPress);
  for (const double times : {9.0, 100.0, 1e4}) {
    const WorldDef scene = overWall(makeSphere(kRadius), times * ball.bearable);
    EXPECT_GT(Presser(scene, PassivityMode::kOff).restlessness(), 100 * quantum()) << times;
    Presser bounded(scene, PassivityMode::kObserve);
    EXPECT_LT(bounded.restlessness(), 10 * quantum()) << times;
    EXPECT_LT(bounded.hand().stiffness_share, 1) << times;
    EXPECT_GT(bounded.hand().F_asked_B.force.z(), 0.5 * kPress) << times;
  }
}

TEST(HandBound, AFlatFaceGivesWhatTheHandBears) {
  const WorldDef scene = overWall(makeBox(Vector3::Constant(kSide)), 5e8);  // K = 5e4 N/m
  Presser bounded(scene, PassivityMode::kObserve, kPress, 0.015, kSide / 2);
  EXPECT_LT(bounded.restlessness(), 10 * quantum());
  const HandReport& hand = bounded.hand();
  const double K = 5e8 * kSide * kSide;
  EXPECT_NEAR(hand.stiffness, K, 1e-2 * K);  // the grip's tilt: a wedge for a slab
  EXPECT_NEAR(hand.stiffness_share, bearable() / K, 1e-2 * bearable() / K);
  const double depth = kSide / 2 - 0.015 - hand.X_BG.p.z();
  EXPECT_NEAR(hand.F_asked_B.force.z(), bearable() * depth, 0.02 * bearable() * depth);
}

TEST(HandBound, WithinTheBoundTheBitsAreTheSame) {
  const HandCertificate ball = certifyHand(overWall(makeSphere(kRadius), 1e9), 0, {}, device(), kPress);
  WorldDef scene = overWall(makeSphere(kRadius), 0.5 * ball.bearable);
  for (ArticulationDef& body : scene.articulations) {  // dampers within the bound as well: 2 N of 2 s/m, and no friction's
    ContactMaterial& material = body.links[0].collisions[0].material;
    material.dissipation = 2;
    material.mu_static = material.mu_dynamic = 0;
    material.tangential_damping = 0;
  }
  Presser free(scene, PassivityMode::kOff, kPress, 0.015, kRadius, 1.0);
  Presser bounded(scene, PassivityMode::kObserve, kPress, 0.015, kRadius, 1.0);
  for (int i = 0; i < 2500; ++i) {
    free.run(1);
    bounded.run(1);
    ASSERT_EQ(free.world.hash(), bounded.world.hash()) << "tick " << i;
    ASSERT_EQ(bounded.hand().stiffness_share, 1) << "tick " << i;
  }
  EXPECT_GT(bounded.hand().F_asked_B.force.z(), 0.5 * kPress);
}

/// A patch 1 mm deep.
ContactVolume patch(double A0, const Vector3& n) {
  ContactVolume contact;
  contact.X_AP.R = patchAxes(n);
  contact.A0 = A0;
  contact.volume = 1e-3 * A0;
  return contact;
}

// Wholly inside A0 is 0: the dampers keep their bound, on the layer's area, and no number of the law is none.
TEST(HandBound, DampersAreHeldWhereTheAreaVanishes) {
  HandBound bound;
  bound.stiffness = 1000;
  const double most = kMostDamping * kLeastLag * kPeriod * bound.stiffness;
  ContactVolume swallowed = patch(0, Vector3::UnitZ());
  swallowed.volume = 5e-7;
  swallowed.depth = 0.01;
  for (const double others : {0.0, 500.0}) {  // [N/m] that the hand meets elsewhere
    bound.met_W.bottomRightCorner<3, 3>() = others * Matrix3::Identity();
    PairLaw law;
    law.reduced_mass = 1;
    ContactMaterial& m = law.material;
    m.stiffness = m.tangential_stiffness = 1e7;
    m.damping = 1e7;
    m.dissipation = 10;
    boundLaw(bound, kPeriod, {}, Matrix3::Identity(), Vector3::Zero(), swallowed, law);
    const double area = layerArea(swallowed), own = 1e7 * area, share = own / (own + others);
    EXPECT_EQ(m.stiffness, 1e7);
    EXPECT_DOUBLE_EQ(m.dissipation * m.stiffness * swallowed.volume, share * most);
    EXPECT_DOUBLE_EQ(m.damping * area, share * most);
    EXPECT_DOUBLE_EQ(tangentialDamping(law, area) * area, share * most);
  }
}

// Each damper on its own, in a contact whose spring is within the bound: at most ⅔ τ K_max, τ at least 1.5 h.
TEST(HandBound, DampersAreHeldToo) {
  for (const auto& [times, lag] : {std::pair(0.5, 0.0), std::pair(5.0, 0.0), std::pair(5.0, 4 * kPeriod)}) {
    HandBound bound;
    bound.stiffness = 1000;
    bound.lag = lag;
    const double A0 = 1e-4, most = kMostDamping * std::max(lag, 1.5 * kPeriod) * bound.stiffness;
    PairLaw law;
    law.reduced_mass = 1;
    ContactMaterial& m = law.material;
    m.stiffness = m.tangential_stiffness = 500 / A0;
    m.damping = times * most / A0;
    m.dissipation = times * most / (m.stiffness * 1e-3 * A0);
    boundLaw(bound, kPeriod, {}, Matrix3::Identity(), Vector3::Zero(), patch(A0, Vector3::UnitZ()), law);
    EXPECT_EQ(m.stiffness, 500 / A0);
    EXPECT_DOUBLE_EQ(m.damping * A0, std::min(times, 1.0) * most);
    EXPECT_DOUBLE_EQ(m.dissipation * m.stiffness * 1e-3 * A0, std::min(times, 1.0) * most);
    EXPECT_DOUBLE_EQ(m.tangential_damping * A0, most);  // critical for a kilogram: 45 N·s/m
  }
}

// A firm press on a wall of the default's damping and friction, its stiffness within the bound.
TEST(HandBound, AFirmPressOnADampedWallRests) {
  WorldDef scene = overWall(makeSphere(kRadius), 5e7);
  for (ArticulationDef& body : scene.articulations) body.links[0].collisions[0].material.dissipation = 10;
  EXPECT_GT(Presser(scene, PassivityMode::kOff, 6).restlessness(), 30 * quantum());
  EXPECT_LT(Presser(scene, PassivityMode::kObserve, 6).restlessness(), 10 * quantum());
}

// A wall of K_max and a damper of the greatest size, felt τ late and the damper through a filter of the velocity, give no more than the
// hand's K_max τ takes, at any frequency: power of a motion of frequency ω over its (ω x)²/2. τ is the hold's half period and a whole one.
TEST(HandBound, SpringAndDamperTogetherArePassive) {
  const double K = 1000, delay = 1.5 * kPeriod, b = kMostDamping * delay * K;
  double worst = 0;
  for (const double filter : {0.0, 1e-4, 1e-3, 2e-3, 5e-3, 2e-2}) {  // [s]
    for (double phase = 5e-3; phase < 100; phase += 5e-3) {
      const double omega = phase / delay;
      const std::complex<double> late = std::polar(1.0, -phase), i_omega(0, omega);
      const std::complex<double> force = (K + b * i_omega / (1.0 + filter * i_omega)) * late;  // over x
      const double given = -force.imag() / omega;                                                // as a negative damper [N·s/m]
      worst = std::max(worst, given / (K * delay));
    }
  }
  EXPECT_LE(worst, 1);
  EXPECT_GT(worst, 0.98);  // more would be too much
}

// What a contact beside the origin opposes to way and turn together: the largest eigenvalue of its stiffness over the hand's damping,
// diag(ρ², 1) of it, is at most K_max; along the normal and across it.
TEST(HandBound, APushBesideTheOriginIsBoundedByItsLever) {
  HandBound bound;
  bound.stiffness = 1000;
  const double A0 = 1e-4;
  const Vector3 n = Vector3(1, 2, -1).normalized();
  for (const Vector3& arm : {Vector3(0, 0, 0), Vector3(0.01, 0.005, 0), Vector3(0.05, -0.2, 0.1), Vector3(0.03 * n)}) {
    PairLaw law;
    ContactMaterial& m = law.material;
    m.stiffness = m.tangential_stiffness = m.damping = 1e9;
    m.dissipation = m.tangential_damping = 0;
    boundLaw(bound, kPeriod, {}, Matrix3::Identity(), arm, patch(A0, n), law);
    const auto met = [&](const Matrix3& K) {
      Eigen::Matrix<double, 3, 6> J;
      J << -crossMatrix(arm) / std::sqrt(bound.turn_of_way), Matrix3::Identity();
      const Matrix6 all = J.transpose() * K * J;
      return Eigen::SelfAdjointEigenSolver<Matrix6>(all).eigenvalues()[5];
    };
    const Matrix3 along = n * n.transpose(), across = Matrix3::Identity() - along;
    EXPECT_NEAR(met(m.stiffness * A0 * along), bound.stiffness, 1e-9 * bound.stiffness);
    EXPECT_NEAR(met(m.damping * A0 * along), kMostDamping * kLeastLag * kPeriod * bound.stiffness, 1e-9);
    EXPECT_LE(met(m.tangential_stiffness * A0 * across), bound.stiffness * (1 + 1e-9));
    EXPECT_GT(met(m.tangential_stiffness * A0 * across), 0.4 * bound.stiffness / (1 + arm.squaredNorm() / bound.turn_of_way));
  }
}

// Feet in a circle of radius a ρ: each turns the hand as its neighbours do. N of them oppose N s k A0 to a way and ½ N a² s k A0 to a turn,
// and s is K_max (1 + a²)/(N + ½ N a⁴): at most (1 + √3)/2 K_max, at a² = √3 - 1. A foot that took its neighbours for pushes through the
// origin would leave 3 K_max.
TEST(HandBound, FeetInACircleTurnTheHandTogether) {
  HandBound bound;
  bound.stiffness = 1000;
  constexpr double kA0 = 1e-4, k = 1e9;
  constexpr int kFeet = 8;
  const double rho = std::sqrt(bound.turn_of_way);
  for (const double radius : {0.1 * rho, rho, 2 * rho, 5 * rho}) {
    std::vector<Vector3> arms;
    std::vector<Vector6> J(kFeet);
    bound.met_W.setZero();
    for (int i = 0; i < kFeet; ++i) {
      arms.push_back(rotationFromVector(2 * M_PI * i / kFeet * Vector3::UnitZ()) * Vector3(radius, 0, -0.02));
      J[i] << arms[i].cross(Vector3::UnitZ()) / rho, Vector3::UnitZ();
      bound.met_W += k * kA0 * J[i] * J[i].transpose();
    }
    FrictionMemory before;
    before.touching = 1, before.area = kA0, before.normal_A = Vector3::UnitZ();
    Matrix6 springs = Matrix6::Zero(), dampers = Matrix6::Zero();
    for (int i = 0; i < kFeet; ++i) {
      PairLaw law;
      ContactMaterial& m = law.material;
      m.stiffness = m.damping = k;
      m.tangential_stiffness = m.tangential_damping = m.dissipation = 0;
      boundLaw(bound, kPeriod, before, Matrix3::Identity(), arms[i], patch(kA0, Vector3::UnitZ()), law);
      springs += m.stiffness * kA0 * J[i] * J[i].transpose();
      dampers += m.damping * kA0 * J[i] * J[i].transpose();
    }
    const auto most = [](const Matrix6& M) { return Eigen::SelfAdjointEigenSolver<Matrix6>(M).eigenvalues()[5]; };
    const double most_damping = kMostDamping * kLeastLag * kPeriod * bound.stiffness;
    const double a2 = radius * radius / bound.turn_of_way;
    const double expected = std::max(1.0, 0.5 * a2) * (1 + a2) / (1 + 0.5 * a2 * a2);
    EXPECT_NEAR(most(springs), expected * bound.stiffness, 1e-9 * bound.stiffness) << radius;
    EXPECT_NEAR(most(dampers), expected * most_damping, 1e-9 * most_damping) << radius;
  }
}

// The law itself: continuous where the bound begins to hold, and K_max times the mean thickness beyond.
TEST(HandBound, ALawIsWeakenedToTheBoundAndNotBeyond) {
  HandBound bound;
  bound.stiffness = 1000;
  const double A0 = 1e-4;
  ContactVolume contact = patch(A0, Vector3::UnitZ());
  for (const double times : {0.5, 1 - 1e-12, 1 + 1e-12, 2.0, 1e6}) {
    PairLaw law;
    law.material.stiffness = times * bound.stiffness / A0;
    law.material.tangential_stiffness = 0.6 * law.material.stiffness;
    law.material.dissipation = 0;
    const double given = law.material.stiffness;
    law.material.damping = 1e-3 * given;
    law.material.tangential_damping = 0.5e-3 * given;
    boundLaw(bound, kPeriod, {}, Matrix3::Identity(), Vector3::Zero(), contact, law);
    EXPECT_NEAR(law.material.stiffness * A0, std::min(times, 1.0) * bound.stiffness, 1e-10 * bound.stiffness);
    EXPECT_DOUBLE_EQ(law.material.tangential_stiffness, 0.6 * law.material.stiffness);
    EXPECT_DOUBLE_EQ(law.material.damping, 1e-3 * law.material.stiffness);
    EXPECT_DOUBLE_EQ(law.material.tangential_damping, 0.5e-3 * law.material.stiffness);
    if (times < 1) { EXPECT_EQ(law.material.stiffness, given); }
  }
  // Two contacts share a direction, two others do not.
  for (const double angle : {0.0, M_PI / 2}) {
    bound.met_W = Vector6::Unit(3) * Vector6::Unit(3).transpose() * 1000;  // another contact's, along x
    PairLaw law;
    law.material.stiffness = 1000 / A0;
    law.material.tangential_stiffness = law.material.tangential_damping = law.material.damping = law.material.dissipation = 0;
    contact = patch(A0, Vector3(std::cos(angle), std::sin(angle), 0));
    boundLaw(bound, kPeriod, {}, Matrix3::Identity(), Vector3::Zero(), contact, law);
    EXPECT_NEAR(law.material.stiffness * A0, angle == 0 ? 500 : 1000, 1e-9);
  }
}

// A ball that sticks to two walls of a corner: along the edge both rub, and the hand meets K_max at most.
TEST(HandBound, FrictionsInACornerAreBoundedTogether) {
  WorldDef def = overWall(makeSphere(kRadius), 1e9);
  def.settings.default_material.mu_static = def.settings.default_material.mu_dynamic = 1;
  def.articulations.push_back(scenes::springyBody("side", makeBox({1, 0.1, 1}), JointType::kFixed, {0, -0.05, 0.5}, 1e9));
  World world(def);
  constexpr double kBound = 4000, kDeep = 1e-3, kAside = 1e-5;  // [N/m], [m], [m]
  world.setPointerBound(0, {kBound});
  const auto hold = [&](double x, double y, double z, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      world.setPointerTarget(0, Pose(Vector3(x, y, z)), Twist{});
      world.step();
    }
    return world.pointerWrench(0).force;
  };
  for (int i = 0; i <= 100; ++i) hold(0, kRadius + kDeep * (1 - i / 50.0), kRadius + kDeep * (1 - i / 50.0), 1);
  const Vector3 before = hold(0, kRadius - kDeep, kRadius - kDeep, 100);
  const Vector3 after = hold(kAside, kRadius - kDeep, kRadius - kDeep, 100);
  EXPECT_GT(before.z(), 0.5 * kBound * kDeep / 2);  // it touches both
  EXPECT_GT(before.y(), 0.5 * kBound * kDeep / 2);
  const double stiffness = (before.x() - after.x()) / kAside;
  EXPECT_LE(stiffness, kBound * (1 + 1e-3));  // the areas of the step before, and the ball's facets
  EXPECT_GT(stiffness, 0.9 * kBound);
}

// Work of a hand that presses a ball in and takes it out again: the bounded spring gives back what it took, whatever the
// speed of the way in and out. Error: the trapezoidal rule's, of second order.
TEST(HandBound, ABoundedSpringGivesBackWhatItTook) {
  double last = 0;
  for (const double step : {1e-3, 5e-4}) {
    WorldDef def = overWall(makeSphere(kRadius), 1e10);
    def.settings.step = step;
    World world(def);
    world.setPointerBound(0, {4000});
    const int in = static_cast<int>(std::lround(0.1 / step)), out = 3 * in;
    double most = 0;
    for (int i = 0; i <= in + out; ++i) {
      const double share = i <= in ? double(i) / in : 1 - double(i - in) / out, way = 0.0111 * share;
      world.setPointerTarget(0, Pose(Vector3(0, 0, 0.015 - way)), Twist{});
      world.step();
      most = std::max(most, world.report().energy.external);
    }
    const double error = std::fabs(world.report().energy.external) / most;
    EXPECT_LT(error, 0.02) << step;
    if (last > 0) { EXPECT_LT(error, 0.35 * last); }
    last = error;
    EXPECT_GT(most, 0.25 * 0.5 * 4000 * 1e-3 * 1e-3);
  }
}

// A pointer on a cube on a floor: between cube and floor the scene's stiffness stays.
TEST(HandBound, OtherContactsKeepTheirs) {
  WorldDef scene = overWall(makeBox(Vector3::Constant(kSide)), 1e9);
  scene.articulations.push_back(scenes::springyBody("cube", makeBox(Vector3::Constant(0.02)), JointType::kFloating, {0, 0, 0.01}, 1e9));
  for (ArticulationDef& body : scene.articulations) {
    body.links[0].collisions[0].material.dissipation = 1;  // stiff bodies on stiff floors come to rest by their own damper
    if (body.name == "pointer") body.X_WA.p.z() = 0.035;
  }
  Presser bounded(scene, PassivityMode::kObserve, kPress, 0.035, 0.02 + kSide / 2);
  EXPECT_LT(bounded.restlessness(), 10 * quantum());
  EXPECT_LT(bounded.hand().stiffness_share, 0.1);
  int floor = 0, pressed = 0;
  const double damper = 3 * 1.0 * quantum() / kPeriod;  // c ḋ, where a few counts change within a tick
  for (int i = 0; i < bounded.world.contactCount(); ++i) {
    const ContactReport& c = bounded.world.contact(i);
    const bool by_hand = c.link_a == bounded.world.pointerLink(0) || c.link_b == bounded.world.pointerLink(0);
    const double k = c.normal_force / c.volume;
    EXPECT_NEAR(k, by_hand ? bearable() / c.area : 1e9, damper * k);
    ++(by_hand ? pressed : floor);
  }
  EXPECT_EQ(floor, 1);
  EXPECT_EQ(pressed, 1);
}

// The bound is in no memory: a loop that goes on from one, in the middle of a weakened press, computes the same bits.
TEST(HandBound, GoesOnFromAMemory) {
  const WorldDef scene = overWall(makeSphere(kRadius), 1e11);
  Presser first(scene, PassivityMode::kObserve), second(scene, PassivityMode::kObserve);
  first.run(1000);
  second.run(1);  // its device is asked to calibrate
  std::vector<double> memory;
  first.loop.hand(0).save(memory);
  second.loop.hand(0).restore(memory);
  second.spidar.restore(first.spidar.save());
  second.world.restore(first.world.save());
  for (int i = 0; i < 500; ++i) {
    const DeviceSample sample = first.twin->exchange(first.loop.drive(0));
    for (Presser* each : {&first, &second}) each->loop.tick(&sample, kPeriod);
    ASSERT_EQ(first.world.hash(), second.world.hash()) << "tick " << i;
    ASSERT_EQ(first.hand().F_asked_B.force, second.hand().F_asked_B.force) << "tick " << i;
  }
  EXPECT_LT(second.hand().stiffness_share, 0.5);
}

// A coupling stiffer than the hand bears rings in the air already; bounded it rests there and on a wall, light or heavy.
TEST(HandBound, AVirtualCouplingYields) {
  for (const double mass : {0.05, 0.3, 0.5, 0.7, 0.9, 1.0, 1.1, 2.0, 3.0}) {
    WorldDef scene = overWall(makeBox(Vector3::Constant(kSide)), 1e8);
    scene.settings.gravity.setZero();
    for (ArticulationDef& body : scene.articulations) body.links[0].collisions[0].material.dissipation = 10;
    LinkDef& link = scene.articulations[1].links[0];
    link.inertia.mass = mass;
    link.inertia.I_C = 1e-3 * mass * Matrix3::Identity();
    scene.pointers[0].coupling.mode = PointerCoupling::Mode::kVirtual;
    scene.pointers[0].coupling.stiffness = mass * (0.236 / kPeriod) * (0.236 / kPeriod);
    if (mass >= 1) { EXPECT_GT(Presser(scene, PassivityMode::kOff, kPress, 0.015, kSide / 2).restlessness(), 20 * quantum()); }
    Presser bounded(scene, PassivityMode::kObserve, kPress, 0.015, kSide / 2);
    EXPECT_LT(bounded.restlessness(), 10 * quantum()) << mass << " kg";
    EXPECT_DOUBLE_EQ(bounded.hand().stiffness, scene.pointers[0].coupling.stiffness);
    EXPECT_NEAR(bounded.hand().stiffness_share, std::min(1.0, bearableCoupling() / scene.pointers[0].coupling.stiffness), 1e-12);
    scene.pointers[0].coupling.stiffness = PointerCoupling::kDerived;  // as stiff as the hand bears, whatever the tool's mass
    Presser derived(scene, PassivityMode::kObserve, kPress, 0.015, kSide / 2);
    EXPECT_LT(derived.restlessness(), 10 * quantum()) << mass << " kg";
    EXPECT_NEAR(derived.hand().stiffness, bearableCoupling(), 1e-9 * bearableCoupling());
    EXPECT_EQ(derived.hand().stiffness_share, 1);
  }
}

}  // namespace hand_bound_test
}  // namespace haptic
