/// Scenes after CENIC (Kurtz, Castro and others, arXiv 2511.08771), of shapes that need no mesh; sizes and masses ours: clutter in a bin, a
/// tippe top, a gripper that turns a body in its hand, steel rods. g = 9.81 m/s².
#pragma once
#include <cmath>

#include "balls.h"
#include "contactbench.h"
#include "haptic_core/geometry/shapes/rod.h"

namespace haptic::scenes {

inline WorldDef emptyScene(const std::string& name, const WorldSettings& settings, double k, double mu) {
  WorldDef def;
  def.name = name;
  def.settings = settings;
  def.settings.gravity = Vector3(0, 0, -kBallGravity);
  def.settings.default_material = ruledMaterial(k, mu);
  return def;
}

/// Boxes and balls in turn that fall into a bin, links 0 to 4.
struct Clutter {
  static constexpr int kBodies = 20, kWalls = 5;
  static constexpr double kEdge = 0.06, kMass = 0.2, kBin = 0.3, kWall = 0.2, kHeight = 1, kPitch = 0.12;  ///< [m], [kg]

  static WorldDef make(const WorldSettings& settings, double k) {
    WorldDef def = emptyScene("clutter", settings, k, 0.5);
    def.articulations.push_back(floorBox(2 * kBin, kWall));
    for (const int side : {-1, 1}) {
      const double away = side * 0.5 * (kBin + kWall);
      def.articulations.push_back(staticBox("wall_x", Vector3(kWall, 2 * kBin, kHeight), Pose(Vector3(away, 0, 0.5 * kHeight))));
      def.articulations.push_back(staticBox("wall_y", Vector3(kBin, kWall, kHeight), Pose(Vector3(0, away, 0.5 * kHeight))));
    }
    Offsets offsets;
    const auto ball = std::make_shared<Ball>(0.5 * kEdge);
    for (int i = 0; i < kBodies; ++i) {
      const Vector3 p((i % 2 - 0.5) * kPitch + 0.01 * offsets.next(), (i / 2 % 2 - 0.5) * kPitch + 0.01 * offsets.next(),
                      0.06 + i / 4 * 0.11);
      const double x = offsets.next(), y = offsets.next(), turn = M_PI * offsets.next();
      const Pose X_WL(rotationAbout(Vector3(x, y, 1).normalized(), turn), p);
      const std::string name = "body" + std::to_string(i);
      def.articulations.push_back(i / 2 % 2 == i % 2
                                      ? freeBox(name, Vector3::Constant(kEdge), kMass, X_WL)
                                      : freeBody(name, ball, kMass, 0.1 * kMass * kEdge * kEdge * Matrix3::Identity(), X_WL));
    }
    return def;
  }
};

/// A ball whose centre of mass lies below its centre: spun, it turns upside down. Of a rigid ball that touches a plane in a point no
/// friction changes Jellett's constant L·(a e - R z): L about the centre of mass, which lies by a below the centre along the axis e.
struct TippeTop {
  static constexpr double kRadius = 0.02, kOffset = 0.004, kMass = 0.02, kMu = 0.3;  ///< R [m], a [m], [kg], [1]
  static constexpr double kTilt = 0.1, kSpin = 150;                                  ///< of the axis at the start [rad], [rad/s]

  static WorldDef make(const WorldSettings& settings, double k) {
    WorldDef def = emptyScene("tippe top", settings, k, kMu);
    def.articulations.push_back(groundPlane());
    const double I = 0.4 * kMass * kRadius * kRadius;
    const Matrix3 R = rotationAbout(Vector3::UnitX(), kTilt);
    def.articulations.push_back(freeBody("top", std::make_shared<Ball>(kRadius), kMass, Vector3(1.05 * I, 1.05 * I, I).asDiagonal(),
                                         Pose(R, Vector3(kRadius * Vector3::UnitZ() - kOffset * R.col(2))),
                                         {kSpin * R.col(2), Vector3::Zero()}));
    def.articulations.back().links[0].collisions[0].X_LS.p.z() = kOffset;
    return def;
  }
  /// From the angular momentum about the centre of mass and the axis e, in W.
  static double jellett(const Vector3& L_C, const Vector3& axis) { return L_C.dot(kOffset * axis - kRadius * Vector3::UnitZ()); }
};

/// Two pads on slides press a capsule between them and move against one another, up and down: it turns in place by s/r, rigid.
struct TurningGripper {
  static constexpr double kRadius = 0.02, kLength = 0.04, kMass = 0.2, kMu = 0.8;  ///< of the capsule [m], [m], [kg], [1]
  static constexpr double kPad = 0.2, kCarriage = 0.05, kPress = 10;               ///< [kg], [kg], of each pad [N]
  static constexpr double kAcross = 2e3, kAlong = 2e4;                             ///< drives across and along the pads [N/m]
  static constexpr double kWay = 0.02, kSeconds = 1;                               ///< of a pad, up and down once [m], [s]
  static constexpr int kBody = 4;                                                  ///< link of the capsule

  static double way(double t) { return 0.5 * kWay * (1 - elementary::cos(2 * M_PI * t / kSeconds)); }
  static LinkDef slide(const std::string& name, int parent, const Vector3& axis, double mass, double stiffness) {
    LinkDef link;
    link.name = name;
    link.parent = parent;
    link.joint.name = name + "_joint";
    link.joint.type = JointType::kPrismatic;
    link.joint.axis = axis;
    link.joint.drive = JointDef::Drive::kPosition;
    link.joint.drive_stiffness = stiffness;
    link.joint.drive_damping = 2 * std::sqrt(stiffness * kPad);
    link.inertia.mass = mass;
    link.inertia.I_C = 1e-4 * Matrix3::Identity();  // slides do not turn
    return link;
  }
  static WorldDef make(const WorldSettings& settings, double k) {
    WorldDef def = emptyScene("turning gripper", settings, k, kMu);
    JointPathDef path;
    path.name = "gripper";
    const Vector3 pad(0.02, 0.08, 0.08);
    for (const int side : {-1, 1}) {
      ArticulationDef finger;
      finger.name = side < 0 ? "left" : "right";
      finger.links.push_back(slide(finger.name + "_carriage", -1, Vector3::UnitX(), kCarriage, kAcross));
      finger.links.push_back(slide(finger.name + "_pad", 0, Vector3::UnitZ(), kPad, kAlong));
      finger.links[1].joint.drive_effort = (kPad + 0.5 * kMass) * kBallGravity;
      CollisionDef face;
      face.name = finger.name;
      face.shape = box(pad);
      face.X_LS.p.x() = side * (kRadius + 0.5 * pad.x());
      finger.links[1].collisions.push_back(face);
      def.articulations.push_back(finger);
      path.joints.emplace_back(side > 0, 0), path.joints.emplace_back(side > 0, 1);
    }
    for (int ms = 0; ms <= std::lround(1e3 * kSeconds); ++ms) {
      path.time.push_back(1e-3 * ms);
      for (const int side : {-1, 1}) {
        path.position.push_back(-side * kPress / kAcross);
        path.position.push_back(-side * way(1e-3 * ms));
      }
    }
    def.joint_paths.push_back(path);
    const auto rod = std::make_shared<Rod>(kRadius, kLength, Rod::Ends::kRound);
    def.articulations.push_back(freeBody("capsule", rod, kMass, Matrix3::Zero(), Pose()));
    LinkDef& link = def.articulations.back().links[0];
    link.collisions[0].X_LS.R = rotationAbout(Vector3::UnitX(), 0.5 * M_PI);
    const Vector3 I = rod->massProperties(kMass / rod->volume()).I_com.diagonal();
    link.inertia.I_C = Vector3(I.x(), I.z(), I.y()).asDiagonal();
    return def;
  }
};

/// A steel rod falls across two that lie on the ground.
struct SteelRods {
  static constexpr double kRadius = 0.01, kLength = 0.3, kDensity = 7850, kApart = 0.16, kDrop = 0.02;  ///< [m], [m], [kg/m³], [m], [m]

  static WorldDef make(const WorldSettings& settings, double k) {
    WorldDef def = emptyScene("steel rods", settings, k, 0.3);
    def.articulations.push_back(groundPlane());
    const auto rod = std::make_shared<Rod>(kRadius, kLength, Rod::Ends::kRound);
    const double mass = kDensity * rod->volume();
    const Matrix3 along_y = rotationAbout(Vector3::UnitX(), 0.5 * M_PI), I = rod->massProperties(kDensity).I_com;
    for (const int side : {-1, 1}) {
      def.articulations.push_back(freeBody(side < 0 ? "left" : "right", rod, mass, I,
                                           Pose(along_y, Vector3(side * 0.5 * kApart, 0, kRadius))));
    }
    const Matrix3 across = rotationAbout(Vector3::UnitZ(), 0.2) * rotationAbout(Vector3::UnitY(), 0.5 * M_PI - 0.1);
    def.articulations.push_back(freeBody("across", rod, mass, I, Pose(across, Vector3(0.01, 0.02, 3 * kRadius + kDrop))));
    return def;
  }
};

}  // namespace haptic::scenes
