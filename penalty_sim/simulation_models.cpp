/// Models that come and go while the world runs: ~spawn and ~delete.
#include <haptic_msgs/conversions.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "haptic_core/base/error.h"
#include "penalty_sim/simulation_nodelet.h"
#include "scene/robot_tree.h"

namespace haptic {
namespace {

/// A quaternion that a user wrote may miss unit length by the digits that were left out [1].
constexpr double kNearUnitLength = 1e-3;

Pose poseOfModel(const geometry_msgs::Pose& pose) {
  const auto& o = pose.orientation;
  const Vector3 p(pose.position.x, pose.position.y, pose.position.z);
  const bool none = o.x == 0 && o.y == 0 && o.z == 0 && o.w == 0;
  const Quaternion q(none ? 1 : o.w, o.x, o.y, o.z);
  if (!p.allFinite() || !(std::abs(q.norm() - 1) < kNearUnitLength)) {
    throw SetupError("pose", "is not finite, or its orientation no unit quaternion", "write w 1 and x, y, z 0 for none");
  }
  return {q.normalized(), p};
}

void checkModelName(const std::string& name, const SceneDef& scene) {
  const auto fits = [](unsigned char c) { return std::isalnum(c) || c == '_'; };
  if (name.empty() || !std::isalpha(static_cast<unsigned char>(name[0])) || !std::all_of(name.begin(), name.end(), fits)) {
    throw SetupError("name '" + name + "'", "cannot be a model's", "begin with a letter and use letters, digits and _");
  }
  for (const ArticulationDef& articulation : scene.world.articulations) {
    for (const LinkDef& link : articulation.links) {
      if (link.name == name || link.name.rfind(name + "/", 0) == 0)
        throw SetupError("name '" + name + "'", "is taken by link '" + link.name + "'", "give the model another one, or delete that first");
    }
  }
}

template <class Response>
bool answerLinks(Response& response, const std::function<std::vector<std::string>()>& links) {
  try {
    for (const std::string& link : links()) response.message += (response.message.empty() ? "" : ", ") + link;
    response.success = true;
  } catch (const std::exception& error) {
    response.success = false;
    response.message = SetupError::oneLine(error.what());
  }
  return true;
}

bool sameToldMotions(const SceneDef& a, const SceneDef& b) {
  const auto same = [](const ToldMotion& x, const ToldMotion& y) {
    return x.motion == y.motion && x.topic == y.topic && x.frame == y.frame;
  };
  return std::equal(a.told_motions.begin(), a.told_motions.end(), b.told_motions.begin(), b.told_motions.end(), same);
}

}  // namespace

bool SimulationNodelet::onSpawn(haptic_msgs::Spawn::Request& request, haptic_msgs::Spawn::Response& response) {
  return answerLinks(response, [&] { return change([&](const SceneDef& scene) { return spawned(scene, request); }); });
}

bool SimulationNodelet::onDelete(haptic_msgs::Delete::Request& request, haptic_msgs::Delete::Response& response) {
  return answerLinks(response, [&] { return change([&](const SceneDef& scene) { return withoutModel(scene, request.name); }); });
}

ChangedScene SimulationNodelet::spawned(const SceneDef& scene, const haptic_msgs::Spawn::Request& request) const {
  checkModelName(request.name, scene);
  ModelSettings model;
  model.prefix = request.name + "/";
  model.X_WM = poseOfModel(request.pose);
  model.floats_unless_world = !request.fixed;
  SceneOptions how = options(request.urdf.empty() ? request.model : std::string());
  if (!request.urdf.empty()) how.text = request.urdf;
  if (request.default_density != 0) how.default_density = request.default_density;
  if (!request.missing_meshes.empty()) how.missing = missingMeshesNamed(request.missing_meshes);
  if (!request.xacro.empty()) how.xacro = request.xacro;
  how.words = {"default_density: 1000", "missing_meshes: box or skip", "xacro: ['name:=value']"};
  const SceneDef loaded = loadModel(request.urdf.empty() ? request.model : request.name + ".urdf", model, scene.world.settings, how);
  for (const auto* lines : {&loaded.replaced, &loaded.warnings}) {
    for (const std::string& line : *lines) NODELET_WARN_STREAM(line);
  }
  return withModel(scene, loaded);
}

std::vector<std::string> SimulationNodelet::change(const std::function<ChangedScene(const SceneDef&)>& make) {
  std::shared_ptr<Simulation> running;
  SceneDef scene;
  loading_->there([&] {
    running = simulation_;
    if (running) scene = running->scene;
  });
  if (!running) throw SetupError("the simulation", "has no scene", "load one");
  const ChangedScene changed = make(scene);
  ChangeBodies bodies;
  *bodies.packed = packBodies(changed.scene.world, changed.kept);
  bodies.next = std::make_shared<NextWorld>(running->world, changed.scene.world, changed.kept);
  std::unique_ptr<WorldTopics> before;  // goes before the old world, which it looks at
  loading_->there([&] {
    if (simulation_ != running) throw SetupError("the scene", "was changed meanwhile", "call again");
    exchange(*running, changed, bodies, before);
  });
  return changed.links;
}

void SimulationNodelet::exchange(Simulation& running, const ChangedScene& changed, const ChangeBodies& bodies,
                                 std::unique_ptr<WorldTopics>& before) {
  WorldRoom room{std::make_shared<const WorldDef>(changed.scene.world), bodies.packed,
                 std::vector<std::uint64_t>(changed.scene.world.sensors.size(), 0)};
  const LoopCommand command{bodies};
  std::vector<double> start = bodies.next->start();
  const std::size_t numbers = bodies.next->stateCapacity();
  before = std::move(topics_);
  if (before) before->stop();
  bool done = false;
  std::string refusal = offer_.holder() + " did not answer: nothing was done";
  try {
    for (const bool steps : {false, true}) offer_.send(running.port, WorldPort::Rehearse{bodies.next.get(), steps});  // a tick each
    done = offer_.send(running.port, WorldPort::Exchange{&command, &room});
  } catch (const SetupError& error) {
    refusal = error.what();
  }
  const bool told_anew = done && !sameToldMotions(running.scene, changed.scene);
  if (done) {
    running.scene = changed.scene;
    running.initial_state = std::move(start);
    running.saved_state.clear();  // of other bodies
    running.port.resize(SceneMarkers::contactCapacity(running.world), numbers);
  }
  topics_ = std::make_unique<WorldTopics>(getNodeHandle(), parameters_, running.scene, running.port, offer_);
  if (told_anew) {
    motion_inputs_.reset();
    motion_inputs_ = std::make_unique<MotionInputs>(getNodeHandle(), running.scene, parameters_.world_frame, running.port, offer_);
  }
  if (!done) throw std::runtime_error(refusal);
}

}  // namespace haptic
