#include "scene/sensor_reading.h"

#include <algorithm>
#include <cmath>

#include "scene/joint_reading.h"
#include "scene/link_inertia.h"
#include "scene/scene_extension.h"
#include "scene/topic_name.h"

namespace haptic {
namespace {

struct SensorType {
  const char* name;
  SensorDef::Kind kind;
  std::vector<std::string> attributes;  ///< besides those of all
};

const std::vector<SensorType>& sensorTypes() {
  static const std::vector<SensorType> types = {
      {"wrench", SensorDef::Kind::kWrench, {"joint", "noise_force", "noise_torque"}},
      {"contact", SensorDef::Kind::kContact, {"link", "with", "noise_force", "noise_torque"}},
      {"imu", SensorDef::Kind::kImu, {"link", "xyz", "rpy", "noise_angular_rate", "noise_specific_force", "noise_orientation"}}};
  return types;
}

const SensorType& typeOf(const RobotFile& robot, const XmlElement& tag, const std::string& where) {
  const std::string name = readName(robot.xml, tag, "type");
  for (const SensorType& type : sensorTypes()) {
    if (name == type.name) return type;
  }
  throw SetupError(where, "type '" + name + "' is unknown", "known: wrench, contact, imu");
}

/// Topics are named after sensors.
constexpr double kLeastRate = 1e-6;  // [Hz]: steps between samples stay a whole number

std::string readSensorName(const RobotFile& robot, const XmlElement& tag, const std::string& prefix, const std::string& where) {
  const std::string name = prefix + readOwnName(robot.xml, tag);
  if (!isTopicName(name) || name[0] == '/') {
    throw SetupError(where, "name '" + name + "' cannot be a topic's", "begin with a letter and use letters, digits and _");
  }
  return name;
}

double readSize(const RobotFile& robot, const XmlElement& tag, const std::string& where, const char* attribute) {
  const double value = readNumber(robot.xml, tag, attribute).value_or(0);
  if (value < 0) throw SetupError(where, std::string(attribute) + " is negative", "write a standard deviation ≥ 0");
  return value;
}

/// What hangs by fixed joints on a link of the file within one link of the world, itself included.
class Part {
 public:
  Part(const RobotFile& robot, const std::string& prefix, const LoadContext& context) : robot_(robot), prefix_(prefix), context_(context) {}

  /// All of the world's link: nothing of it lies on the near side.
  bool isWhole(int xml_link) const {
    const LinkXml& link = robot_.links[xml_link];
    return link.parent_joint < 0 || !isMerged(robot_.joints[link.parent_joint]);
  }

  LinkPart of(int xml_link) const {
    LinkPart sum;
    std::vector<int> open = {xml_link};
    while (!open.empty()) {
      const LinkXml& link = robot_.links[open.back()];
      open.pop_back();
      const LinkPart& own = context_.parts.at(prefix_ + link.name);
      merge(own.inertia, Pose(), sum.inertia);
      sum.collisions.insert(sum.collisions.end(), own.collisions.begin(), own.collisions.end());
      sum.children.insert(sum.children.end(), own.children.begin(), own.children.end());
      for (const int j : link.child_joints) {
        if (isMerged(robot_.joints[j])) open.push_back(robot_.joints[j].child);
      }
    }
    return sum;
  }

 private:
  /// A fixed joint that is no joint of the world.
  bool isMerged(const JointXml& joint) const {
    const FramePlace& place = context_.frames.at(prefix_ + robot_.links[joint.child].name);
    const std::vector<LinkDef>& links = context_.scene.world.articulations[place.articulation].links;
    return links[place.link].joint.name != prefix_ + joint.name && joint.type == "fixed";
  }

  const RobotFile& robot_;
  const std::string& prefix_;
  const LoadContext& context_;
};

/// The link of the world and what of it counts; throws where the link of the file is the world itself.
FramePlace placeSensor(const std::string& link, const std::string& prefix, const std::string& where, const LoadContext& context) {
  const FramePlace place = findFrame(context, prefix + link, where);
  if (place.articulation < 0) throw SetupError(where, "'" + link + "' is the world, which has no shapes and no motion", "name a link");
  return place;
}

void readWrench(const RobotFile& robot, const XmlElement& tag, const std::string& where, const std::string& prefix,
                const LoadContext& context, SensorDef& sensor) {
  const std::string joint = readName(robot.xml, tag, "joint");
  const int j = robot.jointIndex(joint);
  if (j < 0) throw SetupError(where, "joint '" + joint + "' does not exist", "define it or mend the name");
  const JointXml& xml = robot.joints[j];
  if (kindOf(xml)->floating) {
    throw SetupError(where, "joint '" + joint + "' floats: it carries nothing", "name a joint that holds something");
  }
  const LinkXml& child = robot.links[xml.child];
  const FramePlace place = placeSensor(child.name, prefix, where, context);
  sensor.articulation = place.articulation;
  sensor.link = place.link;
  sensor.X_LS = place.X_LF;
  sensor.frame = prefix + child.name;
  const Part part(robot, prefix, context);
  sensor.on_part = !part.isWhole(xml.child);
  if (sensor.on_part) sensor.part = part.of(xml.child);
}

void readContactSensor(const RobotFile& robot, const XmlElement& tag, const std::string& where, const std::string& prefix,
                       const LoadContext& context, SensorDef& sensor) {
  const Part part(robot, prefix, context);
  const auto find = [&](const char* attribute, int& articulation, int& link, bool& on_part, std::vector<int>& collisions) {
    const std::string name = readName(robot.xml, tag, attribute);
    const FramePlace place = placeSensor(name, prefix, where, context);
    const int xml = robot.linkIndex(name);
    articulation = place.articulation, link = place.link;
    on_part = !part.isWhole(xml);
    if (on_part) collisions = part.of(xml).collisions;
    return place;
  };
  const FramePlace place = find("link", sensor.articulation, sensor.link, sensor.on_part, sensor.part.collisions);
  sensor.X_LS = place.X_LF;
  sensor.frame = prefix + tag.Attribute("link");
  if (tag.Attribute("with")) find("with", sensor.with_articulation, sensor.with_link, sensor.with_part, sensor.with_collisions);
}

void readImu(const RobotFile& robot, const XmlElement& tag, const std::string& where, const std::string& prefix,
             const LoadContext& context, SensorDef& sensor) {
  const std::string link = readName(robot.xml, tag, "link");
  const FramePlace place = placeSensor(link, prefix, where, context);
  sensor.articulation = place.articulation;
  sensor.link = place.link;
  sensor.X_LS = place.X_LF * readPose(robot.xml, tag);
  const bool own_frame = tag.Attribute("xyz") || tag.Attribute("rpy");
  if (own_frame && context.frames.count(sensor.name) > 0) {
    throw SetupError(where, "its frame would have the name of a link", "give the sensor a name of its own");
  }
  sensor.frame = own_frame ? sensor.name : prefix + link;
}

}  // namespace

void readSensor(const RobotFile& robot, const XmlElement& tag, const ModelSettings& settings, LoadContext& context) {
  std::string where = robot.xml.at(tag) + ": <haptic:sensor>";
  const SensorType& type = typeOf(robot, tag, where);
  std::vector<std::string> known = {"name", "type", "rate", "seed"};
  known.insert(known.end(), type.attributes.begin(), type.attributes.end());
  refuseUnknownAttributes(robot.xml, tag, known);
  SensorDef sensor;
  sensor.kind = type.kind;
  sensor.name = readSensorName(robot, tag, settings.prefix, where);
  where += " '" + sensor.name + "'";
  for (const SensorDef& other : context.scene.world.sensors) {
    if (other.name == sensor.name) throw SetupError(where, "is there twice", "give every sensor a name of its own");
  }
  if (const auto rate = readNumber(robot.xml, tag, "rate")) {
    if (!(*rate >= kLeastRate)) throw SetupError(where, "rate is below 1e-6 Hz", "write samples per second [Hz]");
    sensor.rate = *rate;
  }
  if (const auto seed = readNumber(robot.xml, tag, "seed")) {
    constexpr double kMost = 9007199254740992;  // 2⁵³: what a number of a file holds exactly
    if (!(*seed >= 0 && *seed <= kMost && *seed == std::floor(*seed))) throw SetupError(where, "seed is no whole number", "write 0…2⁵³");
    sensor.seed = static_cast<std::uint64_t>(*seed);
  }
  sensor.noise_force = readSize(robot, tag, where, "noise_force");
  sensor.noise_torque = readSize(robot, tag, where, "noise_torque");
  sensor.noise_rate = readSize(robot, tag, where, "noise_angular_rate");
  sensor.noise_specific_force = readSize(robot, tag, where, "noise_specific_force");
  sensor.noise_orientation = readSize(robot, tag, where, "noise_orientation");
  switch (sensor.kind) {
    case SensorDef::Kind::kWrench:
      readWrench(robot, tag, where, settings.prefix, context, sensor);
      break;
    case SensorDef::Kind::kContact:
      readContactSensor(robot, tag, where, settings.prefix, context, sensor);
      break;
    case SensorDef::Kind::kImu:
      readImu(robot, tag, where, settings.prefix, context, sensor);
      break;
  }
  context.scene.world.sensors.push_back(sensor);
}

}  // namespace haptic
