#include "scene/joint_reading.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "haptic_core/dynamics/thread.h"
#include "scene/link_inertia.h"
#include "scene/number_bounds.h"

namespace haptic {
namespace {

constexpr double kMetricAngle = M_PI / 3;  ///< between the flanks of ISO 68's threads [rad]
constexpr double kHoldFrequency = 5;  ///< [Hz]; see giveGains

double bounded(double limit) {
  return std::abs(limit) >= kUnlimited ? std::copysign(INFINITY, limit) : limit;
}

void readLimits(const RobotFile& robot, const JointXml& xml, JointDef& joint) {
  const XmlElement* limit = xml.element->FirstChildElement("limit");
  if (!limit) return;
  if (xml.type == "revolute" || xml.type == "prismatic") {
    joint.lower = bounded(readNumber(robot.xml, *limit, "lower").value_or(0));
    joint.upper = bounded(readNumber(robot.xml, *limit, "upper").value_or(0));
  }
  joint.max_effort = bounded(*readNumber(robot.xml, *limit, "effort"));
  joint.max_velocity = bounded(*readNumber(robot.xml, *limit, "velocity"));
}

void readExtension(const RobotFile& robot, const JointXml& xml, JointDef& joint,
                   std::optional<double>& position) {
  if (!xml.extension) return;
  const XmlElement& tag = *xml.extension;
  refuseUnknownAttributes(
      robot.xml, tag,
      {"type", "position", "velocity", "linear", "angular", "drive", "drive_stiffness", "drive_damping", "spring_stiffness",
       "spring_position", "lead", "thread_diameter", "thread_angle", "thread_friction"});
  position = readNumber(robot.xml, tag, "position");
  joint.velocity = readNumber(robot.xml, tag, "velocity").value_or(0);
  if (const char* drive = tag.Attribute("drive")) {
    const std::string name = drive;
    if (name == "none")
      joint.drive = JointDef::Drive::kNone;
    else if (name == "effort")
      joint.drive = JointDef::Drive::kEffort;
    else if (name == "velocity")
      joint.drive = JointDef::Drive::kVelocity;
    else if (name == "position")
      joint.drive = JointDef::Drive::kPosition;
    else
      throw SetupError(robot.at(xml), "drive '" + name + "' is unknown",
                       "known: none, effort, velocity, position");
  }
  joint.drive_stiffness = readNumber(robot.xml, tag, "drive_stiffness").value_or(0);
  joint.drive_damping = readNumber(robot.xml, tag, "drive_damping").value_or(0);
  if (joint.drive_stiffness < 0 || joint.drive_damping < 0) {
    throw SetupError(robot.at(xml), "its drive has a negative stiffness or damping", "write values ≥ 0");
  }
  joint.spring_stiffness = readNumber(robot.xml, tag, "spring_stiffness").value_or(0);
  joint.spring_position = readNumber(robot.xml, tag, "spring_position").value_or(0);
  if (joint.spring_stiffness < 0) throw SetupError(robot.at(xml), "its spring has a negative stiffness", "write a value ≥ 0");
  if ((tag.Attribute("spring_stiffness") || tag.Attribute("spring_position")) && !isScalar(joint.type)) {
    throw SetupError(robot.at(xml), "springs are for joints of one degree", "take spring_stiffness and spring_position out");
  }
  joint.thread_friction = readNumber(robot.xml, tag, "thread_friction").value_or(0);
  joint.thread_radius = 0.5 * readNumber(robot.xml, tag, "thread_diameter").value_or(0);
  joint.thread_flank = 0.5 * readNumber(robot.xml, tag, "thread_angle").value_or(kMetricAngle);
}

/// What hangs on joint `first`, at the initial pose: its load on the joint per unit of acceleration, and under gravity.
struct Load {
  double mass = 0;     ///< [kg]
  double inertia = 0;  ///< about the axis; mass for a sliding joint [kg·m²] or [kg]
  double weight = 0;   ///< force of gravity along the joint [N·m] or [N]
};

Load loadBeyond(const ArticulationDef& articulation, const std::vector<Pose>& X_WL, std::size_t first,
                const Vector3& gravity) {
  std::vector<bool> beyond(articulation.links.size(), false);
  beyond[first] = true;
  Load load;
  const JointDef& joint = articulation.links[first].joint;
  const Vector3 axis_W = X_WL[first].R * joint.axis;  // the axis is the same in J and in the child's frame
  for (std::size_t i = first; i < articulation.links.size(); ++i) {
    const LinkDef& link = articulation.links[i];
    if (i != first) beyond[i] = link.parent >= 0 && beyond[link.parent];
    if (!beyond[i]) continue;
    const Vector3 weight = link.inertia.mass * gravity;
    load.mass += link.inertia.mass;
    if (kindOf(joint.type).slides) {
      load.inertia += link.inertia.mass;
      load.weight += axis_W.dot(weight);
    } else {
      const Vector3 r = X_WL[i] * link.inertia.p_LC - X_WL[first].p;
      load.inertia += axis_W.dot(X_WL[i].R * link.inertia.I_C * X_WL[i].R.transpose() * axis_W) +
                      link.inertia.mass * r.cross(axis_W).squaredNorm();
      load.weight += axis_W.dot(r.cross(weight));
    }
  }
  return load;
}

/// What gravity and the joint's spring ask of joint i's drive at the initial pose [N·m] or [N].
double weightOn(const ArticulationDef& articulation, const std::vector<Pose>& X_WL, std::size_t i, const Vector3& gravity) {
  const JointDef& joint = articulation.links[i].joint;
  double weight = loadBeyond(articulation, X_WL, i, gravity).weight + joint.spring_stiffness * (joint.spring_position - joint.position);
  for (std::size_t f = 0; f < articulation.links.size(); ++f) {  // its followers' weight comes back through it
    const JointDef& follower = articulation.links[f].joint;
    if (follower.mimic_joint != static_cast<int>(i)) continue;
    weight += follower.mimic_multiplier * loadBeyond(articulation, X_WL, f, gravity).weight;
  }
  return weight;
}

bool hasMotor(const JointDef& joint) {
  return isScalar(joint.type) && std::isfinite(joint.max_effort) && joint.max_effort > 0 && joint.mimic_joint < 0;
}

}  // namespace

const JointKind* kindOf(const JointXml& joint) {
  const char* extended = joint.extension ? joint.extension->Attribute("type") : nullptr;
  const JointKind* const kind = jointKind(joint.type == "continuous" ? "revolute" : joint.type);
  if (!extended) return kind && kind->in_urdf ? kind : nullptr;
  const JointKind* const other = jointKind(extended);
  return kind && kind->floating && other && !other->in_urdf ? other : nullptr;
}

std::string knownJointTypes() {
  std::string in_urdf = "continuous", extended;
  for (const JointKind& kind : kJointKinds) {
    if (kind.in_urdf) {
      in_urdf += std::string(", ") + kind.name;
    } else {
      extended += std::string("; ") + kind.name + ": type floating with <haptic:joint type=\"" + kind.name + "\"/>";
    }
  }
  return "known: " + in_urdf + extended;
}

JointDef readJoint(const RobotFile& robot, const JointXml& xml, const ModelSettings& settings,
                   std::vector<std::string>& warnings) {
  JointDef joint;
  joint.name = settings.prefix + xml.name;
  joint.type = kindOf(xml)->type;
  const XmlElement* const axis = xml.element->FirstChildElement("axis");
  if (axis && hasAxis(*kindOf(xml))) joint.axis = readVector(robot.xml, *axis, "xyz")->normalized();
  readLimits(robot, xml, joint);
  if (const XmlElement* const dynamics = xml.element->FirstChildElement("dynamics")) {
    joint.damping = readNumber(robot.xml, *dynamics, "damping").value_or(0);
    joint.friction = readNumber(robot.xml, *dynamics, "friction").value_or(0);
  }
  std::optional<double> position;
  readExtension(robot, xml, joint, position);
  const auto set = settings.joints.find(xml.name);
  if (set != settings.joints.end()) position = set->second;
  joint.position = std::clamp(position.value_or(0), joint.lower, joint.upper);
  if (position && joint.position != *position) {
    std::ostringstream text;
    text << robot.at(xml) << ": initial position " << *position << " is outside its limits; starts at "
         << joint.position;
    warnings.push_back(text.str());
  }
  return joint;
}

double readLead(const RobotFile& robot, const JointXml& xml) {
  const double lead = xml.extension ? readNumber(robot.xml, *xml.extension, "lead").value_or(0) : 0;
  if (lead != 0 && (xml.type != "revolute" && xml.type != "continuous")) {
    throw SetupError(robot.at(xml), "lead is for joints that turn", "give it to a revolute or continuous joint");
  }
  return lead;
}

void checkThread(const std::string& where, const ArticulationDef& tree, const JointDef& joint, std::vector<std::string>& notes) {
  if (joint.thread_friction == 0 && joint.thread_radius == 0) return;
  const bool slides = joint.type == JointType::kPrismatic && joint.mimic_joint >= 0;
  if (!slides || !kindOf(tree.links[joint.mimic_joint].joint.type).turns) {
    throw SetupError(where, "it has a thread and is no screw", "give it a lead, or let this slide mimic a joint that turns");
  }
  const Thread thread(joint);
  if (!(joint.thread_friction >= 0) || !(joint.thread_radius > 0) || !(joint.thread_flank >= 0 && joint.thread_flank < 1.5)) {
    throw SetupError(where, "its thread_friction must be >= 0, thread_diameter > 0 (the pitch diameter in m), thread_angle from 0 to 3 rad",
                     "write such numbers");
  }
  std::ostringstream text;
  text.precision(3);
  text << "a friction of " << joint.thread_friction << " holds its thread at every torque";
  if (!thread.turns()) throw SetupError(where, text.str(), "lower thread_friction, or the lead over thread_diameter");
  text.str("");
  text << "screw '" << tree.links[joint.mimic_joint].joint.name << "': lead " << 2e3 * M_PI * joint.mimic_multiplier
       << " mm, locks from a thread friction of " << thread.lockingFriction() << " on and has " << joint.thread_friction
       << ", efficiency " << 100 * thread.efficiency() << " %";
  notes.push_back(text.str());
}

Twist readInitialTwist(const RobotFile& robot, const JointXml& xml) {
  Twist V;
  if (!xml.extension) return V;
  V.angular = readVector(robot.xml, *xml.extension, "angular").value_or(Vector3::Zero());
  V.linear = readVector(robot.xml, *xml.extension, "linear").value_or(Vector3::Zero());
  if (xml.type != "floating" && (!V.angular.isZero() || !V.linear.isZero())) {
    throw SetupError(robot.at(xml), "linear and angular are for floating joints", "take them out");
  }
  return V;
}

void giveGains(ArticulationDef& articulation) {
  const std::vector<Pose> X_WL = initialPoses(articulation);
  for (std::size_t i = 0; i < articulation.links.size(); ++i) {
    JointDef& joint = articulation.links[i].joint;
    if (!hasMotor(joint) || joint.drive_stiffness > 0 || joint.drive_damping > 0) continue;
    const double inertia = loadBeyond(articulation, X_WL, i, Vector3::Zero()).inertia;
    const double omega = 2 * M_PI * kHoldFrequency;
    joint.drive_stiffness = inertia * omega * omega;
    joint.drive_damping = 2 * inertia * omega;
  }
}

void holdJoints(ArticulationDef& articulation, const Vector3& gravity, std::vector<std::string>& notes) {
  const std::vector<Pose> X_WL = initialPoses(articulation);
  int held = 0, joints = 0;
  for (std::size_t i = 0; i < articulation.links.size(); ++i) {
    JointDef& joint = articulation.links[i].joint;
    if (!isScalar(joint.type)) continue;
    ++joints;
    if (!hasMotor(joint) || joint.drive != JointDef::Drive::kNone) continue;
    joint.drive = JointDef::Drive::kPosition;
    const double weight = weightOn(articulation, X_WL, i, gravity);
    joint.drive_effort = std::clamp(-weight, -joint.max_effort, joint.max_effort);
    ++held;
  }
  if (joints == 0) return;
  std::ostringstream text;
  text << "'" << articulation.name << "': " << held << " of " << joints
       << " joints have a drive and hold their initial position (PD of " << kHoldFrequency
       << " Hz, critically damped, gravity compensated there, within the effort limits); drive: free in a scene list lets "
          "them go";
  notes.push_back(text.str());
}

std::vector<HoldingEffort> holdingEfforts(const ArticulationDef& articulation, const Vector3& gravity) {
  const std::vector<Pose> X_WL = initialPoses(articulation);
  std::vector<HoldingEffort> efforts;
  for (std::size_t i = 0; i < articulation.links.size(); ++i) {
    const JointDef& joint = articulation.links[i].joint;
    if (!hasMotor(joint) || joint.drive != JointDef::Drive::kPosition) continue;
    efforts.push_back({joint.name, std::abs(weightOn(articulation, X_WL, i, gravity)), joint.max_effort, kindOf(joint.type).turns > 0});
  }
  return efforts;
}

std::vector<IdleJoint> idleJoints(const ArticulationDef& articulation, const Vector3& gravity) {
  constexpr double kCarried = 1e-2;  // of the weight at its full lever: with less a joint hangs, or its axis is upright [1]
  const std::vector<Pose> X_WL = initialPoses(articulation);
  std::vector<IdleJoint> idle;
  for (std::size_t i = 0; i < articulation.links.size(); ++i) {
    const JointDef& joint = articulation.links[i].joint;
    if (!isScalar(joint.type) || joint.mimic_joint >= 0) continue;
    const bool turns = kindOf(joint.type).turns > 0;
    const Load load = loadBeyond(articulation, X_WL, i, Vector3::Zero());
    const double weight = std::abs(weightOn(articulation, X_WL, i, gravity));
    const bool carries = weight > kCarried * gravity.norm() * (turns ? std::sqrt(load.inertia * load.mass) : load.mass);
    const bool weak = hasMotor(joint) && joint.max_effort < kLeastAcceleration * load.inertia;
    if (hasMotor(joint) ? weak : carries && joint.drive == JointDef::Drive::kNone)
      idle.push_back({joint.name, joint.max_effort, weight, load.inertia, turns});
  }
  return idle;
}

}  // namespace haptic
