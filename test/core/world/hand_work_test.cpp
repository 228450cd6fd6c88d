/// What a hand that leads a link puts in is what arrives: in motion, in springs, as heat.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../../scenes/blocks.h"

namespace haptic {
namespace hand_work_test {

using namespace scenes;

constexpr double kEdge = 0.05, kMass = 0.2, kFoundation = 1e6;  // [m], [kg], [N/m³]

WorldDef withHand(Attempts attempts, const ArticulationDef& body, const Vector3& hand_at) {
  WorldDef def;
  def.settings.attempts = attempts;
  def.settings.gravity = Vector3::Zero();
  ContactMaterial& m = def.settings.default_material;
  m.stiffness = kFoundation;
  m.dissipation = 2;
  m.mu_static = m.mu_dynamic = 0.5;
  def.articulations.push_back(body);
  def.articulations.push_back(freeBox("hand", Vector3::Constant(kEdge), 0.1, Pose(hand_at)));
  PointerDef pointer;
  pointer.articulation = 1;
  pointer.link = 0;
  def.pointers.push_back(pointer);
  return def;
}

/// A plate on a rail along x with a damper: a joint with a law of its own.
ArticulationDef plateOnRail() {
  ArticulationDef plate = freeBox("plate", Vector3(0.3, 0.1, 0.02), kMass, Pose(Vector3(0, 0, -0.01)));
  JointDef& joint = plate.links[0].joint;
  joint.type = JointType::kPrismatic;
  joint.axis = Vector3::UnitX();
  joint.damping = 0.5;
  return plate;
}

/// Energy that nobody put in, and what the books lack, both at their worst since the first step [J].
class Books {
 public:
  void look(const EnergyLedger& e) {
    if (!started_) first_ = e;
    started_ = true;
    const double external = e.external - first_.external,
                 taken = e.damping + e.friction - first_.damping - first_.friction;
    gain = std::max(gain, e.total() - first_.total() + taken - external);
    lack = std::max(lack, std::abs(e.balance() - first_.balance()));
    exchanged = std::max({exchanged, e.kinetic, e.elastic, std::abs(external), taken});
  }
  double gain = 0, lack = 0, exchanged = 0;

 private:
  EnergyLedger first_;
  bool started_ = false;
};

class HandWork : public testing::TestWithParam<Attempts> {
 protected:
  /// What the scheme itself makes of the energy of a spring, as a share: (hω)²/4 to second order. Implicit Euler makes none.
  static double made(double h, double stiffness) {
    const double omega = h * std::sqrt(stiffness / kMass);
    return omega * omega / 4;
  }
};

/// A hand meets a body that floats, at a constant velocity U aslant to the face, so that it also rubs.
/// Whatever the contact does, its impulse is the body's momentum p, and U·p is what the hand has put in. The
/// body is thrown off.
TEST_P(HandWork, OfAConstantVelocityIsItTimesTheMomentumGiven) {
  const Vector3 U(0.3, 0.05, 0.02);
  const ArticulationDef body =
      freeBox("body", Vector3::Constant(kEdge), kMass, Pose(Vector3(kEdge + 0.01, 0.003, 0.002)));
  World world(withHand(GetParam(), body, Vector3::Zero()));
  const double h = world.settings().step;
  world.setPointerTarget(0, Pose(), Twist{});
  world.step();
  Books seen;
  int touched = 0;
  for (int i = 1; i <= 300; ++i) {
    world.setPointerTarget(0, Pose(U * (i * h)), {Vector3::Zero(), U});
    world.step();
    const EnergyLedger& e = world.report().energy;
    seen.look(e);
    touched += world.report().contacts > 0;
    const double given = U.dot(kMass * world.linkTwist(0).linear);
    ASSERT_NEAR(e.external, given, 1e-12 * kMass * U.squaredNorm())
        << i;  // rounding: of h in the way, some 1e3 of it
  }
  EXPECT_GT(touched, 10);
  EXPECT_EQ(world.report().contacts, 0);
  EXPECT_GT(seen.exchanged, kMass * U.x() * U.x());  // thrown off at more than the hand's speed
  EXPECT_LT(seen.gain, made(h, kFoundation * kEdge * kEdge) * seen.exchanged);
}

/// A hand that stands 1 mm deep in a plate on a rail drags it to and fro, and turns on it, by friction that
/// sticks. Between two springs and two dampers, one of them the joint's, nothing comes from nowhere: neither
/// by what the hand does, which is booked by the step's mean wrench, nor by the joint, at which an explicit
/// step pulls with the wrench of its start.
TEST_P(HandWork, DragsWhatIsOnARail) {
  World world(withHand(GetParam(), plateOnRail(), Vector3(0, 0, kEdge / 2 + 1e-3)));
  const double h = world.settings().step;
  Books seen;
  double farthest = 0;
  for (int i = 1; i <= 2000; ++i) {
    constexpr double kOmega = 12, kWay = 0.02, kTurn = 0.004;  // [rad/s], [m], [rad]
    const double t = i * h, down = 2e-3 * std::min(1.0, t / 0.1), phase = kOmega * std::max(0.0, t - 0.2);
    const double share = 1 - std::cos(phase), rate = kOmega * std::sin(phase);
    const Pose X(rotationFromVector(Vector3(0, 0, kTurn * share)).toRotationMatrix(),
                 Vector3(kWay * share, 0, kEdge / 2 + 1e-3 - down));
    world.setPointerTarget(0, X, {Vector3(0, 0, kTurn * rate), Vector3(kWay * rate, 0, t < 0.1 ? -0.02 : 0)});
    world.step();
    if (t < 0.15) continue;
    ASSERT_TRUE(world.contact(0).sticking) << t;
    seen.look(world.report().energy);
    farthest = std::max(farthest, world.linkPose(0).p.x());
  }
  EXPECT_GT(farthest, 0.03);
  EXPECT_GT(seen.exchanged, 0.02);
  EXPECT_LT(seen.gain,
            made(h, DefaultMaterial::kTangentialRatio * kFoundation * kEdge * kEdge) * seen.exchanged);
}

/// Two hands press a body from both sides, n steps of a constant way to the depth δ: it stays where it is,
/// and each puts ½ k A δ² into its contact. Booked by the force at the steps' ends that is
/// δ/n more: 1/n of it.
TEST_P(HandWork, PressesWhatStandsBetweenTwo) {
  constexpr int kSteps = 100;
  constexpr double kDepth = 1e-3, kAway = kEdge + 1e-9;
  WorldDef def =
      withHand(GetParam(), freeBox("body", Vector3::Constant(kEdge), kMass, Pose()), Vector3(kAway, 0, 0));
  def.settings.default_material.dissipation = 0;
  def.articulations.push_back(freeBox("other", Vector3::Constant(kEdge), 0.1, Pose(Vector3(-kAway, 0, 0))));
  def.pointers.push_back(def.pointers[0]);
  def.pointers[1].articulation = 2;
  def.pointers[1].device = "other";
  World world(def);
  for (int i = 1; i <= kSteps + 50; ++i) {
    const double way = kDepth * std::min(1.0, double(i) / kSteps),
                 speed = i < kSteps ? 1e3 * kDepth / kSteps : 0;
    world.setPointerTarget(0, Pose(Vector3(kAway - way, 0, 0)), {Vector3::Zero(), Vector3(-speed, 0, 0)});
    world.setPointerTarget(1, Pose(Vector3(way - kAway, 0, 0)), {Vector3::Zero(), Vector3(speed, 0, 0)});
    world.step();
  }
  const double stored = 2 * 0.5 * kFoundation * kEdge * kEdge * kDepth * kDepth;
  EXPECT_NEAR(world.report().energy.external, stored, 1.1 / kSteps * stored);
  EXPECT_LT(world.linkPose(0).p.norm(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Methods, HandWork,
                         testing::Values(Attempts::kImplicitEuler, Attempts::kSdirk2,
                                         Attempts::kAll));

}  // namespace hand_work_test
}  // namespace haptic
