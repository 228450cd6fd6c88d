#include "scene/motion_reading.h"

#include <algorithm>
#include <cstring>

#include "haptic_core/base/error.h"
#include "haptic_core/world/led_motion.h"
#include "scene/number_table.h"
#include "scene/resource_path.h"
#include "scene/scene_extension.h"
#include "scene/topic_name.h"

namespace haptic {
namespace {

/// Rows of a file as poses of the link, which lies at X_FL in the named frame.
void readPath(const std::string& path, const Pose& X_WM, const Pose& X_FL, const Pose& X_WF_start, MotionDef& motion) {
  const std::vector<std::string> places = {"time", "x", "y", "z"}, poses = {"time", "x", "y", "z", "roll", "pitch", "yaw"};
  const NumberTable table = readNumberTable(path, "time,x,y,z,roll,pitch,yaw");
  if (table.columns != places && table.columns != poses) {
    throw SetupError(table.where_head, "names other columns", "begin with time,x,y,z or time,x,y,z,roll,pitch,yaw");
  }
  for (const NumberTable::Row& row : table.rows) {
    const std::vector<double>& n = row.numbers;
    const Matrix3 R_MF = n.size() > 4 ? rotationFromRpy(Vector3(n[4], n[5], n[6])) : Matrix3(X_WM.R.transpose() * X_WF_start.R);
    const Pose X_WL = X_WM * Pose(R_MF, Vector3(n[1], n[2], n[3])) * X_FL;
    motion.time.push_back(n[0]);
    motion.pose.push_back(X_WL);
  }
  const PathFault fault = faultOf(motion);
  if (fault.row >= 0) throw SetupError(table.rows[static_cast<std::size_t>(fault.row)].where, fault.what, fault.remedy);
}

bool readFlag(const XmlFile& file, const XmlElement& tag, const char* name) {
  const char* text = tag.Attribute(name);
  if (!text || std::strcmp(text, "false") == 0) return false;
  if (std::strcmp(text, "true") == 0) return true;
  throw SetupError(file.at(tag) + ": <" + tag.Name() + ">", std::string(name) + " = '" + text + "'", "write true or false");
}

}  // namespace

void readMotion(const RobotFile& robot, const XmlElement& tag, const ModelSettings& settings, LoadContext& context) {
  const std::string where = robot.xml.at(tag) + ": <haptic:motion>";
  refuseUnknownAttributes(robot.xml, tag, {"link", "file", "repeat", "topic", "tf"});
  const std::string name = settings.prefix + readName(robot.xml, tag, "link");
  const FramePlace place = findFrame(context, name, where);
  std::vector<ArticulationDef>& articulations = context.scene.world.articulations;
  const bool is_free = place.articulation >= 0 && articulations[place.articulation].links.size() == 1 &&
                       articulations[place.articulation].links[0].joint.type == JointType::kFloating;
  if (!is_free) {
    throw SetupError(where, "link '" + name + "' hangs on joints or is fixed",
                     "hang it on world by a floating joint, or drive its joint");
  }
  const int sources = (tag.Attribute("file") != nullptr) + (tag.Attribute("topic") != nullptr) + (tag.Attribute("tf") != nullptr);
  if (sources != 1) throw SetupError(where, "gets " + std::to_string(sources) + " sources", "give one of file, topic and tf");
  MotionDef motion;
  motion.name = name;
  motion.articulation = place.articulation;
  motion.link = place.link;
  motion.repeat = readFlag(robot.xml, tag, "repeat");
  ArticulationDef& body = articulations[place.articulation];
  if (tag.Attribute("file")) {
    const std::string path = resolveResource(readName(robot.xml, tag, "file"), robot.xml.path());
    if (path.empty()) throw SetupError(where, std::string("file '") + tag.Attribute("file") + "' is not found", "mend the path");
    readPath(path, settings.X_WM, place.X_LF.inverse(), initialPoses(body)[0] * place.X_LF, motion);
    body.X_WA = motion.pose.front();
    body.links[0].joint.X_PJ = Pose();
    body.V_WA = Twist{};
  } else {
    if (motion.repeat) throw SetupError(where, "repeats what is told pose by pose", "take repeat out, or give a file");
    ToldMotion told;
    told.motion = static_cast<int>(context.scene.world.motions.size());
    told.X_FL = place.X_LF.inverse();
    if (tag.Attribute("topic")) told.topic = readName(robot.xml, tag, "topic");
    if (!told.topic.empty() && !isTopicName(told.topic)) {
      throw SetupError(where, "topic '" + told.topic + "' is no name of ROS", kTopicNameRemedy);
    }
    if (tag.Attribute("tf")) told.frame = readName(robot.xml, tag, "tf");
    context.scene.told_motions.push_back(told);
  }
  const auto same = [&](const MotionDef& other) { return other.articulation == motion.articulation; };
  if (std::any_of(context.scene.world.motions.begin(), context.scene.world.motions.end(), same)) {
    throw SetupError(where, "link '" + name + "' has a motion already", "give one motion to a link");
  }
  context.scene.world.motions.push_back(motion);
}

SurfaceVelocity readBelt(const XmlFile& file, const XmlElement& collision, const Pose& X_LM) {
  SurfaceVelocity belt;
  const XmlElement* tag = collision.FirstChildElement("haptic:belt");
  if (!tag) return belt;
  refuseUnknownAttributes(file, *tag, {"velocity", "spin"});
  const std::string where = file.at(*tag) + ": <haptic:belt>";
  if (tag->NextSiblingElement("haptic:belt")) throw SetupError(where, "is there twice", "give one to a collision");
  const auto velocity = readVector(file, *tag, "velocity"), spin = readVector(file, *tag, "spin");
  if (!velocity && !spin) throw SetupError(where, "says nothing", "give velocity [m/s] or spin [rad/s], three numbers");
  const Twist V_M{spin.value_or(Vector3::Zero()), velocity.value_or(Vector3::Zero())};
  belt.V_L = V_M.rotated(X_LM.R).shifted(-X_LM.p);
  return belt;
}

}  // namespace haptic
