#include "scene/pointer_reading.h"

#include <algorithm>
#include <cmath>

#include "haptic_core/base/parse_numbers.h"
#include "haptic_core/geometry/pairs/shape_distance.h"
#include "haptic_core/geometry/shapes/ball.h"
#include "scene/scene_extension.h"
#include "scene/surface_motion.h"
#include "scene/topic_name.h"

namespace haptic {
namespace {

// The stand-in pointer: a fingertip-sized ball.
constexpr double kRadius = 0.005;  ///< [m], a sphere of 10 mm
constexpr double kClearance =
    0.005;  ///< [m] between it and the surface at the start: no force when the loop closes
constexpr double kPress =
    0.006;  ///< [m] that the scripted hand goes beyond the surface: 3 N at a hand's 500 N/m
constexpr double kSlide = 0.008;  ///< [m] to either side; stays on a fingertip
constexpr double kMass = 0.05;    ///< [kg], of a finger; only a virtual coupling feels it
/// A minute of pressing and sliding, longer than any demo asks for.
constexpr int kRepeat = 10;

std::vector<HandKey> pressAndSlide() {
  const double down = -(kClearance + kPress);
  const auto key = [](double t, double x, double y, double z) {
    return HandKey{t, Vector3(x, y, z), Vector3::Zero(), 0};
  };
  return {key(0.5, 0, 0, 0),         key(1.5, 0, 0, down),       key(2.2, 0, 0, down),
          key(3.0, kSlide, 0, down), key(4.0, -kSlide, 0, down), key(4.6, 0, kSlide, down),
          key(5.2, 0, 0, down),      key(6.0, 0, 0, 0)};
}

HandPath repeated(const HandPath& path, int times) {
  HandPath all;
  for (int i = 0; i < times; ++i) {
    for (HandKey key : path.keys) {
      key.time += i * path.duration();
      all.keys.push_back(key);
    }
  }
  return all;
}

/// Where the stand-in goes.
struct Highest {
  Vector3 point = Vector3::Zero();  ///< in W
  std::string name;                 ///< of its link; empty: there are no shapes
  int articulation = -1, link = -1;
};

/// The highest point of all shapes: the middle of the vertices within 1 mm below the top of the highest one.
Highest highestPoint(const WorldDef& world) {
  constexpr double kBand = 1e-3;  // wide enough that the rim of a tessellated top counts as one
  double top = -INFINITY;
  Highest highest;
  for (const ArticulationDef& articulation : world.articulations) {
    const std::vector<Pose> X_WL = initialPoses(articulation);
    for (std::size_t i = 0; i < articulation.links.size(); ++i) {
      for (const CollisionDef& collision : articulation.links[i].collisions) {
        const Pose X_WS = X_WL[i] * collision.X_LS;
        // A slope without end is as high as its frame.
        const bool endless = !collision.shape->bounded();
        const double height = endless ? X_WS.p.z() : supportHeight(*collision.shape, X_WS, Vector3::UnitZ());
        if (!(height > top)) continue;
        top = height;
        highest.name = articulation.links[i].name;
        highest.articulation = static_cast<int>(&articulation - world.articulations.data());
        highest.link = static_cast<int>(i);
        Vector3 sum = Vector3::Zero();
        int count = 0;
        const std::vector<Vector3> corners = collision.shape->flat() ? collision.shape->corners() : std::vector<Vector3>();
        for (const Vector3& v : corners) {
          const Vector3 p_W = X_WS * v;
          if (p_W.z() < height - kBand) continue;
          sum += p_W;
          ++count;
        }
        highest.point = count > 0 ? Vector3(sum / count) : X_WS * collision.shape->centre();
        highest.point.z() = height;
      }
    }
  }
  return highest;
}

/// Upper end of the sphere that a link's shapes fill when it turns about its centre of mass [m].
double topWhenTurned(const ArticulationDef& articulation, int index) {
  const LinkDef& link = articulation.links[static_cast<std::size_t>(index)];
  const Pose X_WL = initialPoses(articulation)[static_cast<std::size_t>(index)];
  double radius = 0;
  for (const CollisionDef& collision : link.collisions)
    radius = std::max(radius, (collision.X_LS * collision.shape->centre() - link.inertia.p_LC).norm() + collision.shape->boundingRadius());
  return (X_WL * link.inertia.p_LC).z() + radius;
}

void checkPath(const HandPath& path, const std::string& where) {
  for (std::size_t i = 1; i < path.keys.size(); ++i) {
    if (!(path.keys[i].time > path.keys[i - 1].time)) {
      throw SetupError(where, "its waypoints are not in the order of time",
                       "let time rise from one to the next");
    }
  }
}

}  // namespace

PointerCoupling::Mode couplingMode(const std::string& name, const std::string& where) {
  if (name == "direct") return PointerCoupling::Mode::kDirect;
  if (name == "virtual") return PointerCoupling::Mode::kVirtual;
  throw SetupError(where, "coupling '" + name + "' is unknown", "known: direct, virtual");
}

PointerCoupling::Axes couplingAxes(const std::string& name, const std::string& where) {
  if (name == "link") return PointerCoupling::Axes::kLink;
  if (name == "grip") return PointerCoupling::Axes::kGrip;
  throw SetupError(where, "axes '" + name + "' are unknown", "known: link, grip");
}

void setCouplingValue(const std::vector<double>& numbers, const std::string& what, double& greatest, AxisShares& shares) {
  if (numbers.size() == 1) {
    greatest = numbers[0];
    return;
  }
  const bool good = numbers.size() == 3 && std::all_of(numbers.begin(), numbers.end(), [](double x) { return x >= 0 && std::isfinite(x); });
  if (!good) throw SetupError(what, "is neither one number nor three ≥ 0", "write one for all axes, or those along x, y and z");
  greatest = *std::max_element(numbers.begin(), numbers.end());
  if (greatest > 0) shares.share = Vector3(numbers[0], numbers[1], numbers[2]) / greatest;
}

namespace {

void readCoupling(const XmlElement& tag, const std::string& where, PointerCoupling& c) {
  if (tag.Attribute("coupling")) c.mode = couplingMode(tag.Attribute("coupling"), where);
  if (tag.Attribute("axes")) c.axes = couplingAxes(tag.Attribute("axes"), where);
  const auto read = [&](const char* attribute, double& greatest, AxisShares& shares) {
    const char* const text = tag.Attribute(attribute);
    if (!text) return;
    const auto numbers = parseNumbers(text);
    setCouplingValue(numbers ? *numbers : std::vector<double>(), where + " " + attribute + "=\"" + text + "\"", greatest, shares);
  };
  read("stiffness", c.stiffness, c.along_stiffness);
  read("damping", c.damping, c.along_damping);
  read("rotational_stiffness", c.rotational_stiffness, c.about_stiffness);
  read("rotational_damping", c.rotational_damping, c.about_damping);
}

}  // namespace

void addPointer(const PointerSettings& settings, LoadContext& context) {
  const std::string& where = settings.where;
  WorldDef& world = context.scene.world;
  const FramePlace frame = findFrame(context, settings.link, where);
  if (frame.articulation < 0)
    throw SetupError(where, "the world cannot be a pointer", "name a link that moves");
  const ArticulationDef& articulation = world.articulations[frame.articulation];
  const LinkDef& link = articulation.links[frame.link];
  if (link.joint.type == JointType::kFixed) {
    throw SetupError(where, "link '" + settings.link + "' is fixed",
                     "a pointer needs a joint that moves, e.g. floating");
  }
  if (!isTopicName(settings.device))
    throw SetupError(where, "device '" + settings.device + "' is no name of ROS", kTopicNameRemedy);
  for (const HandDef& other : context.scene.hands) {
    if (other.device == settings.device)
      throw SetupError(where, "device '" + settings.device + "' has a pointer already",
                       "name another device");
  }
  for (const double scale : {settings.scale, settings.force_scale}) {
    if (!(scale > 0) || !std::isfinite(scale))
      throw SetupError(where, "a scale is not > 0", "write a finite scale > 0");
  }
  for (const double delay : {settings.delay.pose, settings.delay.force}) {
    if (!(delay >= 0 && delay <= kMostAddedDelay)) throw SetupError(where, "a delay is not within 0 to 0.2 s", "write seconds, e.g. 0.02");
  }
  const PointerCoupling& c = settings.coupling;
  for (const double value : {c.stiffness, c.damping, c.rotational_stiffness, c.rotational_damping}) {
    if (value != PointerCoupling::kDerived && (!(value >= 0) || !std::isfinite(value)))
      throw SetupError(where, "a coupling value is negative", "write values ≥ 0, or leave it out to have it derived");
  }
  checkPath(settings.path, where);
  HandDef hand;
  hand.device = settings.device;
  hand.pointer = static_cast<int>(world.pointers.size());
  hand.workspace.scale = settings.scale;
  hand.workspace.X_WB = settings.X_WB ? *settings.X_WB : initialPoses(articulation)[frame.link] * frame.X_LF;
  hand.force_scale = settings.force_scale;
  hand.delay = settings.delay;
  hand.path = repeated(settings.path.keys.empty() ? handPath("touch_cube") : settings.path, settings.repeat);
  context.scene.hands.push_back(hand);
  world.pointers.push_back({settings.device, frame.articulation, frame.link, settings.coupling, frame.X_LF, settings.link});
}

void readPointer(const RobotFile& robot, const XmlElement& tag, const ModelSettings& model,
                 LoadContext& context) {
  PointerSettings settings;
  const XmlFile& file = robot.xml;
  settings.where = file.at(tag) + ": <haptic:pointer>";
  refuseUnknownAttributes(file, tag,
                          {"link", "device", "scale", "force_scale", "pose_delay", "force_delay", "coupling", "stiffness", "damping",
                           "rotational_stiffness", "rotational_damping", "axes", "xyz", "rpy", "path", "repeat"});
  settings.link = model.prefix + readName(file, tag, "link");
  if (tag.Attribute("device")) settings.device = readName(file, tag, "device");
  settings.scale = readNumber(file, tag, "scale").value_or(1);
  settings.force_scale = readNumber(file, tag, "force_scale").value_or(1);
  settings.delay.pose = readNumber(file, tag, "pose_delay").value_or(0);
  settings.delay.force = readNumber(file, tag, "force_delay").value_or(0);
  readCoupling(tag, settings.where, settings.coupling);
  if (tag.Attribute("xyz") || tag.Attribute("rpy")) settings.X_WB = model.X_WM * readPose(file, tag);
  if (tag.Attribute("path")) settings.path = handPath(tag.Attribute("path"));
  const double repeat = readNumber(file, tag, "repeat").value_or(1);
  if (repeat < 1 || repeat > 1000 || repeat != std::floor(repeat)) {
    throw SetupError(settings.where, "repeat is no whole number of 1…1000", "write e.g. 6");
  }
  settings.repeat = static_cast<int>(repeat);
  for (const XmlElement* point = tag.FirstChildElement("haptic:waypoint"); point;
       point = point->NextSiblingElement("haptic:waypoint")) {
    refuseUnknownAttributes(file, *point, {"time", "xyz", "rotation", "opening"});
    const auto time = readNumber(file, *point, "time");
    if (!time) throw SetupError(file.at(*point) + ": <haptic:waypoint>", "has no time", "give it in seconds");
    settings.path.keys.push_back({*time, readVector(file, *point, "xyz").value_or(Vector3::Zero()),
                                  readVector(file, *point, "rotation").value_or(Vector3::Zero()),
                                  readNumber(file, *point, "opening").value_or(0)});
  }
  addPointer(settings, context);
}

void addDefaultPointer(LoadContext& context) {
  Highest highest = highestPoint(context.scene.world);
  const bool waits = highest.articulation >= 0 &&
                     !staysPut(context.scene.world, highest.articulation, highest.link, highest.point);
  if (waits) highest.point.z() = topWhenTurned(context.scene.world.articulations[static_cast<std::size_t>(highest.articulation)],
                                               highest.link);
  const std::string name = context.frames.count("pointer") ? "haptic_pointer" : "pointer";
  ArticulationDef articulation;
  articulation.name = name;
  articulation.X_WA = Pose(highest.point + Vector3(0, 0, kRadius + kClearance));
  LinkDef link;
  link.name = name;
  link.joint.name = name + "_joint";
  link.joint.type = JointType::kFloating;
  link.inertia = {kMass, Vector3::Zero(), 0.4 * kMass * kRadius * kRadius * Matrix3::Identity()};
  CollisionDef collision;
  collision.name = name + "/sphere";
  collision.shape = std::make_shared<Ball>(kRadius, name);
  collision.material_source = "default";
  link.collisions.push_back(collision);
  articulation.links.push_back(link);
  const int index = static_cast<int>(context.scene.world.articulations.size());
  context.scene.world.articulations.push_back(articulation);
  context.places.push_back({context.scene.file + ": added pointer"});
  context.frames[name] = {index, 0, Pose()};
  VisualDef visual;
  visual.articulation = index;
  visual.link = 0;
  visual.name = name;
  visual.shape = VisualShape::kSphere;
  visual.size = Vector3::Constant(2 * kRadius);
  visual.colour = {0.9f, 0.4f, 0.1f, 1.0f};
  context.scene.visuals.push_back(visual);
  PointerSettings settings;
  settings.where = context.scene.file;
  settings.link = name;
  settings.path.keys = pressAndSlide();
  if (waits) settings.path.keys.resize(1);
  settings.repeat = kRepeat;
  addPointer(settings, context);
  const std::string above = highest.name.empty() ? "the origin" : "'" + highest.name + "', the highest surface";
  const std::string clear = "waits above all that '" + highest.name + "' reaches when it turns: its surface does not stay to be touched";
  context.scene.notes.push_back("the scene names no pointer: a sphere of 10 mm " + (waits ? clear : "starts 5 mm above " + above));
}

}  // namespace haptic
