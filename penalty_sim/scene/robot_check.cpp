/// The checks of joints.
#include <cmath>

#include "scene/joint_reading.h"
#include "scene/robot_file.h"

namespace haptic {
namespace {

/// kUnlimited, as a file that leaves out effort or velocity would write it.
constexpr char kNoLimit[] = "1e9";

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
  const double length = readVector(robot.xml, *axis, "xyz")->norm();
  if (std::abs(length - 1) > 1e-3) {
    robot.warnings.push_back(robot.at(joint) + ": its axis has length " + std::to_string(length) +
                             " and is normalised");
  }
}

void checkLimits(RobotFile& robot, const JointXml& joint) {
  XmlElement* limit = joint.element->FirstChildElement("limit");
  const bool needs_limits = joint.type == "revolute" || joint.type == "prismatic";
  if (joint.type == "fixed" || (!limit && !needs_limits)) return;
  if (!limit) {
    robot.warnings.push_back(robot.at(joint) + ": is " + joint.type +
                             " without <limit>: taken as unlimited; add <limit>");
    limit = joint.element->InsertNewChildElement("limit");
    limit->SetAttribute("lower", ("-" + std::string(kNoLimit)).c_str());
    limit->SetAttribute("upper", kNoLimit);
  }
  const double lower = needs_limits ? readNumber(robot.xml, *limit, "lower").value_or(0) : 0;
  const double upper = needs_limits ? readNumber(robot.xml, *limit, "upper").value_or(0) : 0;
  for (const char* drive : {"effort", "velocity"}) {
    if (!readNumber(robot.xml, *limit, drive)) limit->SetAttribute(drive, kNoLimit);
  }
  if (needs_limits && lower == upper) {
    robot.warnings.push_back(
        robot.at(joint) + ": lower and upper limit are both " + std::to_string(lower) +
        ": the joint cannot move (exporters write 0 for limits not set); give limits or type continuous");
  }
}

/// A joint that cannot follow moves by itself.
void checkMimic(RobotFile& robot, const JointXml& joint) {
  XmlElement* mimic = joint.element->FirstChildElement("mimic");
  if (!mimic) return;
  const std::string master = readName(robot.xml, *mimic, "joint");
  const auto leaveOut = [&](const std::string& why) {
    robot.replaced.push_back(robot.at(joint) + ": mimics joint '" + master + "', " + why
        + ": <mimic> is left out, and the joint moves by itself");
    joint.element->DeleteChild(mimic);
  };
  const int index = robot.jointIndex(master);
  if (index < 0) return leaveOut("which does not exist");
  // Follow the chain: more steps than joints means that it returns.
  const JointXml* at = &robot.joints[index];
  for (std::size_t steps = 0; at; ++steps) {
    if (at == &joint || steps > robot.joints.size()) return leaveOut("and so itself");
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
  std::string unused_efforts;
  const XmlElement* transmission = robot.xml.root()->FirstChildElement("transmission");
  for (; transmission; transmission = transmission->NextSiblingElement("transmission")) ++transmissions;
  name("<transmission>", transmissions, "drives act at the joints");
  for (const JointXml& joint : robot.joints) {
    const XmlElement* const limit = joint.element->FirstChildElement("limit");
    if (!joint.element->FirstChildElement("mimic") || !limit || !limit->Attribute("effort")) continue;
    ++efforts;
    unused_efforts += ", '" + joint.name + "' <limit> effort=\"" + limit->Attribute("effort") + "\"";
  }
  name("effort limits of joints that follow", efforts, "the drive that they follow works for both" + unused_efforts);
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
    checkMimic(robot, joint);
  }
}

}  // namespace haptic
