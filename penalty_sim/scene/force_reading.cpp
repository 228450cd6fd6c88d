#include "scene/force_reading.h"

#include "scene/scene_extension.h"

namespace haptic {
namespace {

ForceType typeOf(const std::string& name, const std::string& where) {
  std::string known;
  for (const ForceKind& kind : kForceKinds) {
    if (name == kind.name) return kind.type;
    known += (known.empty() ? "" : ", ") + std::string(kind.name);
  }
  throw SetupError(where, "type '" + name + "' is unknown", "known: " + known);
}

}  // namespace

void readForce(const RobotFile& robot, const XmlElement& tag, const ModelSettings& settings, LoadContext& context) {
  const std::string where = robot.xml.at(tag) + ": <haptic:force>";
  ForceDef force(typeOf(readName(robot.xml, tag, "type"), where));
  const std::string number = std::to_string(context.scene.world.forces.size());
  force.name = settings.prefix + (tag.Attribute("name") ? tag.Attribute("name") : "force" + number);
  std::vector<std::string> known = {"name", "type", "link1", "link2", "xyz", "xyz2"};
  for (const ForceParameter& parameter : kindOf(force.type).parameters) {
    if (!parameter.name) continue;
    known.push_back(parameter.name);
    if (const auto value = readNumber(robot.xml, tag, parameter.name)) force.set(parameter.name, *value);
  }
  refuseUnknownAttributes(robot.xml, tag, known);
  const auto place = [&](const char* link, const char* xyz, const Pose& X_W, int& articulation, int& index, Vector3& point) {
    FramePlace frame;
    frame.X_LF = X_W;
    if (tag.Attribute(link)) frame = findFrame(context, settings.prefix + readName(robot.xml, tag, link), where);
    articulation = frame.articulation;
    index = frame.link;
    point = frame.X_LF * readVector(robot.xml, tag, xyz).value_or(Vector3::Zero());
  };
  place("link1", "xyz", settings.X_WM, force.articulation_a, force.link_a, force.p_A);
  place("link2", "xyz2", Pose(), force.articulation_b, force.link_b, force.p_B);
  if (tag.Attribute("link2") && force.articulation_b < 0) {
    throw SetupError(where, "link2 is the world", "name the world as link1, and a link that moves as link2");
  }
  check(force, where);
  context.scene.world.forces.push_back(force);
}

}  // namespace haptic
