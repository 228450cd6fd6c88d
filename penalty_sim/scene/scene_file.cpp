#include "scene/scene_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "scene/initial_overlap.h"
#include "scene/joint_motion.h"
#include "scene/joint_reading.h"
#include "scene/pointer_reading.h"
#include "scene/probable_numbers.h"
#include "scene/progress_watch.h"
#include "scene/resource_path.h"
#include "scene/scene_extension.h"
#include "scene/scene_list.h"
#include "scene/stiffness_choice.h"
#include "scene/text_file.h"

namespace haptic {
namespace {

/// Heaviest to lightest body or tree: beyond the warning the contact's time scales lie far apart; beyond the
/// error a body has no weight to the last digit of the other's forces (rounding 1e-16, sixteen digits).
constexpr double kWarnMassRatio = 1e5, kMaxMassRatio = 1e8;

bool isList(const std::string& file) {
  const std::string ending = std::filesystem::path(file).extension().string();
  return ending == ".yaml" || ending == ".yml";
}

/// `guest`: the world has its settings from elsewhere.
void readModels(SceneList& list, const SceneOptions& options, bool guest, LoadContext& context) {
  WorldDef& world = context.scene.world;
  std::vector<std::unique_ptr<RobotFile>> robots;
  for (const ListedModel& model : list.models) {
    robots.push_back(readRobot(model.file, options));
    RobotFile& robot = *robots.back();
    checkExtensions(robot);
    const XmlElement* scene = robot.xml.root()->FirstChildElement("haptic:scene");
    if (!guest) readSceneTag(robot, world.settings, context.solid);
    if (guest && scene) robot.warnings.push_back(robot.xml.at(*scene) + ": <haptic:scene> is left out: the running scene's holds");
    const std::size_t first = context.scene.world.articulations.size();
    addRobot(robot, model.settings, options, context);
    context.scene.descriptions.emplace_back(model.settings.prefix, robot.xml.text());
    if (!model.motion.empty()) {
      context.scene.world.joint_paths.push_back(
          readJointMotion(model.motion, model.settings.prefix, context.scene.world, first));
    }
    if (list.name.empty()) list.name = robot.name;
  }
  if (context.scene.text.empty()) context.scene.text = robots[0]->xml.text();
  for (std::size_t i = 0; i < robots.size(); ++i) readRelations(*robots[i], list.models[i].settings, context);
}

void applyList(const SceneList& list, LoadContext& context) {
  WorldDef& world = context.scene.world;
  for (const auto& [name, value] : list.settings)
    setWorldSetting(list.where_settings, name, value, world.settings, context.scene.warnings);
  ContactMaterial& material = world.settings.default_material;
  const ContactMaterial& given = list.default_material;
  for (double ContactMaterial::*value :
       {&ContactMaterial::stiffness, &ContactMaterial::damping, &ContactMaterial::dissipation,
        &ContactMaterial::tangential_stiffness, &ContactMaterial::tangential_damping,
        &ContactMaterial::mu_static, &ContactMaterial::mu_dynamic}) {
    if (!std::isnan(given.*value)) material.*value = given.*value;
  }
  if (list.solid) {
    context.solid = list.solid;
    material.stiffness = ContactMaterial::kUnset;
  } else if (!std::isnan(given.stiffness)) {
    context.solid = {};
  }
  for (const auto& [a, b] : list.filters) {
    const std::string where = context.scene.file + ": filters";
    addFilter(findFrame(context, a, where), findFrame(context, b, where), world);
  }
  for (const ListedDevice& device : list.devices) {
    PointerSettings settings;
    settings.where = device.where;
    settings.device = device.device;
    settings.link = device.link;
    settings.coupling = device.coupling;
    settings.scale = device.scale;
    settings.force_scale = device.force_scale;
    settings.delay = device.delay;
    if (device.has_pose) settings.X_WB = device.X_WB;
    settings.path = device.path;
    settings.repeat = device.repeat;
    addPointer(settings, context);
  }
}

/// Pairs that an SRDF disables. Links that the scene does not have are common there (another hand) and are
/// counted.
void readSrdf(const std::string& path, LoadContext& context) {
  const XmlFile file(path);
  int used = 0, unknown = 0;
  for (const XmlElement* pair = file.root()->FirstChildElement("disable_collisions"); pair;
       pair = pair->NextSiblingElement("disable_collisions")) {
    const auto a = context.frames.find(readName(file, *pair, "link1")),
               b = context.frames.find(readName(file, *pair, "link2"));
    if (a == context.frames.end() || b == context.frames.end()) {
      ++unknown;
      continue;
    }
    addFilter(a->second, b->second, context.scene.world);
    ++used;
  }
  context.scene.notes.push_back(path + ": " + std::to_string(used) + " pairs do not collide, " +
                                std::to_string(unknown) + " pairs name links that the scene does not have");
}

/// Of all moving links of a body or tree [kg]: what hangs together carries its light links (excited_inertia.h).
double movingMass(const ArticulationDef& tree) {
  double mass = 0;
  for (const LinkDef& link : tree.links) mass += link.joint.type != JointType::kFixed ? link.inertia.mass : 0;
  return mass;
}

void checkMassRatio(LoadContext& context) {
  double heaviest = 0, lightest = INFINITY;
  std::string heavy, light;
  const WorldDef& world = context.scene.world;
  for (std::size_t a = 0; a < world.articulations.size(); ++a) {
    const double mass = movingMass(world.articulations[a]);
    if (!(mass > 0)) continue;
    if (mass > heaviest) heaviest = mass, heavy = world.articulations[a].name;
    if (mass < lightest) lightest = mass, light = context.places[a][0];
  }
  if (!(lightest < INFINITY) || heaviest <= kWarnMassRatio * lightest) return;
  std::ostringstream text;
  text << "weighs " << lightest << " kg beside " << heaviest << " kg of '" << heavy << "'";
  if (heaviest > kMaxMassRatio * lightest)
    throw SetupError(light, text.str(), "raise the light mass or join the links with a fixed joint");
  context.scene.warnings.push_back(light + ": " + text.str() +
                                   ": a contact between them may take more passes than a step has, and is then reported");
}

void warnOfPictures(LoadContext& context) {
  if (context.missing_pictures.empty()) return;
  std::string list;
  for (const std::string& file : context.missing_pictures) list += (list.empty() ? "" : ", ") + file;
  context.scene.warnings.push_back(context.scene.file + ": " + std::to_string(context.missing_pictures.size()) +
                                   " meshes of visuals are not found and not drawn: " + list + "; "
                                       + remedyFor(context.missing_pictures.front()));
}

/// What `list` says, into the context, whose file is named.
SceneDef load(SceneList& list, const SceneOptions& options, bool guest, LoadContext& context) {
  if (options.default_density < 0 || !std::isfinite(options.default_density)) {
    throw SetupError("default density", "is not ≥ 0", "write a density in kg/m³, e.g. 1000");
  }
  readModels(list, options, guest, context);
  context.shapes.meshes().refuseMissing(context.missing_pictures);
  warnOfPictures(context);
  applyList(list, context);
  for (int held : context.held) {  // once the scene's gravity is known
    holdJoints(context.scene.world.articulations[held], context.scene.world.settings.gravity, context.scene.notes);
  }
  for (const std::string& srdf : {list.srdf, options.srdf}) {
    if (!srdf.empty()) readSrdf(srdf, context);
  }
  context.scene.world.name = list.name;
  if (context.scene.world.articulations.empty()) {
    throw SetupError(context.scene.file, "has no body", "hang at least one link on the world");
  }
  if (context.scene.world.pointers.empty() && options.add_pointer) addDefaultPointer(context);
  if (options.step > 0) context.scene.world.settings.step = options.step;
  warnOfImprobableNumbers(context);
  checkMassRatio(context);
  filterInitialOverlaps(context);
  if (options.rigid) {
    context.solid = {};
    context.scene.world.settings.default_material.stiffness = ContactMaterial::kRigid;
    context.scene.world.settings.default_material.tangential_stiffness = ContactMaterial::kUnset;
  }
  chooseStiffness(options.progress, context);  // of those that collide
  for (auto* lines : {&context.scene.notes, &context.scene.warnings, &context.scene.replaced}) {
    for (std::string& line : *lines) line = SetupError::oneLine(line);
  }
  return std::move(context.scene);
}

/// Where somebody hears of the progress, never in silence for long.
SceneDef watched(const std::string& name, const SceneOptions& options, const std::function<SceneDef(const SceneOptions&)>& read) {
  if (!options.progress) return read(options);
  ProgressWatch watch(options.progress, "loading " + name);
  SceneOptions told = options;
  told.progress = [&watch](const std::string& line) { watch.tell(line); };
  return read(told);
}

}  // namespace

SceneDef loadScene(const std::string& file_or_name, const SceneOptions& options) {
  return watched(file_or_name, options, [&](const SceneOptions& told) {
    LoadContext context(told);
    context.scene.file = told.text ? file_or_name : findScene(file_or_name, told.scene_folders);
    SceneList list;
    if (!told.text && isList(context.scene.file))
      list = readSceneList(context.scene.file), context.scene.text = readTextFile(context.scene.file);
    else
      list.models.push_back({context.scene.file, context.scene.file, "", ModelSettings()});
    return load(list, told, false, context);
  });
}

SceneDef loadModel(const std::string& file_or_name, const ModelSettings& model, const WorldSettings& running, SceneOptions options) {
  options.add_pointer = false;
  options.step = 0;
  return watched(file_or_name, options, [&](const SceneOptions& told) {
    LoadContext context(told);
    context.scene.file = told.text ? file_or_name : resolveResource(file_or_name, "");
    if (context.scene.file.empty()) context.scene.file = findScene(file_or_name, told.scene_folders);
    if (!told.text && isList(context.scene.file)) {
      throw SetupError(context.scene.file, "is a list of models", "name a URDF; spawn its models one by one");
    }
    context.scene.world.settings = running;
    SceneList list;
    list.models.push_back({context.scene.file, context.scene.file, "", model});
    return load(list, told, true, context);
  });
}

}  // namespace haptic
