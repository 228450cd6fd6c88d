// Virtual couplings per axis against damped oscillators; springs at joints against statics, an oscillator and the ledger.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../../scenes/blocks.h"
#include "haptic_core/base/error.h"
#include "haptic_core/world/hands.h"
#include "haptic_core/world/tuning.h"
#include "haptic_core/world/world.h"

namespace haptic {
namespace coupling_axes_test {

constexpr double kMass = 0.5, kMoment = 2e-3;  // [kg], [kg·m²] of a ball, so that all axes turn alike
const Vector3 kStiffness(200, 120, 0), kDamping(1, 3, 0.5), kTurning(2, 0.8, 1.2), kTurnDamping(0.01, 0.002, 0.006);

/// A ball that floats on a coupling.
WorldDef onCoupling(Attempts attempts, double h, const Matrix3& R_WL, PointerCoupling::Axes axes) {
  WorldDef def;
  def.name = "tool";
  def.settings.attempts = attempts;
  def.settings.step = h;
  def.settings.gravity.setZero();
  def.settings.tolerance = 0;
  def.articulations.push_back(scenes::freeBody("tool", nullptr, kMass, kMoment * Matrix3::Identity(), Pose(R_WL, Vector3(1, 2, 3))));
  PointerDef pointer;
  pointer.articulation = pointer.link = 0;
  PointerCoupling& c = pointer.coupling;
  c.mode = PointerCoupling::Mode::kVirtual;
  c.axes = axes;
  const auto set = [](const Vector3& values, double& greatest, AxisShares& shares) {
    greatest = values.maxCoeff();
    shares.share = values / greatest;
  };
  set(kStiffness, c.stiffness, c.along_stiffness), set(kDamping, c.damping, c.along_damping);
  set(kTurning, c.rotational_stiffness, c.about_stiffness), set(kTurnDamping, c.rotational_damping, c.about_damping);
  def.pointers.push_back(pointer);
  return def;
}

/// x(t) of m ẍ + b ẋ + k x = 0 from x_0 at rest.
double oscillator(double m, double b, double k, double x_0, double t) {
  const double gamma = b / (2 * m), omega2 = k / m - gamma * gamma;
  if (omega2 > 0) {
    const double omega = std::sqrt(omega2);
    return x_0 * std::exp(-gamma * t) * (std::cos(omega * t) + gamma / omega * std::sin(omega * t));
  }
  const double root = std::sqrt(-omega2), r_1 = -gamma + root, r_2 = -gamma - root;
  return x_0 * (r_1 * std::exp(r_2 * t) - r_2 * std::exp(r_1 * t)) / (r_1 - r_2);
}

class CouplingsByIntegrator : public testing::TestWithParam<Attempts> {};
INSTANTIATE_TEST_SUITE_P(All, CouplingsByIntegrator,
                         testing::Values(Attempts::kImplicitEuler,
                                         Attempts::kSdirk2, Attempts::kAll));

/// Each of the six axes swings by itself, with its own stiffness and damping, as a scheme of first order or better has it.
TEST_P(CouplingsByIntegrator, SixAxesSwingEachByItself) {
  const Matrix3 R_WL = rotationAbout(Vector3(1, -2, 0.5).normalized(), 1.1);
  const double t = 0.2;
  for (int axis = 0; axis < 6; ++axis) {
    const double away = axis < 3 ? 0.02 : 1e-3;  // turns small: the axes of the link stay
    const auto error = [&](double h) {
      World world(onCoupling(GetParam(), h, R_WL, axis % 2 ? PointerCoupling::Axes::kLink : PointerCoupling::Axes::kGrip));
      Pose target(R_WL, Vector3(1, 2, 3));
      const Vector3 unit = R_WL.col(axis % 3);
      if (axis < 3) target.p += away * unit;
      if (axis >= 3) target.R = rotationAbout(unit, away) * R_WL;
      for (int i = 0; i < std::lround(t / h); ++i) {
        world.setPointerTarget(0, target, {});
        world.step();
      }
      const Vector3 way = target.p - world.linkPose(0).p,
                    turn = vectorFromRotation(Quaternion(target.R * world.linkPose(0).R.transpose()));
      const Vector3 left = axis < 3 ? way : turn, other = axis < 3 ? turn : way;
      EXPECT_LT((left - unit.dot(left) * unit).norm() + other.norm(), 1e-6 * away) << axis;
      const int k = axis % 3;
      const double exact = axis < 3 ? oscillator(kMass, kDamping[k], kStiffness[k], away, t)
                                    : oscillator(kMoment, kTurnDamping[k], kTurning[k], away, t);
      return std::abs(unit.dot(left) - exact) / away;
    };
    const double coarse = error(1e-3), fine = error(2.5e-4);
    EXPECT_LT(coarse, 0.3) << axis;
    EXPECT_LT(fine, 0.3 * coarse + 1e-9) << axis;  // a quarter of the step: a quarter of the error at first order
  }
}

TEST(CouplingAxes, EqualSharesAreTheOldCouplingToTheLastBit) {
  PointerCoupling c;
  c.stiffness = 300, c.damping = 2, c.rotational_stiffness = 0.7, c.rotational_damping = 0.01;
  LinkWork link;
  link.X_WL = Pose(rotationAbout(Vector3(3, 1, 2).normalized(), 0.7), Vector3(0.1, 0.2, 0.3));
  const Quaternion q_WT = rotationFromVector(Vector3(0.2, -0.3, 0.1)) * Quaternion(link.X_WL.R);
  const Vector3 p_WT(0.13, 0.17, 0.31), turn = vectorFromRotation(q_WT * Quaternion(link.X_WL.R).conjugate());
  const Wrench F = couplingForce(c, Pose(), {p_WT, q_WT, {}}, link);
  EXPECT_EQ(F.force, Vector3(300 * (p_WT - link.X_WL.p)));
  EXPECT_LT((F.torque - 0.7 * turn).norm(), 1e-16);  // quaternions multiply in another order where a test has vectors
}

TEST(CouplingAxes, SharesBeyondTheirRangeAreRefused) {
  for (const double share : {-0.1, 1.1, std::nan("")}) {
    World world(onCoupling(Attempts::kAll, 1e-3, Matrix3::Identity(), PointerCoupling::Axes::kLink));
    WorldTuning tuning = world.tuning();
    tuning.coupling[0].about_damping.share.y() = share;
    EXPECT_THROW(world.tune(tuning), SetupError);
  }
}

/// A mass on a spring along a rail that leans.
WorldDef onSpring(Attempts attempts, double h, double damping) {
  WorldDef def;
  def.name = "spring";
  def.settings.attempts = attempts;
  def.settings.step = h;
  ArticulationDef slide = scenes::freeBox("mass", Vector3::Constant(0.1), 0.5, Pose());
  JointDef& joint = slide.links[0].joint;
  joint.type = JointType::kPrismatic;
  joint.axis = Vector3(0, 0.6, 0.8);
  joint.spring_stiffness = 50;
  joint.spring_position = 0.1;
  joint.damping = damping;
  slide.links[0].collisions.clear();
  def.articulations.push_back(slide);
  return def;
}

TEST_P(CouplingsByIntegrator, SpringsCarryTheWeightAtRest) {
  World world(onSpring(GetParam(), 1e-3, 10));
  for (int i = 0; i < 10000; ++i) world.step();
  EXPECT_NEAR(world.joint(0).position, 0.1 - 0.5 * 9.8 * 0.8 / 50, 1e-12);
  EXPECT_NEAR(world.joint(0).effort, 0.5 * 9.8 * 0.8, 1e-10);
  EXPECT_EQ(world.joint(0).drive, 0);
}

/// Swinging from rest at q = 0 about its equilibrium, and with its energy in the books: what they lack is the step's loss.
TEST_P(CouplingsByIntegrator, SpringsSwingAndAreInTheBooks) {
  const auto errors = [&](double h, double& lack) {
    World world(onSpring(GetParam(), h, 0));
    const double rest = 0.1 - 0.5 * 9.8 * 0.8 / 50;
    const double start = 0.5 * 50 * 0.1 * 0.1;  // gravity's potential counts from the origin, where the mass is
    double worst = 0;
    for (int i = 1; i <= std::lround(0.5 / h); ++i) {
      world.step();
      worst = std::max(worst, std::abs(world.joint(0).position - rest * (1 - std::cos(10 * i * h))));
    }
    const EnergyLedger& e = world.report().energy;
    lack = std::abs(e.total() - start);
    EXPECT_NEAR(e.friction, 0, 1e-15);
    EXPECT_EQ(e.damping, 0);
    return worst;
  };
  double lack = 0, less = 0;
  const double coarse = errors(1e-3, lack), fine = errors(2.5e-4, less);
  EXPECT_LT(coarse, 1e-3);
  EXPECT_LT(fine, 0.3 * coarse);
  EXPECT_LT(lack, 1e-2 * 0.25);
  EXPECT_LT(less, std::max(0.3 * lack, 1e-15));  // rounding of 0.25 J where explicit steps are of fourth order
}

}  // namespace coupling_axes_test
}  // namespace haptic
