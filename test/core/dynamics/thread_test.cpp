// A screw: lead, locking and the torques of textbooks, against closed forms.
#include "haptic_core/dynamics/thread.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "haptic_core/base/error.h"
#include "haptic_core/dynamics/tree_motion.h"

namespace haptic::test {
namespace thread_test {

constexpr double kStep = 1e-3, kGravity = 9.8;

/// A metric thread: pitch diameter d − 0.6495 P (ISO 724), flanks of 60°.
struct Metric {
  double diameter, pitch;
  double radius() const { return 0.5 * (diameter - 0.6495 * pitch); }
  double lead() const { return pitch / (2 * M_PI); }
  double tangent() const { return lead() / radius(); }
};
const Metric kThreads[] = {{4e-3, 0.7e-3}, {8e-3, 1.25e-3}, {20e-3, 2.5e-3}, {24e-3, 20e-3}};  // the last one of several starts

/// cos of the flank's angle across the helix.
double acrossHelix(const Metric& thread, double flank) {
  const double t = std::tan(flank) / std::hypot(1, thread.tangent());
  return 1 / std::hypot(1, t);
}

/// Shigley's torque over axial force that moves a load along (`sign` 1), or lets it down (−1: what holds it back is negative) [m].
double leverOf(const Metric& thread, double mu, double flank, int sign) {
  const double rubbed = mu / acrossHelix(thread, flank);
  return thread.radius() * (thread.tangent() + sign * rubbed) / (1 - sign * rubbed * thread.tangent());
}

struct Nut {
  double mass = 0.05, moment = 4e-6;  ///< what slides; what turns
  bool apart = false;                 ///< the slide is a link beside the turning one
  int hand = 1;                       ///< −1: left-handed
};

/// Link 0 turns, link 1 slides, about and along an oblique axis; or the nut does both, on a massless slide.
TreeDef screw(const Metric& thread, double mu, const Nut& nut = {}, double flank = M_PI / 6) {
  TreeDef def;
  def.name = "screw";
  def.X_WA.R = Quaternion(0.7, 0.3, -0.5, 0.4).normalized().toRotationMatrix();
  def.links.resize(2);
  const int slides = nut.apart ? 1 : 0, turns = 1 - slides;
  BodyDef &slide = def.links[slides], &turn = def.links[turns];
  slide.name = "slide", turn.name = "turn";
  slide.joint.axis = turn.joint.axis = Vector3::UnitZ();
  slide.joint.type = JointType::kPrismatic, turn.joint.type = JointType::kRevolute;
  slide.joint.name = "s", turn.joint.name = "t";
  if (!nut.apart) turn.parent = 0;
  slide.joint.mimic_joint = turns;
  slide.joint.mimic_multiplier = nut.hand * thread.lead();
  slide.joint.thread_friction = mu;
  slide.joint.thread_radius = thread.radius();
  slide.joint.thread_flank = flank;
  turn.inertia.I_C = nut.moment * Matrix3::Identity();
  (nut.apart ? slide : turn).inertia.mass = nut.mass;
  return def;
}

/// The screw with an axial load, positive against the slide, and a torque on the turn.
class Driven {
 public:
  explicit Driven(const TreeDef& def) : tree_(def), motion_(tree_), q_(2), v_(2), work_(2), tau_(2), commands_(2) {
    for (turn_ = 0; def.links[turn_].name != "turn";) ++turn_;
    tree_.initialState(q_.data(), v_.data());
  }
  double& rate() { return v_[turn_]; }
  double angle() const { return q_[turn_]; }
  double way() const { return q_[1 - turn_]; }
  JointWork sum;
  int most_passes = 0;
  /// True: all joints ended on their graphs.
  bool step(double load, double torque) {
    tau_[1 - turn_] = -load, tau_[turn_] = torque;
    forwardKinematics(tree_, q_.data(), v_.data(), work_.data());
    const JointReport& report = motion_.step(Vector3::Zero(), kStep, commands_.data(), q_.data(), v_.data(), work_.data(), tau_.data());
    sum.friction += report.friction;
    most_passes = std::max(most_passes, report.passes);
    return report.converged;
  }
  void setWay() { q_[1 - turn_] = 0, v_[1 - turn_] = tree_.def().links[1 - turn_].joint.mimic_multiplier * v_[turn_]; }

 private:
  Articulation tree_;
  TreeMotion motion_;
  std::vector<double> q_, v_;
  std::vector<LinkWork> work_;
  std::vector<double> tau_;
  std::vector<JointCommand> commands_;
  int turn_;
};

// Sliding: I θ'' = T − K F, F = load + m l θ'', with K of Shigley. What comes down turns by the load alone.
TEST(Thread, ALoadTurnsItBelowTheLockingFrictionAsTheClosedFormSays) {
  for (const Metric& thread : kThreads) {
    for (const double mu : {0.01, 0.02}) {
      for (const bool apart : {false, true}) {
        for (const int hand : {1, -1}) {
          const Nut nut{0.05, 4e-6, apart, hand};
          Driven run(screw(thread, mu, nut));
          const double load = nut.mass * kGravity, K = leverOf(thread, mu, M_PI / 6, -1);
          for (int i = 0; i < 200; ++i) ASSERT_TRUE(run.step(load, 0));
          const double rate = -K * load / (nut.moment + K * nut.mass * thread.lead());
          EXPECT_NEAR(run.rate(), hand * rate * 0.2, 1e-8 * std::abs(rate)) << thread.diameter << " " << mu << " " << apart;
          EXPECT_NEAR(run.way(), hand * thread.lead() * run.angle(), 1e-15);
          const double kinetic = 0.5 * nut.moment * run.rate() * run.rate() + 0.5 * nut.mass * std::pow(thread.lead() * run.rate(), 2);
          // Work is that of the mean velocity of a step, the way that of its end: 201/200 of it after 200 steps.
          EXPECT_NEAR(run.sum.friction, -load * run.way() / 1.005 - kinetic, 1e-8 * kinetic);
          EXPECT_LE(run.most_passes, 5);
        }
      }
    }
  }
}

// tan α cos β_n: just below it any load turns the nut, just above none does, and what stands does so to the last bit.
TEST(Thread, LocksAtTheTangentOfItsLeadAngleTimesTheCosineOfItsFlank) {
  for (const Metric& thread : kThreads) {
    for (const double flank : {0.0, M_PI / 12, M_PI / 6}) {
      const double locks = thread.tangent() * acrossHelix(thread, flank);
      for (const double load : {1., 100., -100., 1e4}) {
        Driven free(screw(thread, locks * (1 - 1e-6), {}, flank)), held(screw(thread, locks * (1 + 1e-6), {}, flank));
        for (int i = 0; i < 1500; ++i) held.step(load, 0), free.step(load, 0);
        EXPECT_EQ(held.angle(), 0);
        EXPECT_LT(free.angle() * load, -1e-6 * load * load);
      }
    }
  }
  EXPECT_NEAR(Thread(screw(kThreads[2], 0.1).links[0].joint).lockingFriction(), 0.0375, 1e-4 * 0.0375 + 5e-5);
}

// A torque moves a load along, or lets it down where the thread locks, from Shigley's on.
TEST(Thread, GivesWayToTheTorquesOfTextbooks) {
  for (const Metric& thread : kThreads) {
    for (const double mu : {0.08, 0.15, 0.3}) {
      const double load = 50;
      for (const int sign : {1, -1}) {
        const double torque = load * leverOf(thread, mu, M_PI / 6, sign);
        if (sign < 0 && torque > 0) continue;  // it does not lock
        const double margin = 1e-6 * std::abs(torque);
        Driven held(screw(thread, mu)), moved(screw(thread, mu));
        for (int i = 0; i < 20; ++i) held.step(load, torque - sign * margin), moved.step(load, torque + sign * margin);
        EXPECT_EQ(held.angle(), 0) << thread.diameter << " " << mu << " " << sign;
        EXPECT_GT(sign * moved.angle(), 0) << thread.diameter << " " << mu << " " << sign;
      }
    }
  }
}

// A carriage of 20 kg on a light spindle: friction follows a force that friction changes. I θ'' = T − K F, F = M (g + l θ'').
TEST(Thread, MovesAHeavyCarriageAsTheClosedFormSays) {
  for (const double mu : {0.1, 0.3}) {
    const Metric thread{8e-3, 8e-3};
    const Nut carriage{20, 1e-6, true, 1};
    const double load = carriage.mass * kGravity, K = leverOf(thread, mu, M_PI / 12, 1), torque = 1.5 * K * load;
    Driven run(screw(thread, mu, carriage, M_PI / 12));
    for (int i = 0; i < 100; ++i) ASSERT_TRUE(run.step(load, torque));
    const double rate = (torque - K * load) / (carriage.moment + K * carriage.mass * thread.lead());
    EXPECT_NEAR(run.rate(), 0.1 * rate, 1e-7 * rate) << mu;
    EXPECT_LE(run.most_passes, 6);
  }
}

// What it is tightened against pushes back at once, and friction follows that: it gives way until spring, friction and torque balance.
TEST(Thread, TightensAgainstWhatIsStiff) {
  for (const double stiffness : {1e5, 1e7}) {
    TreeDef def = screw(kThreads[0], 0.15);
    def.links[0].joint.spring_stiffness = stiffness;
    def.links[1].joint.damping = 1e-5;
    Driven run(def);
    const double K = leverOf(kThreads[0], 0.15, M_PI / 6, 1);
    for (int i = 1; i <= 1000; ++i) ASSERT_TRUE(run.step(0, -0.05 * i * K)) << stiffness << " " << i;
    EXPECT_NEAR(-run.way() * stiffness, 50, 0.5) << stiffness;
  }
}

// Where K < 0 and I < −K M l no sliding downwards is consistent: a thread that comes down jams, within a step, and stands.
TEST(Thread, JamsWhereNoFrictionLetsItSlide) {
  const Metric thread{8e-3, 2e-3};
  const Nut carriage{50, 1e-7, true, 1};
  Driven run(screw(thread, 0.3, carriage, M_PI / 12));
  ASSERT_GT(-leverOf(thread, 0.3, M_PI / 12, -1) * carriage.mass * thread.lead(), carriage.moment);
  run.rate() = -20;
  run.setWay();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(run.step(carriage.mass * kGravity, 0)) << i;
  EXPECT_EQ(run.rate(), 0);
  EXPECT_LE(std::abs(run.angle()), 20 * kStep);
}

TEST(Thread, KeepsItsLeadThroughTurnsAndLoads) {
  Driven run(screw(kThreads[0], 0.02));
  double farthest = 0;
  for (int i = 0; i < 20000; ++i) {
    run.step(3 * std::sin(0.01 * i), 1e-3 * std::cos(0.003 * i));
    farthest = std::max(farthest, std::abs(run.way()));
    ASSERT_LE(std::abs(run.way() - kThreads[0].lead() * run.angle()), 4e-16 * farthest) << i;
  }
  EXPECT_GT(farthest, 1e-3);
}

TEST(Thread, SaysItsEfficiency) {
  const Metric& thread = kThreads[2];
  EXPECT_NEAR(Thread(screw(thread, 0.1).links[0].joint).efficiency(), thread.lead() / leverOf(thread, 0.1, M_PI / 6, 1), 1e-12);
  EXPECT_EQ(Thread(screw(thread, 0).links[0].joint).efficiency(), 1);
}

void expectRefused(TreeDef def, const std::string& text) {
  try {
    Articulation tree(def);
    FAIL() << text;
  } catch (const SetupError& error) {
    EXPECT_NE(std::string(error.what()).find(text), std::string::npos) << error.what();
  }
}

TEST(Thread, IsRefusedWhereItCannotBe) {
  TreeDef def = screw(kThreads[0], 0.1);
  def.links[0].joint.mimic_joint = -1;
  expectRefused(def, "only a slide that follows a turn");
  def = screw(kThreads[0], 0.1);
  std::swap(def.links[0].joint.type, def.links[1].joint.type);
  expectRefused(def, "only a slide that follows a turn");
  def = screw(kThreads[0], 0.1);
  def.links[0].joint.thread_radius = 0;
  expectRefused(def, "must be numbers > 0");
  expectRefused(screw(kThreads[0], -0.1), "must be numbers > 0");
  expectRefused(screw(kThreads[0], NAN), "must be numbers > 0");
  expectRefused(screw({18e-3, 20e-3}, 0.9), "holds at every torque");
}

}  // namespace thread_test
}  // namespace haptic::test
