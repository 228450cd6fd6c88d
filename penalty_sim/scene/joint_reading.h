/// A URDF joint as the world's joint: type, axis, limits, dynamics, initial position, drive.
#pragma once
#include <string>
#include <vector>

#include "scene/robot_tree.h"

namespace haptic {

/// What <joint type=> and, on a floating one, <haptic:joint type=> say: a name of joint_type.h. Null: no known one.
const JointKind* kindOf(const JointXml& joint);
/// The names that `kindOf` knows, and how they are written.
std::string knownJointTypes();

/// Everything but X_PJ and mimic. The initial position is the one that the scene or <haptic:joint position=>
/// gives, otherwise the value nearest zero within the limits. Throws SetupError.
JointDef readJoint(const RobotFile& robot, const JointXml& xml, const ModelSettings& settings,
                   std::vector<std::string>& warnings);

/// <haptic:joint lead=> of a joint that turns, which makes it a screw: its link's way along the axis in a turn [m]; 0: there is none.
double readLead(const RobotFile& robot, const JointXml& xml);

/// Refuses a thread that cannot be, once mimics are known; a note tells the lead, the friction that locks, and the efficiency.
void checkThread(const std::string& where, const ArticulationDef& tree, const JointDef& joint, std::vector<std::string>& notes);

/// <haptic:joint angular= linear=> of a floating joint: initial twist in W.
Twist readInitialTwist(const RobotFile& robot, const JointXml& xml);

/// Joints with an effort limit > 0 and no gains of their own get those of a PD of 5 Hz, critically damped for the inertia
/// that hangs on them at the start: commands can move them.
void giveGains(ArticulationDef& articulation);

/// Joints with an effort limit > 0 hold their initial position with these gains and the force that carries their load
/// there: they stand up to gravity and give way to a hand.
void holdJoints(ArticulationDef& articulation, const Vector3& gravity, std::vector<std::string>& notes);

/// What a drive that follows positions has to give at the start.
struct HoldingEffort {
  std::string joint;         ///< its name
  double asked = 0;          ///< size of what gravity asks for, followers included; what the ground carries is not taken off [N·m] or [N]
  double limit = 0;          ///< effort [N·m] or [N]
  bool turns = false;        ///< N·m
};

/// Of all drives of a tree that follow positions and have a finite limit, at the initial pose.
std::vector<HoldingEffort> holdingEfforts(const ArticulationDef& articulation, const Vector3& gravity);

/// A joint that its drive cannot move.
struct IdleJoint {
  std::string joint;    ///< its name
  double effort = 0;    ///< its limit; 0 or infinite: there is no drive [N·m] or [N]
  double weight = 0;    ///< what gravity asks for at the start, followers included [N·m] or [N]
  double inertia = 0;   ///< of what hangs on it [kg·m²] or [kg]
  bool turns = false;   ///< N·m
};

/// Joints of one degree, followers left out, that must carry a weight and have no drive, or whose drive accelerates them by less than
/// kLeastAcceleration.
std::vector<IdleJoint> idleJoints(const ArticulationDef& articulation, const Vector3& gravity);

}  // namespace haptic
