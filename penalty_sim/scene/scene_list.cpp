#include "scene/scene_list.h"

#include <cmath>

#include "haptic_core/base/parse_numbers.h"
#include "haptic_core/base/plain_text.h"
#include "haptic_core/base/yaml_map.h"
#include "scene/contact_properties.h"
#include "scene/pointer_reading.h"
#include "scene/resource_path.h"

namespace haptic {
namespace {

Pose readPose(const YamlMap& parent, const std::string& path) {
  const YAML::Node node = parent["pose"];
  if (!node) return {};
  const YamlMap keys(path, node, "pose", {"xyz", "rpy"});
  return {rotationFromRpy(keys.vector("rpy")), keys.vector("xyz")};
}

int readRepeat(const YamlMap& keys) {
  const double repeat = keys.number("repeat", 1);
  if (repeat < 1 || repeat > 1000 || repeat != std::floor(repeat)) {
    throw SetupError(keys.where(), "repeat is no whole number of 1…1000", "write e.g. 6");
  }
  return static_cast<int>(repeat);
}

ListedModel readModel(const std::string& path, const YAML::Node& node) {
  const YamlMap keys(path, node, "model", {"file", "prefix", "pose", "base", "joints", "drive", "motion"});
  ListedModel model;
  model.where = keys.where();
  const std::string file = keys.text("file");
  if (file.empty()) throw SetupError(keys.where(), "has no file", "name a URDF: file: package://...");
  model.file = resolveResource(file, path);
  if (model.file.empty()) {
    throw SetupError(keys.where(), "file " + file + " is not found", remedyFor(file));
  }
  model.settings.prefix = plainText(keys.text("prefix"));
  model.settings.X_WM = readPose(keys, path);
  const std::string base = keys.text("base", "fixed"), drive = keys.text("drive", "as_file");
  if (base != "fixed" && base != "floating")
    throw SetupError(keys.where(), "base '" + base + "' is unknown", "known: fixed, floating");
  model.settings.floating = base == "floating";
  if (drive == "hold")
    model.settings.drive = ModelSettings::Drive::kHold;
  else if (drive == "free")
    model.settings.drive = ModelSettings::Drive::kFree;
  else if (drive != "as_file")
    throw SetupError(keys.where(), "drive '" + drive + "' is unknown", "known: hold, free");
  if (keys["motion"]) {
    model.motion = resolveResource(keys.text("motion"), path);
    if (model.motion.empty())
      throw SetupError(keys.where(keys["motion"]), "motion file is not found", "mend the path");
  }
  if (const YAML::Node joints = keys["joints"]) {
    if (!joints.IsMap())
      throw SetupError(keys.where(joints), "joints is not a mapping", "write joint: position lines");
    for (const auto& entry : joints) {
      const auto position = parseNumbers(entry.second.IsScalar() ? entry.second.Scalar() : "?");
      if (!entry.first.IsScalar() || !position || position->size() != 1 || !std::isfinite((*position)[0])) {
        throw SetupError(keys.where(entry.first), "a joint's position is not a finite number",
                         "write joint: 0.5 (rad or m)");
      }
      model.settings.joints[entry.first.Scalar()] = (*position)[0];
    }
  }
  return model;
}

ListedDevice readDevice(const std::string& path, const YAML::Node& node) {
  const YamlMap keys(path, node, "device",
                  {"device", "pointer", "coupling", "stiffness", "damping", "rotational_stiffness",
                   "rotational_damping", "axes", "scale", "force_scale", "pose_delay", "force_delay", "pose", "path", "repeat",
                   "waypoints"});
  ListedDevice device;
  device.where = keys.where();
  device.device = keys.text("device", "spidar");
  device.link = keys.text("pointer");
  if (device.link.empty())
    throw SetupError(keys.where(), "has no pointer", "name the link that the hand moves");
  device.coupling.mode = couplingMode(keys.text("coupling", "direct"), keys.where());
  PointerCoupling& c = device.coupling;
  c.axes = couplingAxes(keys.text("axes", "link"), keys.where());
  const auto read = [&](const char* key, double& greatest, AxisShares& shares) {
    if (!keys.has(key)) return;
    const bool several = keys[key].IsSequence();
    setCouplingValue(several ? keys.numbers(key) : std::vector<double>{keys.number(key, greatest)}, keys.where(key), greatest, shares);
  };
  read("stiffness", c.stiffness, c.along_stiffness);
  read("damping", c.damping, c.along_damping);
  read("rotational_stiffness", c.rotational_stiffness, c.about_stiffness);
  read("rotational_damping", c.rotational_damping, c.about_damping);
  device.scale = keys.number("scale", 1);
  device.force_scale = keys.number("force_scale", 1);
  device.delay = {keys.number("pose_delay", 0), keys.number("force_delay", 0)};
  device.has_pose = static_cast<bool>(keys["pose"]);
  device.X_WB = readPose(keys, path);
  device.repeat = readRepeat(keys);
  if (keys["path"]) device.path = handPath(keys.text("path"));
  if (const YAML::Node points = keys["waypoints"]) {
    if (!points.IsSequence())
      throw SetupError(keys.where(points), "waypoints is not a list", "write - {time: 1, xyz: [0, 0, 0]}");
    for (const YAML::Node& point : points) {
      const YamlMap entry(path, point, "waypoint", {"time", "xyz", "rotation", "opening"});
      if (!entry["time"]) throw SetupError(entry.where(), "has no time", "give it in seconds");
      device.path.keys.push_back({entry.number("time", 0), entry.vector("xyz"), entry.vector("rotation"),
                                  entry.number("opening", 0)});
    }
  }
  return device;
}

void readMaterial(const std::string& path, const YAML::Node& node, ContactMaterial& material, GivenSolid& solid) {
  const YamlMap keys(path, node, "material",
                  {"stiffness", "young_modulus", "material", "damping", "dissipation", "tangential_stiffness",
                   "tangential_damping", "mu_static", "mu_dynamic"});
  if (node["stiffness"]) {
    const std::string text = node["stiffness"].IsScalar() ? keys.text("stiffness") : "";
    material.stiffness = givenStiffness(text, [&] { return keys.number("stiffness", material.stiffness); }, keys.where(node["stiffness"]));
  }
  material.damping = keys.number("damping", material.damping);
  material.dissipation = keys.number("dissipation", material.dissipation);
  material.tangential_stiffness = keys.number("tangential_stiffness", material.tangential_stiffness);
  material.tangential_damping = keys.number("tangential_damping", material.tangential_damping);
  material.mu_static = keys.number("mu_static", material.mu_static);
  material.mu_dynamic = keys.number("mu_dynamic", material.mu_dynamic);
  std::optional<double> modulus;
  if (node["young_modulus"]) modulus = keys.number("young_modulus", 0);
  takeSolid(keys.text("material"), modulus, ContactMaterial::kUnset, keys.where(), material, solid);
  check(material, keys.where());
}

void readFilters(const YamlMap& keys, SceneList& list) {
  const YAML::Node filters = keys["filters"];
  if (!filters) return;
  for (const YAML::Node& pair : filters) {
    if (!pair.IsSequence() || pair.size() != 2 || !pair[0].IsScalar() || !pair[1].IsScalar()) {
      throw SetupError(keys.where(pair), "a filter is not a pair of links", "write - [link_a, link_b]");
    }
    list.filters.emplace_back(pair[0].Scalar(), pair[1].Scalar());
  }
}

SceneList readList(const std::string& path, const YAML::Node& root) {
  const YamlMap keys(path, root, "scene",
                  {"name", "models", "devices", "settings", "material", "filters", "srdf"});
  SceneList list;
  list.name = plainText(keys.text("name"));
  const YAML::Node models = keys["models"];
  if (!models || !models.IsSequence() || models.size() == 0)
    throw SetupError(path, "has no models", "list at least one: models: [{file: ...}]");
  for (const YAML::Node& model : models) list.models.push_back(readModel(path, model));
  if (const YAML::Node devices = keys["devices"]) {
    if (!devices.IsSequence())
      throw SetupError(keys.where(devices), "devices is not a list",
                       "write - {device: spidar, pointer: link}");
    for (const YAML::Node& device : devices) list.devices.push_back(readDevice(path, device));
  }
  if (const YAML::Node settings = keys["settings"]) {
    if (!settings.IsMap())
      throw SetupError(keys.where(settings), "settings is not a mapping", "write step: 0.001");
    list.where_settings = keys.where(settings) + ": settings";
    for (const auto& entry : settings) {
      std::string value = entry.second.IsScalar() ? entry.second.Scalar() : "";
      if (entry.second.IsSequence()) {
        for (const YAML::Node& item : entry.second)
          value += (value.empty() ? "" : " ") + (item.IsScalar() ? item.Scalar() : "?");
      }
      list.settings.emplace_back(entry.first.IsScalar() ? entry.first.Scalar() : "?", value);
    }
  }
  if (const YAML::Node material = keys["material"]) readMaterial(path, material, list.default_material, list.solid);
  readFilters(keys, list);
  if (keys["srdf"]) {
    list.srdf = resolveResource(keys.text("srdf"), path);
    if (list.srdf.empty())
      throw SetupError(keys.where(keys["srdf"]), "srdf file is not found", "mend the path");
  }
  return list;
}

}  // namespace

SceneList readSceneList(const std::string& path) {
  const YAML::Node root = loadYaml(path);
  if (!root || root.IsNull()) throw SetupError(path, "is empty", "a scene list needs models");
  return readList(path, root);
}

}  // namespace haptic
