#include "scene/scene_extension.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "haptic_core/base/parse_numbers.h"
#include "scene/contact_properties.h"
#include "scene/force_reading.h"
#include "scene/motion_reading.h"
#include "scene/pointer_reading.h"
#include "scene/sensor_reading.h"

namespace haptic {
namespace {

bool isHaptic(const XmlElement& element) {
  return std::strncmp(element.Name(), "haptic:", 7) == 0;
}

const std::map<std::string, std::vector<std::string>> kKnownBelow = {
    {"robot", {"haptic:scene", "haptic:pointer", "haptic:collision_filter", "haptic:loop", "haptic:force", "haptic:motion",
               "haptic:sensor"}},
    {"joint", {"haptic:joint"}},
    {"collision", {"haptic:contact", "haptic:shape", "haptic:belt"}},
    {"haptic:scene", {"haptic:contact"}},
    {"haptic:pointer", {"haptic:waypoint"}},
};

void checkBelow(const XmlFile& file, const XmlElement& element) {
  if (std::strcmp(element.Name(), "haptic:contact") == 0)
    return;  // its children are checked where it is read
  const auto known = kKnownBelow.find(element.Name());
  refuseUnknownExtensions(file, element,
                          known == kKnownBelow.end() ? std::vector<std::string>() : known->second);
  for (const XmlElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    checkBelow(file, *child);
  }
}

template <class Enum>
bool choose(const std::string& value, const std::map<std::string, Enum>& choices, Enum& chosen,
            std::string& known) {
  for (const auto& [name, meaning] : choices) known += (known.empty() ? "" : ", ") + name;
  const auto found = choices.find(value);
  if (found != choices.end()) chosen = found->second;
  return found != choices.end();
}

LoopDef::Type loopType(const std::string& name, const std::string& where) {
  LoopDef::Type type = LoopDef::Type::kPoint;
  std::string known;
  if (!choose<LoopDef::Type>(name,
                             {{"point", LoopDef::Type::kPoint},
                              {"hinge", LoopDef::Type::kHinge},
                              {"weld", LoopDef::Type::kWeld}},
                             type, known)) {
    throw SetupError(where, "type '" + name + "' is unknown", "known: " + known);
  }
  return type;
}

Pose poseInWorld(const FramePlace& frame, const WorldDef& world) {
  if (frame.articulation < 0) return frame.X_LF;
  return initialPoses(world.articulations[frame.articulation])[frame.link] * frame.X_LF;
}

/// The frame F is given in link1; where it lies in link2 follows from the initial configuration, unless given
/// as well.
void readLoop(const RobotFile& robot, const XmlElement& tag, const std::string& prefix,
              LoadContext& context) {
  const std::string where = robot.xml.at(tag) + ": <haptic:loop>";
  refuseUnknownAttributes(robot.xml, tag,
                          {"name", "type", "link1", "link2", "xyz", "rpy", "axis", "xyz2", "rpy2"});
  LoopDef loop;
  loop.name = prefix + (tag.Attribute("name") ? tag.Attribute("name")
                                              : "loop" + std::to_string(context.scene.world.loops.size()));
  if (tag.Attribute("type")) loop.type = loopType(tag.Attribute("type"), where);
  const FramePlace a = findFrame(context, prefix + readName(robot.xml, tag, "link1"), where);
  const FramePlace b = findFrame(context, prefix + readName(robot.xml, tag, "link2"), where);
  if (a.articulation == b.articulation && a.link == b.link) {
    throw SetupError(where, "link1 and link2 are one rigid body",
                     "name two links that move against each other");
  }
  const Pose X_1F = readPose(robot.xml, tag);
  const Pose X_2F =
      tag.Attribute("xyz2") || tag.Attribute("rpy2")
          ? readPose(robot.xml, tag, "xyz2", "rpy2")
          : relativePose(poseInWorld(b, context.scene.world), poseInWorld(a, context.scene.world) * X_1F);
  loop.articulation_a = a.articulation;
  loop.link_a = a.link;
  loop.X_AF = a.X_LF * X_1F;
  loop.articulation_b = b.articulation;
  loop.link_b = b.link;
  loop.X_BF = b.X_LF * X_2F;
  const Vector3 axis = readVector(robot.xml, tag, "axis").value_or(Vector3::UnitZ());
  if (axis.norm() < 1e-6)
    throw SetupError(where, "its axis is zero", "give the axis a direction, e.g. 0 0 1");
  loop.axis = axis.normalized();
  context.scene.world.loops.push_back(loop);
}

void readFilter(const RobotFile& robot, const XmlElement& tag, const std::string& prefix,
                LoadContext& context) {
  const std::string where = robot.xml.at(tag) + ": <haptic:collision_filter>";
  refuseUnknownAttributes(robot.xml, tag, {"link1", "link2"});
  addFilter(findFrame(context, prefix + readName(robot.xml, tag, "link1"), where),
            findFrame(context, prefix + readName(robot.xml, tag, "link2"), where), context.scene.world);
}

}  // namespace

bool hasExtension(const XmlElement& element, const std::string& but) {
  if (isHaptic(element) && element.Name() != but) return true;
  for (const XmlElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    if (hasExtension(*child, but)) return true;
  }
  return false;
}

void refuseUnknownExtensions(const XmlFile& file, const XmlElement& element,
                             const std::vector<std::string>& known) {
  for (const XmlElement* child = element.FirstChildElement(); child; child = child->NextSiblingElement()) {
    if (!isHaptic(*child) || std::find(known.begin(), known.end(), child->Name()) != known.end()) continue;
    std::string list;
    for (const std::string& name : known) list += (list.empty() ? "" : ", ") + name;
    throw SetupError(file.at(*child) + ": <" + child->Name() + ">",
                     std::string("is unknown below <") + element.Name() + ">",
                     list.empty() ? "take it out" : "known here: " + list);
  }
}

void checkExtensions(RobotFile& robot) {
  const XmlElement& root = *robot.xml.root();
  checkBelow(robot.xml, root);
  if (hasExtension(root) && !root.Attribute("xmlns:haptic")) {
    robot.warnings.push_back(robot.xml.at(root) +
                             ": haptic: tags without xmlns:haptic=\"...\" on <robot>: python's XML parsers "
                             "refuse the file; add it");
  }
}

void setWorldSetting(const std::string& where, const std::string& name, const std::string& value, WorldSettings& settings,
                     std::vector<std::string>& warnings) {
  const auto numbers = parseNumbers(value);
  const bool number = numbers && numbers->size() == 1 && std::isfinite((*numbers)[0]);
  std::string known;
  bool good = true;
  if (name == "step") {
    // The upper bound is the contract of WorldSettings: a tenth of a second is no simulation of contact.
    good = number && (*numbers)[0] > 0 && (*numbers)[0] <= 0.1;
    if (good) settings.step = (*numbers)[0];
    known = "a time in seconds, > 0 and ≤ 0.1";
  } else if (name == "gravity") {
    good =
        numbers && numbers->size() == 3 && Vector3((*numbers)[0], (*numbers)[1], (*numbers)[2]).allFinite();
    if (good) settings.gravity = Vector3((*numbers)[0], (*numbers)[1], (*numbers)[2]);
    known = "three numbers in m/s²";
  } else if (name == "substeps") {
    if (value == "1") return;
    warnings.push_back(where + ": substeps = '" + value + "' is ignored: each island divides its step where it is fast; take it out, or"
                       " give a shorter step");
  } else if (name == "integrator" || name == "contact_model") {
    if (value == (name == "integrator" ? "automatic" : "volume")) return;
    warnings.push_back(where + ": " + name + " = '" + value +
                       "' is ignored: each island takes the cheapest step that errs by no more than accuracy; take it out");
  } else if (name == "pressure_law") {
    std::map<std::string, PressureLaw> kinds;
    for (const PressureKind& kind : kPressureKinds) kinds[kind.name] = kind.law;
    good = choose(value, kinds, settings.pressure_law, known);
  } else if (name == "accuracy") {
    good = number && (*numbers)[0] > 0 && (*numbers)[0] <= 1;
    if (good) settings.accuracy = (*numbers)[0];
    known = "a share > 0 and ≤ 1 of the way that forces move a body in a step";
  } else if (name == "far_step") {
    good = number && (*numbers)[0] >= 0 && (*numbers)[0] <= 0.1;  // at most so many steps: the world says how many
    if (good) settings.far_step = (*numbers)[0];
    known = "a time in seconds, 0 to 0.1, at most 100 steps; 0: everything is stepped alike";
  } else if (name == "energy_ledger") {
    good = choose<bool>(value, {{"true", true}, {"false", false}}, settings.energy_ledger, known);
  } else {
    throw SetupError(where, "unknown setting '" + name + "'",
                     "known: step, far_step, gravity, accuracy, pressure_law, energy_ledger");
  }
  if (!good) throw SetupError(where, name + " = '" + value + "'", "write " + known);
}

void readSceneTag(RobotFile& robot, WorldSettings& settings, GivenSolid& solid) {
  const XmlElement* tag = robot.xml.root()->FirstChildElement("haptic:scene");
  if (!tag) return;
  const std::string where = robot.xml.at(*tag) + ": <haptic:scene>";
  if (const XmlElement* second = tag->NextSiblingElement("haptic:scene")) {
    throw SetupError(robot.xml.at(*second) + ": <haptic:scene>", "is there twice",
                     "put all settings into one");
  }
  for (const auto* attribute = tag->FirstAttribute(); attribute; attribute = attribute->Next()) {
    setWorldSetting(where, attribute->Name(), attribute->Value(), settings, robot.warnings);
  }
  if (const XmlElement* contact = tag->FirstChildElement("haptic:contact")) {
    readContact(robot.xml, *contact, settings.default_material, solid);
  }
}

void readRelations(const RobotFile& robot, const ModelSettings& settings, LoadContext& context) {
  for (const XmlElement* tag = robot.xml.root()->FirstChildElement(); tag; tag = tag->NextSiblingElement()) {
    const std::string name = tag->Name();
    if (name == "haptic:collision_filter") readFilter(robot, *tag, settings.prefix, context);
    if (name == "haptic:loop") readLoop(robot, *tag, settings.prefix, context);
    if (name == "haptic:force") readForce(robot, *tag, settings, context);
    if (name == "haptic:sensor") readSensor(robot, *tag, settings, context);
    if (name == "haptic:motion") readMotion(robot, *tag, settings, context);
  }
  // A pointer's device stands where its link starts: motions have put theirs by now.
  constexpr char kPointer[] = "haptic:pointer";
  for (const XmlElement* tag = robot.xml.root()->FirstChildElement(kPointer); tag; tag = tag->NextSiblingElement(kPointer)) {
    readPointer(robot, *tag, settings, context);
  }
}

FramePlace findFrame(const LoadContext& context, const std::string& name, const std::string& where) {
  const auto found = context.frames.find(name);
  if (found == context.frames.end())
    throw SetupError(where, "link '" + name + "' does not exist", "define it or mend the name");
  return found->second;
}

void addFilter(const FramePlace& a, const FramePlace& b, WorldDef& world) {
  if (a.articulation < 0 || b.articulation < 0) return;  // W itself has no shapes
  if (a.articulation == b.articulation && a.link == b.link) return;
  world.filters.push_back({a.articulation, a.link, b.articulation, b.link});
}

}  // namespace haptic
