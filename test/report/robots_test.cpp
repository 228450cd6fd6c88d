// The exact solutions of the report's robots, against balances and closed forms that share nothing with them.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "exact_chain.h"
#include "hand_grasp.h"
#include "quadruped.h"

namespace haptic::report {
namespace robots_test {

constexpr double kG = 9.8;

PlanarLink uneven(int i) {
  PlanarLink l;
  l.length = 0.3 + 0.1 * i, l.mass = 2 - 0.4 * i, l.centre = 0.1 + 0.05 * i, l.inertia = 0.03 / (1 + i), l.start = 0.4 - 0.7 * i;
  return l;
}
PlanarLink driven(int i) {
  PlanarLink l = uneven(i);
  l.stiffness = 40 / (1 + i), l.damping = 2.0 / (1 + i), l.target = 0.8 * i - 0.5;
  return l;
}

/// Places, in x and z, of the hinges (one more than links) and centres of mass.
struct Places {
  std::vector<Eigen::Matrix<long double, 2, 1>> hinge, centre;
};
Places placesOf(const std::vector<PlanarLink>& links, const PlanarChain::Vector& angle) {
  Places p;
  p.hinge.emplace_back(0, 0);
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Eigen::Matrix<long double, 2, 1> along(std::cos(angle[i]), -std::sin(angle[i]));  // + turns x to −z
    p.centre.push_back(p.hinge[i] + links[i].centre * along);
    p.hinge.push_back(p.hinge[i] + links[i].length * along);
  }
  return p;
}
long double moment(const Eigen::Matrix<long double, 2, 1>& arm, const Eigen::Matrix<long double, 2, 1>& force) {  // about y
  return arm[1] * force[0] - arm[0] * force[1];
}

TEST(PlanarChain, AChainWithoutDrivesKeepsItsEnergy) {
  const std::vector<PlanarLink> links = {uneven(0), uneven(1), uneven(2), uneven(3)};
  PlanarChain chain(links, kG);
  const auto energy = [&](double t) {
    const PlanarChain::Motion m = chain.at(t);
    const Places p = placesOf(links, m.angle);
    long double E = 0;
    Eigen::Matrix<long double, 2, 1> v(0, 0);  // of the hinge
    for (std::size_t i = 0; i < links.size(); ++i) {
      const auto turned = [&](const Eigen::Matrix<long double, 2, 1>& arm) {
        return Eigen::Matrix<long double, 2, 1>(v + m.rate[i] * Eigen::Matrix<long double, 2, 1>(arm[1], -arm[0]));
      };
      E += 0.5L * links[i].mass * turned(p.centre[i] - p.hinge[i]).squaredNorm() + 0.5L * links[i].inertia * m.rate[i] * m.rate[i] +
           links[i].mass * kG * p.centre[i][1];
      v = turned(p.hinge[i + 1] - p.hinge[i]);
    }
    return E;
  };
  const long double start = energy(0);
  double reach = 0, most = 0;  // [m]; [J] of what is exchanged
  for (const PlanarLink& l : links) most += l.mass * kG * (reach += l.length);
  // The integrator errs by 3e-13 per radian at 100 rad/s.
  for (double t = 0.05; t < 1.01; t += 0.05) EXPECT_NEAR(static_cast<double>(energy(t) - start), 0, 1e-12 * most) << t;
}

TEST(PlanarChain, OneLinkFallsAsTheEllipticIntegralSays) {
  PlanarLink l = uneven(0);
  l.start = 0;
  double a = 1, b = std::sqrt(0.5);  // of an amplitude of a right angle
  for (int i = 0; i < 6; ++i) {
    const double mean = (a + b) / 2;
    b = std::sqrt(a * b), a = mean;
  }
  const double quarter = M_PI / 2 / a * std::sqrt((l.inertia + l.mass * l.centre * l.centre) / (l.mass * kG * l.centre));
  PlanarChain pendulum({l}, kG);
  // Times are rounded by 2e-16 s, at up to 8 rad/s; the integrator errs by less than 1e-13 rad.
  for (const int half : {0, 1, 2}) {
    EXPECT_NEAR(static_cast<double>(pendulum.at((1 + 2 * half) * quarter).angle[0]), M_PI / 2, 1e-12) << half;
  }
  EXPECT_NEAR(static_cast<double>(pendulum.at(6 * quarter).angle[0]), M_PI, 1e-12);  // the other side
}

/// Newton's and Euler's equations of each link, with the forces of its hinges, from places alone.
TEST(PlanarChain, EveryLinkObeysNewtonAndEuler) {
  for (const auto& links : {std::vector<PlanarLink>{uneven(0), uneven(1)}, {driven(0), driven(1), driven(2)}}) {
    PlanarChain chain(links, kG);
    const int n = static_cast<int>(links.size());
    constexpr double kDelta = 1.0 / 4096;  // [s]
    const long double weights[] = {-1, 16, -30, 16, -1}, slope[] = {1, -8, 0, 8, -1};
    for (int sample = 1; sample < 8; ++sample) {
      std::vector<Eigen::Matrix<long double, 2, 1>> a(n, Eigen::Matrix<long double, 2, 1>(0, 0));
      PlanarChain::Vector alpha = PlanarChain::Vector::Zero(n), rate = alpha, angle;
      Places now;
      for (int k = 0; k < 5; ++k) {
        const PlanarChain::Motion m = chain.at(sample / 8.0 + (k - 2) * kDelta);
        const Places p = placesOf(links, m.angle);
        for (int i = 0; i < n; ++i) a[i] += weights[k] / (12.0L * kDelta * kDelta) * p.centre[i];
        alpha += weights[k] / (12.0L * kDelta * kDelta) * m.angle;
        rate += slope[k] / (12.0L * kDelta) * m.angle;
        if (k == 2) now = p, angle = m.angle;
      }
      Eigen::Matrix<long double, 2, 1> beyond(0, 0);  // force that this link gives the next
      long double torque_beyond = 0;
      for (int i = n - 1; i >= 0; --i) {
        const PlanarLink& l = links[i];
        const Eigen::Matrix<long double, 2, 1> force = l.mass * (a[i] + Eigen::Matrix<long double, 2, 1>(0, kG)) + beyond;
        const long double q = angle[i] - (i ? angle[i - 1] : 0), v = rate[i] - (i ? rate[i - 1] : 0);
        const long double torque = l.stiffness * (l.target - q) - l.damping * v;
        const long double left = torque - torque_beyond + moment(now.hinge[i] - now.centre[i], force) -
                                 moment(now.hinge[i + 1] - now.centre[i], beyond);
        // Differences of fourth order: δ⁴/90 of the sixth derivative, at 15 rad/s 4e-10 of some 100 rad/s².
        EXPECT_NEAR(static_cast<double>(left - l.inertia * alpha[i]), 0, 1e-7) << n << ' ' << i;  // of up to 50 N·m
        beyond = force, torque_beyond = torque;
      }
    }
  }
}

TEST(PlanarChain, AnArmComesToRestWhereItsDrivesCarryItsWeight) {
  const std::vector<PlanarLink> links = {driven(0), driven(1)};
  PlanarChain arm(links, kG);
  const PlanarChain::Motion m = arm.at(10);
  const Places p = placesOf(links, m.angle);
  for (int i = 0; i < 2; ++i) {
    EXPECT_LT(std::abs(static_cast<double>(m.rate[i])), 1e-6);
    long double weight = 0;
    for (int k = i; k < 2; ++k) weight += moment(p.centre[k] - p.hinge[i], {0, -links[k].mass * kG});
    const long double q = m.angle[i] - (i ? m.angle[0] : 0);
    EXPECT_NEAR(static_cast<double>(links[i].stiffness * (links[i].target - q) + weight), 0, 1e-5) << i;  // by its last motion
  }
}

/// Work of weights and contact forces on a tree, in a virtual turn of each joint, and what the drives give: none is left at rest. Frames of
/// links by the definition alone; `forces`: on which link, where in its frame, how much in W.
struct Contact {
  int link;
  Vector3 at_L, force;
};
void expectBalanced(const ArticulationDef& tree, const std::vector<Contact>& contacts, double g, double tolerance) {
  const auto potential = [&](int turned, double by) {
    std::vector<Pose> frames;
    double V = 0;
    for (int i = 0; i < static_cast<int>(tree.links.size()); ++i) {
      const LinkDef& link = tree.links[i];
      Pose X = (link.parent < 0 ? tree.X_WA : frames[link.parent]) * link.joint.X_PJ;
      if (link.joint.type == JointType::kRevolute) {
        const double q = link.joint.position + (i == turned ? by : 0);
        X = X * Pose(Matrix3(Eigen::AngleAxisd(q, link.joint.axis)), Vector3::Zero());
      }
      frames.push_back(X);
      V += link.inertia.mass * g * (X * link.inertia.p_LC).z();
    }
    for (const Contact& c : contacts) V -= c.force.dot(frames[c.link] * c.at_L);
    return V;
  };
  constexpr double kTurn = 1e-5;  // [rad]: a difference errs by 1e-10 of some N·m, and by rounding of 1e-11
  for (int i = 0; i < static_cast<int>(tree.links.size()); ++i) {
    if (tree.links[i].joint.type != JointType::kRevolute) continue;
    const double gradient = (potential(i, kTurn) - potential(i, -kTurn)) / (2 * kTurn);
    EXPECT_NEAR(tree.links[i].joint.drive_effort, gradient, tolerance) << tree.links[i].name;
  }
}

TEST(Quadruped, DrivesHoldItWhereItStands) {
  const WorldDef def = Quadruped::stands({}, 1e25);
  const ArticulationDef& robot = def.articulations[1];
  double mass = 0;
  for (const LinkDef& link : robot.links) mass += link.inertia.mass;
  EXPECT_NEAR(mass * Quadruped::kGravity, Quadruped::weight(), 1e-12);
  std::vector<Contact> feet;
  for (int leg = 0; leg < 4; ++leg) {
    const Vector3 below = Quadruped::standing()[2 + 2 * leg].X_WL.R.transpose() * Vector3(0, 0, -Quadruped::kFoot);
    feet.push_back({2 + 2 * leg, Vector3(0, 0, -Quadruped::kLength) + below, Vector3(0, 0, Quadruped::weight() / 4)});
  }
  expectBalanced(robot, feet, Quadruped::kGravity, 1e-9);
}

TEST(HandGrasp, DrivesHoldTheBarByFriction) {
  const WorldDef def = HandGrasp::make({}, 1e25);
  const ArticulationDef& hand = def.articulations[1];
  std::vector<Contact> tips;
  Vector3 sum(0, 0, -HandGrasp::kBar * HandGrasp::kG), turn = Vector3::Zero();
  for (int f = 0; f < HandGrasp::kFingers; ++f) {
    const Vector3 on_tip(HandGrasp::side(f) * HandGrasp::press(f), 0, -HandGrasp::carries(f));
    const BodyState last = HandGrasp::states()[5 + 4 * f];
    const Vector3 at = last.X_WL * Vector3(0, 0, -HandGrasp::kLength[3]) - Vector3(HandGrasp::side(f) * HandGrasp::kTip, 0, 0);
    EXPECT_NEAR(std::abs(at.x()), HandGrasp::kWidth / 2, 1e-15);  // on the face
    EXPECT_LT(std::abs(at.y()), HandGrasp::kLong / 2);
    tips.push_back({4 + 4 * f, last.X_WL.inverse() * at, on_tip});
    sum -= on_tip, turn -= at.cross(on_tip);
    EXPECT_LT(std::abs(on_tip.z()), 0.5 * HandGrasp::kMu * std::abs(on_tip.x()));  // holds twice as much
  }
  EXPECT_LT(sum.norm(), 1e-14);
  EXPECT_LT(turn.norm(), 1e-15);
  expectBalanced(hand, tips, HandGrasp::kG, 1e-9);
}

TEST(QuadrupedWalk, FeetStandStillAndDrivesGiveTheEnergyThatTheMotionTakes) {
  const WorldDef def = QuadrupedWalk::make({}, 1e25);
  std::vector<LinkInertia> inertia;
  for (const LinkDef& link : def.articulations[1].links) inertia.push_back(link.inertia);
  const auto energy = [&](double t) {
    double E = 0;
    const std::vector<BodyState> states = QuadrupedWalk::at(t);
    for (std::size_t b = 0; b < states.size(); ++b) {
      const Vector3 arm = states[b].X_WL.R * inertia[b].p_LC, v = states[b].V_WL.linear + states[b].V_WL.angular.cross(arm);
      E += 0.5 * inertia[b].mass * v.squaredNorm() + 0.5 * inertia[b].I_C(1, 1) * std::pow(states[b].V_WL.angular.y(), 2) +
           inertia[b].mass * Quadruped::kGravity * (states[b].X_WL.p + arm).z();
    }
    return E;
  };
  double most = 0;
  for (double t = 0.005; t < QuadrupedWalk::kEnd; t += 0.01) {
    const std::vector<BodyState> now = QuadrupedWalk::at(t);
    const QuadrupedWalk::Forces forces = QuadrupedWalk::forces(t);
    double power = 0;
    for (int leg = 0; leg < 4; ++leg) {
      const BodyState &thigh = now[1 + 2 * leg], &shank = now[2 + 2 * leg];
      power += forces.torque[2 * leg] * thigh.V_WL.angular.y() +
               forces.torque[2 * leg + 1] * (shank.V_WL.angular.y() - thigh.V_WL.angular.y());
      const Vector3 foot = shank.X_WL.R * Vector3(0, 0, -Quadruped::kLength), knee = thigh.X_WL * Vector3(0, 0, -Quadruped::kLength);
      EXPECT_LT((knee - shank.X_WL.p).norm(), 1e-14);
      const double above = (shank.X_WL.p + foot).z() - Quadruped::kFoot;
      const Vector3 f = forces.foot[leg];
      if (QuadrupedWalk::share(leg, t) > 0) {  // it stands, and rolls as it turns
        const Vector3 slip = shank.V_WL.linear + shank.V_WL.angular.cross(foot - Vector3(0, 0, Quadruped::kFoot));
        EXPECT_LT(slip.norm(), 1e-11) << leg << ' ' << t;
        EXPECT_NEAR(above, 0, 1e-14);
        // Friction takes less than half of what it could. A foot that is unloaded has little of both.
        EXPECT_GE(f.z(), 0) << leg << ' ' << t;
        EXPECT_LE(std::hypot(f.x(), f.y()), 0.5 * 0.8 * f.z()) << leg << ' ' << t;
        if (QuadrupedWalk::share(leg, t) == 1) { EXPECT_GT(f.z(), 4) << leg << ' ' << t; }
      } else {
        EXPECT_GE(above, -1e-14);
        EXPECT_LT(f.norm(), 1e-12);
      }
    }
    constexpr double kDelta = 2e-4;  // [s]
    const double rate = (8 * (energy(t + kDelta) - energy(t - kDelta)) - energy(t + 2 * kDelta) + energy(t - 2 * kDelta)) / (12 * kDelta);
    // Rounding of 60 J over the difference, 1e-10 W; the motion's velocities by 1e-12 m/s, 1e-7 W; ends of smooth steps, see `forces`.
    EXPECT_NEAR(power, rate, 2e-6) << t;
    most = std::max(most, std::abs(power));
  }
  EXPECT_GT(most, 1);  // [W]: else nothing was compared
}

/// A drive that is asked for the path's positions gives the torques of the motion in the mean.
TEST(QuadrupedWalk, DrivesFollowThePathToTheTorquesOfTheMotion) {
  const JointPathDef path = QuadrupedWalk::path();
  const int columns = static_cast<int>(path.joints.size());
  EXPECT_EQ(path.position.size(), path.time.size() * columns);
  for (std::size_t row = 0; row + 1 < path.time.size(); row += 97) {
    const double h = path.time[row + 1] - path.time[row], t = path.time[row] + h / 2;
    const QuadrupedWalk::Forces forces = QuadrupedWalk::forces(t);
    const std::vector<BodyState> now = QuadrupedWalk::at(t);
    for (int j = 0; j < columns; ++j) {
      const double from = path.position[row * columns + j], to = path.position[(row + 1) * columns + j];
      const int leg = j / 2;
      const QuadrupedWalk::Posture p = QuadrupedWalk::posture(t);
      const double before = j % 2 ? p.angle[1 + 2 * leg] : 0, spin = j % 2 ? now[1 + 2 * leg].V_WL.angular.y() : 0;
      const double q = p.angle[1 + j] - before, v = now[1 + j].V_WL.angular.y() - spin;
      const double torque = Quadruped::kStiffness * ((from + to) / 2 - q) + Quadruped::kDamping * ((to - from) / h - v);
      // Mean and middle of a row of 0.5 ms differ by h²/24 of the second derivative: 1e-8 of (K q̈, τ̈) of up to 1e5 N·m/s².
      EXPECT_NEAR(torque, forces.torque[j], 1e-3) << j << ' ' << t;
    }
  }
}

}  // namespace robots_test
}  // namespace haptic::report
