/// A quadruped of nine links for the report: a body on four legs of thigh and shank with ball feet. It stands, or walks along a path whose
/// motion is exact.
///
/// The walk: the legs of the left side step, hind and fore, the body follows, then those of the right side, and the body again: the lateral
/// sequence of animals that walk, all by smooth steps of time. The centre of mass stays over the feet that stand, feet roll on the ground
/// without slip, and they land and leave without speed. Inverse dynamics says which forces of the feet and which torques τ this motion
/// takes, and the drives are asked for positions u with K (u − q) + D (u̇ − q̇) = τ: the feed-forward that makers of such robots use. So
/// rigid bodies with Coulomb's friction walk along it exactly. Where more feet stand than the balance needs the forces have the least sum
/// of |f|²/w, w from 0 to 1 and back as a foot is loaded and unloaded.
#pragma once
#include <array>
#include <cmath>

#include "../scenes/balls.h"
#include "report_scene.h"

namespace haptic::report {

struct Quadruped {
  static constexpr double kGravity = 9.8;                            // [m/s²]
  static constexpr double kBody = 10, kThigh = 0.8, kShank = 0.2;    // [kg]
  static constexpr double kLength = 0.25, kFoot = 0.03, kBend = 0.5;  // [m], [m], [rad] of the thighs
  static constexpr double kStiffness = 150, kDamping = 1;            // [N·m/rad], [N·m·s/rad]
  static constexpr double kLegX = 0.2, kLegY = 0.1;                  // [m] of the hips
  static constexpr int kLegs = 4;                                    // fore left, fore right, hind left, hind right
  static int front(int leg) { return leg < 2 ? 1 : -1; }
  static int left(int leg) { return leg % 2 == 0 ? 1 : -1; }
  static Vector3 hip(int leg) { return {front(leg) * kLegX, left(leg) * kLegY, 0}; }  // in the body's frame

  static double height() { return 2 * kLength * std::cos(kBend) + kFoot; }  // of the hips over the ground
  static double weight() { return (kBody + kLegs * (kThigh + kShank)) * kGravity; }  // [N]

  /// Angles of a leg's links about y from hanging down, +: the end leads to −x.
  struct Leg {
    double thigh = 0, shank = 0;
  };
  using Legs = std::array<Leg, kLegs>;
  /// Fore knees point backwards and hind ones forwards: what is in front is mirrored behind. Feet are under the hips.
  static Legs stance() {
    Legs legs;
    for (int i = 0; i < kLegs; ++i) legs[i] = {front(i) * kBend, -front(i) * kBend};
    return legs;
  }

  /// Depth at which a foot's cap carries its load: k π d² (3 r − d)/3.
  static double depth(double k) {
    double d = 0;
    for (int i = 0; i < 100; ++i) d = std::sqrt(weight() / kLegs / (k * M_PI * (kFoot - d / 3)));
    return d;
  }
  static double across(double mass) { return mass * kLength * kLength / 12; }  // moment of inertia of a link about y [kg·m²]

  static LinkDef segment(const std::string& name, int parent, const Vector3& p, double q, double mass) {
    LinkDef link;
    link.name = name;
    link.parent = parent;
    link.joint.name = name + "_joint";
    link.joint.type = JointType::kRevolute;
    link.joint.axis = Vector3::UnitY();
    link.joint.X_PJ = Pose(p);
    link.joint.position = q;
    link.joint.drive = JointDef::Drive::kPosition;
    link.joint.drive_stiffness = kStiffness;
    link.joint.drive_damping = kDamping;
    link.inertia.mass = mass;
    link.inertia.p_LC = Vector3(0, 0, -kLength / 2);
    link.inertia.I_C = Vector3(across(mass), across(mass), 0.1 * across(mass)).asDiagonal();
    return link;
  }

  /// On the ground, link 0; then come body, and thigh and shank of each leg. Its feet are in it as deep as their load on k presses them.
  static WorldDef make(const WorldSettings& settings, double k, const Legs& legs) {
    WorldDef def;
    def.name = "quadruped";
    def.settings = settings;
    def.settings.gravity = Vector3(0, 0, -kGravity);
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = k;
    m.dissipation = 10;
    m.mu_static = m.mu_dynamic = 0.8;
    def.articulations.push_back(scenes::groundPlane());
    ArticulationDef robot = scenes::freeBox("quadruped", Vector3(0.5, 0.2, 0.1), kBody, Pose(Vector3(0, 0, height() - depth(k))));
    for (int i = 0; i < kLegs; ++i) {
      const std::string leg = std::string(front(i) > 0 ? "fore" : "hind") + (left(i) > 0 ? "_left" : "_right");
      const int body = static_cast<int>(robot.links.size());
      robot.links.push_back(segment(leg + "_thigh", 0, hip(i), legs[i].thigh, kThigh));
      robot.links.push_back(segment(leg + "_shank", body, Vector3(0, 0, -kLength), legs[i].shank - legs[i].thigh, kShank));
      CollisionDef foot;
      foot.name = leg + "_foot";
      foot.shape = std::make_shared<Ball>(kFoot);
      foot.X_LS = Pose(Vector3(0, 0, -kLength));
      robot.links.back().collisions.push_back(foot);
    }
    def.articulations.push_back(robot);
    return def;
  }

  /// It stands on rigid ground: body, then thigh and shank of each leg.
  static std::vector<BodyState> standing() {
    std::vector<BodyState> states = {{Pose(Vector3(0, 0, height())), Twist{}}};
    for (int i = 0; i < kLegs; ++i) {
      const Matrix3 turn(Eigen::AngleAxisd(front(i) * kBend, Vector3::UnitY()));
      const Vector3 at = hip(i) + Vector3(0, 0, height());
      states.push_back({Pose(turn, at), Twist{}});
      states.push_back({Pose(Matrix3(turn.transpose()), Vector3(at - kLength * turn.col(2))), Twist{}});
    }
    return states;
  }

  /// It stands with a quarter of the weight on each foot, which is under its hip; the knee is beside both by `aside`.
  static WorldDef stands(const WorldSettings& settings, double k) {
    WorldDef def = make(settings, k, stance());
    for (int i = 0; i < kLegs; ++i) {
      const double aside = -kLength * std::sin(front(i) * kBend);
      LinkDef* links = &def.articulations[1].links[1 + 2 * i];
      links[0].joint.drive_effort = -aside / 2 * (kThigh + kShank) * kGravity;
      links[1].joint.drive_effort = -aside * weight() / kLegs + aside / 2 * kShank * kGravity;
    }
    return def;
  }
};

class QuadrupedWalk {
 public:
  static constexpr int kLegs = Quadruped::kLegs, kBodies = 1 + 2 * kLegs;
  static constexpr double kMargin = 0.03, kStride = 4 * kMargin;  // [m] of the centre of mass off the diagonal of feet that stand; [m]
  static constexpr double kLift = 0.03;                           // [m]
  static constexpr double kRest = 0.1, kShift = 0.1, kSwing = 0.4, kFollow = 0.5;  // [s]: before and after; of load; of a leg; of the body
  static constexpr double kHalf = 2 * kSwing + kShift + kFollow;  // of the period [s]: legs of one side, then the body
  static constexpr double kEnd = 2 * kRest + kShift + 2 * kHalf;  // [s]

  /// When a leg leaves the ground [s]: hind left, fore left, hind right, fore right.
  static double lifts(int leg) {
    return kRest + kShift + (Quadruped::left(leg) > 0 ? 0 : kHalf) + (Quadruped::front(leg) > 0 ? kSwing + kShift : 0);
  }
  /// From 0 to 1 as s does, with three derivatives of 0 at both ends.
  static double smooth(double s) {
    s = std::min(std::max(s, 0.0), 1.0);
    return s * s * s * s * (35 + s * (-84 + s * (70 - 20 * s)));
  }
  /// How much of the load a foot takes [1].
  static double share(int leg, double t) {
    return 1 - smooth((t - lifts(leg) + kShift) / kShift) + smooth((t - lifts(leg) - kSwing) / kShift);
  }
  /// It goes on when both legs of a side have stepped, by half of their step.
  static double bodyX(double t) {
    const double first = lifts(0) + kSwing;
    return kStride / 2 * (smooth((t - first) / kFollow) + smooth((t - first - kHalf) / kFollow));
  }

  /// A leg's angles from where its foot is: the centre of its ball at x = x_0 + r · shank, as it rolls, and r over the ground.
  static Quadruped::Leg leg(int i, double t) {
    const double s = std::min(std::max((t - lifts(i)) / kSwing, 0.0), 1.0), l = Quadruped::kLength, r = Quadruped::kFoot;
    const double x_0 = -kMargin + kStride * smooth(s) - bodyX(t);  // from the hip
    const double below = Quadruped::height() - Quadruped::kFoot - 256 * kLift * std::pow(s * (1 - s), 4);
    Quadruped::Leg q = Quadruped::stance()[i];
    for (int k = 0; k < 6; ++k) {  // Newton's
      Eigen::Matrix<double, 2, 1> miss(l * (std::sin(q.thigh) + std::sin(q.shank)) + x_0 + r * q.shank,
                                     l * (std::cos(q.thigh) + std::cos(q.shank)) - below);
      Eigen::Matrix<double, 2, 2> J;
      J << l * std::cos(q.thigh), l * std::cos(q.shank) + r, -l * std::sin(q.thigh), -l * std::sin(q.shank);
      miss = J.inverse() * miss;
      q.thigh -= miss[0], q.shank -= miss[1];
    }
    return q;
  }

  /// Body, then thigh and shank of each leg: the frame's origin and the angle about y.
  struct Posture {
    std::array<Vector3, kBodies> origin;
    std::array<double, kBodies> angle;
    Vector3 along(int body, double length) const {  // from the origin down the link
      return origin[body] - length * Vector3(std::sin(angle[body]), 0, std::cos(angle[body]));
    }
    Vector3 centre(int body) const { return along(body, body == 0 ? 0 : Quadruped::kLength / 2); }
    Vector3 sole(int leg) const { return along(2 + 2 * leg, Quadruped::kLength) - Quadruped::kFoot * Vector3::UnitZ(); }
  };
  static Posture posture(double t) {
    Posture p;
    p.origin[0] = Vector3(bodyX(t), 0, Quadruped::height());
    p.angle[0] = 0;
    for (int i = 0; i < kLegs; ++i) {
      const Quadruped::Leg q = leg(i, t);
      p.origin[1 + 2 * i] = p.origin[0] + Quadruped::hip(i);
      p.angle[1 + 2 * i] = q.thigh;
      p.origin[2 + 2 * i] = p.along(1 + 2 * i, Quadruped::kLength);
      p.angle[2 + 2 * i] = q.shank;
    }
    return p;
  }

  /// What the motion takes at a time: force of the ground on each foot [N], torque of each joint, hip and knee of each leg [N·m].
  struct Forces {
    std::array<Vector3, kLegs> foot;
    std::array<double, 2 * kLegs> torque;
  };
  static Forces forces(double t) {
    // Second derivatives by differences of fourth order over 0.2 ms: rounding leaves 1e-8 m/s², ends of smooth steps 3e-5 for 0.4 ms.
    constexpr double kDelta = 2e-4, kWeights[] = {-1, 16, -30, 16, -1};
    const Posture p = posture(t);
    std::array<Vector3, kBodies> push;  // m (a − g)
    std::array<double, kBodies> turn;   // I α about y
    push.fill(Vector3::Zero()), turn.fill(0);
    for (int k = 0; k < 5; ++k) {
      const Posture beside = posture(t + (k - 2) * kDelta);
      for (int b = 0; b < kBodies; ++b) {
        push[b] += kWeights[k] / (12 * kDelta * kDelta) * beside.centre(b);
        turn[b] += kWeights[k] / (12 * kDelta * kDelta) * beside.angle[b];
      }
    }
    Eigen::Matrix<double, 6, 1> wanted = Eigen::Matrix<double, 6, 1>::Zero();  // force, and moment about the origin
    for (int b = 0; b < kBodies; ++b) {
      const double mass = b == 0 ? Quadruped::kBody : b % 2 ? Quadruped::kThigh : Quadruped::kShank;
      push[b] = mass * (push[b] + Quadruped::kGravity * Vector3::UnitZ());
      turn[b] *= Quadruped::across(mass);  // the body does not turn
      wanted.head<3>() += push[b];
      wanted.tail<3>() += p.centre(b).cross(push[b]) + turn[b] * Vector3::UnitY();
    }
    Eigen::Matrix<double, 6, 3 * kLegs> A;
    Eigen::Matrix<double, 3 * kLegs, 1> w;
    for (int i = 0; i < kLegs; ++i) {
      const Vector3 at = p.sole(i);
      w.segment<3>(3 * i).setConstant(share(i, t));
      A.block<3, 3>(0, 3 * i).setIdentity();
      for (int c = 0; c < 3; ++c) A.block<3, 1>(3, 3 * i + c) = at.cross(Vector3::Unit(c));
    }
    const Eigen::Matrix<double, 6, 6> AwA = A * w.asDiagonal() * A.transpose();
    const Eigen::Matrix<double, 3 * kLegs, 1> f = w.asDiagonal() * (A.transpose() * AwA.ldlt().solve(wanted));
    Forces out;
    for (int i = 0; i < kLegs; ++i) {
      out.foot[i] = f.segment<3>(3 * i);
      double beyond = 0;
      for (const int joint : {1, 0}) {  // the balance of all that hangs on it, about it: knee, then hip
        const int b = 1 + 2 * i + joint;
        double torque = beyond + turn[b] + (p.centre(b) - p.origin[b]).cross(push[b]).y();
        if (joint == 1) {
          torque -= (p.sole(i) - p.origin[b]).cross(out.foot[i]).y();
        } else {  // what the shank takes, from the knee to the hip
          torque += (p.origin[b + 1] - p.origin[b]).cross(push[b + 1] - out.foot[i]).y();
        }
        out.torque[2 * i + joint] = beyond = torque;
      }
    }
    return out;
  }

  /// Positions that the drives are asked for: K u + D u̇ = τ + K q + D q̇ in the mean over each row, by Simpson's rule, so that torques
  /// err by the fourth power of the rows' distance and by a saw tooth without a mean.
  static JointPathDef path() {
    constexpr double kRow = 5e-4;  // [s]
    constexpr double K = Quadruped::kStiffness, D = Quadruped::kDamping;
    using Joints = Eigen::Array<double, 2 * kLegs, 1>;
    const auto angles = [](double t) {
      Joints q;
      for (int i = 0; i < kLegs; ++i) {
        const Quadruped::Leg now = leg(i, t);
        q[2 * i] = now.thigh, q[2 * i + 1] = now.shank - now.thigh;
      }
      return q;
    };
    const auto wanted = [&](double t) {  // without D q̇, whose mean is a difference
      const Forces f = forces(t);
      return Joints(K * angles(t) + Eigen::Map<const Joints>(f.torque.data()));
    };
    JointPathDef out{"walk", {}, {}, {}};
    for (int j = 0; j < 2 * kLegs; ++j) out.joints.emplace_back(1, 1 + j);
    Joints from = wanted(0), q = angles(0), u = from / K;
    for (int row = 0; row <= std::lround(kEnd / kRow); ++row) {
      out.time.push_back(row * kRow);
      for (const double each : u) out.position.push_back(each);
      const double end = (row + 1) * kRow;
      const Joints to = wanted(end), next = angles(end);
      const Joints mean = (from + 4 * wanted(end - kRow / 2) + to) / 6 + D * (next - q) / kRow;
      u = (mean + (D / kRow - K / 2) * u) / (D / kRow + K / 2);
      from = to, q = next;
    }
    return out;
  }

  static WorldDef make(const WorldSettings& settings, double k) {
    static const JointPathDef kPath = path();
    Quadruped::Legs legs;
    for (int i = 0; i < kLegs; ++i) legs[i] = leg(i, 0);
    WorldDef def = Quadruped::make(settings, k, legs);
    def.joint_paths.push_back(kPath);
    return def;
  }

  /// Where its links are, with their velocities.
  static std::vector<BodyState> at(double t) {
    constexpr double kDelta = 1e-4;  // [s]: differences of fourth order, and rounding, err by 1e-12 m/s
    const Posture now = posture(t);
    std::array<Posture, 4> beside = {posture(t - 2 * kDelta), posture(t - kDelta), posture(t + kDelta), posture(t + 2 * kDelta)};
    const auto rate = [&](auto value) {
      return ((value(beside[0]) - value(beside[3])) + 8 * (value(beside[2]) - value(beside[1]))) / (12 * kDelta);
    };
    std::vector<BodyState> states(kBodies);
    for (int b = 0; b < kBodies; ++b) {
      states[b].X_WL = Pose(Matrix3(Eigen::AngleAxisd(now.angle[b], Vector3::UnitY())), now.origin[b]);
      states[b].V_WL.angular.y() = rate([b](const Posture& p) { return p.angle[b]; });
      for (int c = 0; c < 3; ++c) {
        states[b].V_WL.linear[c] = rate([b, c](const Posture& p) { return p.origin[b][c]; });
      }
    }
    return states;
  }
};

}  // namespace haptic::report
