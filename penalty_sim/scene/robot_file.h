/// A URDF file, read from its XML: urdfdom has no line numbers and drops haptic: tags, contact properties and
/// shapes that it does not know. It also prints texts of a file as formats, which ends the process.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scene/scene_options.h"
#include "scene/xml_file.h"

namespace haptic {

/// A link of a URDF file, with its XML element.
struct LinkXml {
  /// In the file, without prefix.
  std::string name;
  /// The `<link>`.
  XmlElement* element = nullptr;
  /// Its `<collision>` elements.
  std::vector<XmlElement*> collisions;
  std::vector<int> child_joints;  ///< indices in RobotFile::joints, in the order of the file
  int parent_joint = -1;          ///< -1: the root
  bool spread_inertia = false;    ///< its mass is to be spread over its shapes: the file's moments are none
};

/// A joint of a URDF file, with its XML element.
struct JointXml {
  /// In the file, without prefix; URDF's type.
  std::string name, type;
  /// The `<joint>`.
  XmlElement* element = nullptr;
  XmlElement* extension = nullptr;  ///< <haptic:joint>, when there is one
  int parent = -1, child = -1;      ///< indices in RobotFile::links
  bool says_effort = false;         ///< <limit effort=> stands in the file
};

/// A checked robot: one root, no loop, no name twice, numbers made sound (sound_numbers.h).
struct RobotFile {
  /// Parses `text`, which `path` stands for; `readRobot` fills in the rest.
  RobotFile(const std::string& path, const std::string& text) : xml(path, text) {}

  /// The parsed file.
  XmlFile xml;
  /// Of the robot.
  std::string name;
  /// In the order of the file.
  std::vector<LinkXml> links;
  /// In the order of the file.
  std::vector<JointXml> joints;
  /// Index of the link without parent.
  int root = -1;
  /// What a user should mend.
  std::vector<std::string> warnings;
  /// What a user may want to know.
  std::vector<std::string> notes;
  std::vector<std::string> replaced;  ///< numbers that cannot be right, and what stands in their place
  int collisions_left_out = 0;        ///< whose sizes cannot be right
  int inertials_left_out = 0;         ///< whose masses cannot be right

  /// "path:line: link 'name'".
  std::string at(const LinkXml& link) const { return xml.at(*link.element) + ": link '" + link.name + "'"; }
  /// "path:line: joint 'name'".
  std::string at(const JointXml& joint) const {
    return xml.at(*joint.element) + ": joint '" + joint.name + "'";
  }
  int linkIndex(const std::string& link) const;  ///< -1 when there is none
  /// -1 when there is none.
  int jointIndex(const std::string& joint) const;
};

/// Reads and checks `path`, or SceneOptions::text in its place; xacro goes through the program of this name (xacro_run.h). Throws
/// SetupError naming file, line, link or joint.
std::unique_ptr<RobotFile> readRobot(const std::string& path, const SceneOptions& options);

/// Checks every joint's type, axis, limits and mimic, and fills in what URDF makes optional. Throws
/// SetupError; what can be mended is mended with a warning.
void checkJoints(RobotFile& robot);

}  // namespace haptic
