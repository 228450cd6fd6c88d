/// Definition of a tree of bodies, by the user: inertia, joints, parents. No shapes here.
#pragma once
#include <limits>
#include <string>
#include <vector>

#include "haptic_core/base/spatial.h"
#include "haptic_core/dynamics/joint_type.h"

namespace haptic {

/// Mass, centre of mass and inertia of a link.
struct LinkInertia {
  double mass = 0;                          ///< [kg]
  Vector3 p_LC = Vector3::Zero();           ///< centre of mass in the link frame [m]
  Matrix3 I_C = Matrix3::Zero();            ///< inertia about the centre of mass, link axes [kg·m²]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.mass), visit(s.p_LC), visit(s.I_C);
  }
};

/// A joint from a parent link P to its child link. `q` is 0 where the child frame coincides with the joint frame J.
struct JointDef {
  std::string name;                         ///< for messages, and where joints are asked for by name
  JointType type = JointType::kFloating;    ///< kind of motion, see joint_type.h
  Pose X_PJ;                                ///< joint frame in the parent's link frame (in A for a root)
  Vector3 axis = Vector3::UnitX();          ///< unit axis in J: of rotation, of sliding, or normal of the plane
  double lower = -std::numeric_limits<double>::infinity();  ///< [rad] or [m]; infinite: none (continuous)
  double upper = std::numeric_limits<double>::infinity();   ///< [rad] or [m]; infinite: none
  double max_effort = std::numeric_limits<double>::infinity();    ///< limit of the drive [N·m] or [N]
  double max_velocity = std::numeric_limits<double>::infinity();  ///< limit of the drive [rad/s] or [m/s]
  double damping = 0;                       ///< [N·m·s/rad] or [N·s/m]
  double friction = 0;                      ///< Coulomb, sticks: [N·m] or [N]
  double position = 0;                      ///< initial q (one-degree joints)
  double velocity = 0;                      ///< initial q̇ (one-degree joints) [rad/s] or [m/s]
  int mimic_joint = -1;                     ///< index of the link whose joint is followed: q = multiplier q' + offset
  double mimic_multiplier = 1, mimic_offset = 0;  ///< m and c of q = m q' + c; c in [rad] or [m]
  // Thread of a slide that follows a turn, as a nut does: friction between the two, see thread.h.
  double thread_friction = 0;               ///< Coulomb, of the flanks [1]; 0: none
  double thread_radius = 0;                 ///< half of the pitch diameter [m]
  double thread_flank = 0;                  ///< half of the angle between the flanks [rad]
  /// Quantity that the drive follows: none, an effort, a velocity or a position. A command may change it while
  /// running.
  enum class Drive : unsigned char { kNone, kEffort, kVelocity, kPosition } drive = Drive::kNone;
  double drive_stiffness = 0;               ///< PD: [N·m/rad] or [N/m]
  double drive_damping = 0;                 ///< PD: [N·m·s/rad] or [N·s/m]
  double drive_effort = 0;                  ///< feed-forward until a command says otherwise [N·m] or [N]
  double spring_stiffness = 0;              ///< of a spring beside the drive [N·m/rad] or [N/m]; one-degree joints
  double spring_position = 0;               ///< where that spring rests [rad] or [m]

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.name), visit(s.type), visit(s.X_PJ), visit(s.axis), visit(s.lower), visit(s.upper);
    visit(s.max_effort), visit(s.max_velocity), visit(s.damping), visit(s.friction), visit(s.position);
    visit(s.velocity), visit(s.mimic_joint), visit(s.mimic_multiplier), visit(s.mimic_offset);
    visit(s.thread_friction), visit(s.thread_radius), visit(s.thread_flank);
    visit(s.drive), visit(s.drive_stiffness), visit(s.drive_damping), visit(s.drive_effort);
    visit(s.spring_stiffness), visit(s.spring_position);
  }
};

/// A link as dynamics sees it: a rigid body on a joint.
struct BodyDef {
  std::string name;                         ///< of the link, unique in a scene
  int parent = -1;                          ///< index in the articulation, smaller than the link's own; -1: the world
  JointDef joint;                           ///< how it hangs on its parent
  LinkInertia inertia;                      ///< of this body alone

  template <class Self, class Visit>
  static void eachField(Self& s, Visit&& visit) {
    visit(s.name), visit(s.parent), visit(s.joint), visit(s.inertia);
  }
};

/// A tree (or several: every link without parent starts one) of bodies.
struct TreeDef {
  std::string name;                         ///< for messages
  std::vector<BodyDef> links;               ///< parents before children
  Pose X_WA;                                ///< initial pose of the frame A that root joints are given in
  Twist V_WA;                               ///< initial twist of a floating root, at A's origin, in W
};

}  // namespace haptic
