/// A hand of four fingers that holds a bar by its drives, weight carried by friction: it stays, if surfaces are rigid and friction is
/// Coulomb's. Three fingers press on one face and the thumb on the other; they hang from a palm above.
#pragma once
#include <cmath>

#include "../scenes/blocks.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "report_scene.h"

namespace haptic::report {

/// Link 0 is the bar, 1 the palm, then come the links of each finger.
struct HandGrasp {
  static constexpr int kFingers = 4, kJoints = 4, kLinks = 2 + kFingers * kJoints;  ///< the last finger is the thumb
  static constexpr double kG = 9.8;                                                  ///< [m/s²]
  static constexpr double kBar = 0.2, kWidth = 0.05, kLong = 0.14;                   ///< [kg], [m], [m]
  static constexpr double kPress = 4, kMu = 0.8;                                     ///< of the thumb [N]
  static constexpr double kStiffness = 1, kDamping = 5e-3;                           ///< [N·m/rad], [N·m·s/rad]
  /// As a public model of the Allegro hand has them, with the tip's mass in the last link's; centres of mass are in the middle.
  static constexpr double kLength[] = {0.0164, 0.054, 0.0384, 0.0267}, kMass[] = {0.0119, 0.065, 0.0355, 0.0264};  ///< [m], [kg]
  static constexpr double kTip = 0.012, kSpread = 0.0435;                            ///< ball's radius, between fingers [m]
  /// First joint about the finger, the others bend it, from hanging down: outwards, and in again around the bar.
  static constexpr double kBend[] = {0, 0.3, -0.8, -0.7};                            ///< [rad]

  static bool isThumb(int finger) { return finger == kFingers - 1; }
  static double side(int finger) { return isThumb(finger) ? 1 : -1; }  ///< of the bar along x
  static double press(int finger) { return isThumb(finger) ? kPress : kPress / (kFingers - 1); }  ///< [N]
  static double carries(int finger) { return kBar * kG / 2 / (isThumb(finger) ? 1 : kFingers - 1); }  ///< [N] of the bar's weight
  static double bend(int finger, int joint) { return -side(finger) * kBend[joint]; }
  static Vector3 axis(int joint) { return joint == 0 ? Vector3(Vector3::UnitZ()) : Vector3(Vector3::UnitY()); }

  /// Depth at which a tip presses: k π d² (3 r − d)/3.
  static double depth(double force, double k) {
    double d = 0;
    for (int i = 0; i < 100; ++i) d = std::sqrt(force / (k * M_PI * (kTip - d / 3)));
    return d;
  }

  /// Frames of a finger's links, and at last its tip, from its first joint, which lies above.
  static std::vector<Pose> chain(int finger) {
    std::vector<Pose> frames;
    Pose X;
    for (int j = 0; j < kJoints; ++j) {
      X = X * Pose(Matrix3(Eigen::AngleAxisd(bend(finger, j), axis(j))), Vector3::Zero());
      frames.push_back(X);
      X = X * Pose(Vector3(0, 0, -kLength[j]));
    }
    frames.push_back(X);
    return frames;
  }
  /// First joint of a finger whose tip is `deep` in the bar's face, in W.
  static Vector3 root(int finger, double deep = 0) {
    const double y = isThumb(finger) ? 0 : (finger - 1) * kSpread;
    return Vector3(side(finger) * (kWidth / 2 + kTip - deep), y, 0) - chain(finger).back().p;
  }

  /// What a finger's drives hold at rest: its links' weights and the bar's force on its tip, about each axis [N·m].
  static std::vector<double> efforts(int finger) {
    const std::vector<Pose> frames = chain(finger);
    const Vector3 contact = frames.back().p - Vector3(side(finger) * kTip, 0, 0);
    const Vector3 force(side(finger) * press(finger), 0, -carries(finger));
    std::vector<double> torques;
    for (int j = 0; j < kJoints; ++j) {
      Vector3 moment = (contact - frames[j].p).cross(force);
      for (int k = j; k < kJoints; ++k) {
        moment += (frames[k] * Vector3(0, 0, -kLength[k] / 2) - frames[j].p).cross(Vector3(0, 0, -kMass[k] * kG));
      }
      torques.push_back(-(frames[j].R * axis(j)).dot(moment));
    }
    return torques;
  }

  static WorldDef make(const WorldSettings& settings, double k) {
    WorldDef def;
    def.name = "hand_grasp";
    def.settings = settings;
    def.settings.gravity = Vector3(0, 0, -kG);
    ContactMaterial& m = def.settings.default_material;
    m.stiffness = k;
    m.dissipation = 10;
    m.mu_static = m.mu_dynamic = kMu;
    def.articulations.push_back(scenes::freeBox("bar", Vector3(kWidth, kLong, kWidth), kBar, Pose()));
    ArticulationDef hand = scenes::staticBox("hand", Vector3::Constant(0.1), Pose());
    hand.links[0].name = "palm";
    hand.links[0].collisions.clear();
    for (int f = 0; f < kFingers; ++f) {
      const std::vector<double> efforts = HandGrasp::efforts(f);
      for (int j = 0; j < kJoints; ++j) {
        LinkDef link;
        link.name = "finger" + std::to_string(f) + "_" + std::to_string(j);
        link.parent = j == 0 ? 0 : static_cast<int>(hand.links.size()) - 1;
        link.joint.name = link.name + "_joint";
        link.joint.type = JointType::kRevolute;
        link.joint.axis = axis(j);
        link.joint.X_PJ = Pose(j == 0 ? root(f, depth(press(f), k)) : Vector3(0, 0, -kLength[j - 1]));
        link.joint.position = bend(f, j);
        link.joint.drive = JointDef::Drive::kPosition;
        link.joint.drive_stiffness = kStiffness;
        link.joint.drive_damping = kDamping;
        link.joint.drive_effort = efforts[j];
        link.inertia.mass = kMass[j];
        link.inertia.p_LC = Vector3(0, 0, -kLength[j] / 2);
        link.inertia.I_C = scenes::boxInertia(Vector3(0.0196, 0.0275, kLength[j]), kMass[j]);
        hand.links.push_back(link);
      }
      CollisionDef tip;
      tip.name = "tip" + std::to_string(f);
      tip.shape = std::make_shared<Ball>(kTip);
      tip.X_LS = Pose(Vector3(0, 0, -kLength[kJoints - 1]));
      hand.links.back().collisions.push_back(tip);
    }
    def.articulations.push_back(hand);
    return def;
  }

  /// Where all links stay on a rigid bar.
  static std::vector<BodyState> states() {
    std::vector<BodyState> states(2);
    for (int f = 0; f < kFingers; ++f) {
      const std::vector<Pose> frames = chain(f);
      for (int j = 0; j < kJoints; ++j) states.push_back({Pose(root(f)) * frames[j], Twist{}});
    }
    return states;
  }
};

}  // namespace haptic::report
