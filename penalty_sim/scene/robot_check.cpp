/// The checks of joints and inertials.
#include <cmath>

#include "scene/joint_reading.h"
#include "scene/robot_file.h"

namespace haptic {
namespace {

/// Stands for "no limit" in a file that leaves out effort or velocity: beyond any drive.
constexpr char kUnlimited[] = "1e9";

XmlElement& childOrNew(XmlElement& parent, const char* name) {
  XmlElement* element = parent.FirstChildElement(name);
  return element ? *element : *parent.InsertNewChildElement(name);
}

void checkAxis(RobotFile& robot, const JointXml& joint) {
  XmlElement* axis = joint.element->FirstChildElement("axis");
  if (!hasAxis(*kindOf(joint))) {
    if (axis) joint.element->DeleteChild(axis);  // means nothing here; published files leave zeros in it
    return;
  }
  if (!axis || !axis->Attribute("xyz")) {
    robot.warnings.push_back(robot.at(joint) +
                             ": has no <axis xyz=...>: URDF's default 1 0 0 is taken; write the axis");
    if (axis) axis->SetAttribute("xyz", "1 0 0");
    return;
  }
  const Vector3 direction = *readVector(robot.xml, *axis, "xyz");
  const double length = direction.norm();
  // Below this a direction is rounding, not a statement; files write axes with a few digits.
  if (length < 1e-6)
    throw SetupError(robot.at(joint), "its axis is zero", "give the axis a direction, e.g. 0 0 1");
  if (std::abs(length - 1) > 1e-3) {
    robot.warnings.push_back(robot.at(joint) + ": its axis has length " + std::to_string(length) +
                             " and is normalised");
  }
}

void checkLimits(RobotFile& robot, const JointXml& joint) {
  XmlElement* limit = joint.element->FirstChildElement("limit");
  const bool needs_limits = joint.type == "revolute" || joint.type == "prismatic";
  if (!limit && !needs_limits) return;
  if (!limit) {
    robot.warnings.push_back(robot.at(joint) + ": is " + joint.type +
                             " without <limit>: taken as unlimited; add <limit>");
    limit = joint.element->InsertNewChildElement("limit");
    limit->SetAttribute("lower", ("-" + std::string(kUnlimited)).c_str());
    limit->SetAttribute("upper", kUnlimited);
  }
  const double lower = readNumber(robot.xml, *limit, "lower").value_or(0);
  const double upper = readNumber(robot.xml, *limit, "upper").value_or(0);
  for (const char* drive : {"effort", "velocity"}) {
    const auto value = readNumber(robot.xml, *limit, drive);
    if (!value) {
      limit->SetAttribute(drive, kUnlimited);
    } else if (*value < 0) {
      throw SetupError(robot.at(joint), std::string("its ") + drive + " limit is negative",
                       "write its size, or 0 for no drive");
    }
  }
  if (needs_limits && lower > upper) {
    throw SetupError(
        robot.at(joint),
        "its limits are upside down: lower " + std::to_string(lower) + " > upper " + std::to_string(upper),
        "swap them");
  }
  if (needs_limits && lower == upper) {
    robot.warnings.push_back(
        robot.at(joint) + ": lower and upper limit are both " + std::to_string(lower) +
        ": the joint cannot move (exporters write 0 for limits not set); give limits or type continuous");
  }
}

void checkDynamics(RobotFile& robot, const JointXml& joint) {
  const XmlElement* dynamics = joint.element->FirstChildElement("dynamics");
  if (!dynamics) return;
  const auto damping = readNumber(robot.xml, *dynamics, "damping");
  const auto friction = readNumber(robot.xml, *dynamics, "friction");
  for (const auto& value : {damping, friction}) {
    if (value && *value < 0) {
      throw SetupError(robot.at(joint), "its damping or friction is negative: it would drive the joint",
                       "write a value ≥ 0");
    }
  }
}

void checkMimic(RobotFile& robot, const JointXml& joint) {
  const XmlElement* mimic = joint.element->FirstChildElement("mimic");
  if (!mimic) return;
  const std::string master = readName(robot.xml, *mimic, "joint");
  readNumber(robot.xml, *mimic, "multiplier");
  readNumber(robot.xml, *mimic, "offset");
  const int index = robot.jointIndex(master);
  if (index < 0) {
    throw SetupError(robot.at(joint), "mimics joint '" + master + "', which does not exist",
                     "mend the name or take <mimic> out");
  }
  // Follow the chain: more steps than joints means that it returns.
  const JointXml* at = &robot.joints[index];
  for (std::size_t steps = 0; at; ++steps) {
    if (at == &joint || steps > robot.joints.size()) {
      throw SetupError(robot.at(joint), "mimics itself through '" + master + "'",
                       "let one joint of the ring move freely");
    }
    const XmlElement* next = at->element->FirstChildElement("mimic");
    const int follow = next && next->Attribute("joint") ? robot.jointIndex(next->Attribute("joint")) : -1;
    at = follow >= 0 ? &robot.joints[follow] : nullptr;
  }
}

/// Elements that the simulation has no use for, in one line.
void dropUnused(RobotFile& robot) {
  const struct {
    const char *element, *why;
  } unused[] = {{"safety_controller", "soft limits of a controller; <limit> holds"}, {"calibration", "drives know where they are"}};
  std::string list;
  const auto name = [&](const std::string& element, std::size_t count, const std::string& why) {
    if (count == 0) return;
    list += (list.empty() ? "" : ", ") + std::to_string(count) + " " + element + " (" + why + ")";
  };
  for (const auto& [element, why] : unused) {
    std::size_t count = 0;
    for (const JointXml& joint : robot.joints) {
      const XmlElement* const first = joint.element->FirstChildElement(element);
      count += first != nullptr;
      while (XmlElement* each = joint.element->FirstChildElement(element)) joint.element->DeleteChild(each);
    }
    name("<" + std::string(element) + ">", count, why);
  }
  std::size_t transmissions = 0, efforts = 0;
  const XmlElement* transmission = robot.xml.root()->FirstChildElement("transmission");
  for (; transmission; transmission = transmission->NextSiblingElement("transmission")) ++transmissions;
  name("<transmission>", transmissions, "drives act at the joints");
  for (const JointXml& joint : robot.joints) {
    const XmlElement* const limit = joint.element->FirstChildElement("limit");
    efforts += joint.element->FirstChildElement("mimic") && limit && limit->Attribute("effort");
  }
  name("effort limits of joints that follow", efforts, "the drive that they follow works for both");
  if (!list.empty()) robot.notes.push_back(robot.xml.path() + ": ignored: " + list);
}

}  // namespace

void checkJoints(RobotFile& robot) {
  dropUnused(robot);
  for (const JointXml& joint : robot.joints) {
    if (!kindOf(joint)) {
      const char* extended = joint.extension ? joint.extension->Attribute("type") : nullptr;
      const std::string type = "type '" + joint.type + "'";
      throw SetupError(robot.at(joint),
                       extended ? type + " with <haptic:joint type=\"" + extended + "\"/> is unknown" : type + " is unknown",
                       knownJointTypes());
    }
    readOrigin(robot.xml, *joint.element);
    checkAxis(robot, joint);
    checkLimits(robot, joint);
    checkDynamics(robot, joint);
    checkMimic(robot, joint);
  }
}

void checkInertials(RobotFile& robot) {
  for (LinkXml& link : robot.links) {
    XmlElement* inertial = link.element->FirstChildElement("inertial");
    if (!inertial) continue;
    readOrigin(robot.xml, *inertial);
    const XmlElement* mass_element = inertial->FirstChildElement("mass");
    if (!mass_element)
      throw SetupError(robot.at(link), "its <inertial> has no <mass>", "add <mass value=\"...\"/>");
    const auto mass = readNumber(robot.xml, *mass_element, "value");
    if (!mass) throw SetupError(robot.at(link), "its <mass> has no value", "write value=\"...\" in kg");
    if (*mass < 0) throw SetupError(robot.at(link), "its mass is negative", "write a mass > 0");
    XmlElement& inertia = childOrNew(*inertial, "inertia");
    for (const char* entry : {"ixx", "iyy", "izz", "ixy", "ixz", "iyz"}) {
      const auto value = readNumber(robot.xml, inertia, entry);
      if (value) continue;
      const bool diagonal = entry[1] == entry[2];
      if (diagonal && *mass > 0) {
        throw SetupError(robot.at(link), std::string("its <inertia> has no ") + entry,
                         "give all of ixx, iyy, izz");
      }
      inertia.SetAttribute(entry, "0");
    }
  }
}

}  // namespace haptic
