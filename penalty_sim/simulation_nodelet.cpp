#include "penalty_sim/simulation_nodelet.h"

#include <pluginlib/class_list_macros.hpp>

#include <cstring>
#include <set>
#include <sstream>

#include "haptic_core/base/error.h"
#include "haptic_core/loop/session.h"
#include "penalty_sim/state_files.h"

namespace haptic {
namespace {

/// Before the name of a parameter that holds a URDF.
constexpr char kParameterScene[] = "param:";

std::vector<HandPlacement> placements(const SceneDef& scene) {
  std::vector<HandPlacement> hands;
  for (const HandDef& hand : scene.hands) {
    HandPlacement placement;
    placement.device = hand.device;
    placement.pointer = hand.pointer;
    placement.settings.workspace = hand.workspace;
    placement.settings.force_scale = hand.force_scale;
    placement.settings.delay = hand.delay;
    placement.path = hand.path;
    hands.push_back(placement);
  }
  return hands;
}

std::string deviceNames(const WorldPort& port) {
  std::set<std::string> names;
  std::string text;
  for (const HandPlacement& hand : port.hands) names.insert(hand.device);
  for (const std::string& name : names) text += " " + name;
  return text;
}

}  // namespace

SimulationNodelet::Simulation::Simulation(const SceneDef& scene_def, double default_density)
    : scene(scene_def),
      world(scene.world),
      port(world, scene.world.name, placements(scene), SceneMarkers::contactCapacity(world)),
      initial_state(world.save()) {
  port.source = {scene.file, scene.text, default_density, fingerprint(scene.world)};
  port.define(std::make_shared<const WorldDef>(scene.world));
}

void SimulationNodelet::onInit() {
  try {
    start();
  } catch (const SetupError& error) {
    NODELET_FATAL_STREAM(error.what());
    throw;  // the manager drops the nodelet, and who loaded it fails
  }
}

void SimulationNodelet::start() {
  parameters_ = readSimulationParameters(getName(), getPrivateNodeHandle());
  simulation_ = read(parameters_.scene);
  offer();
  advertise();
}

SceneOptions SimulationNodelet::options(const std::string& scene_name) const {
  SceneOptions options;
  options.default_density = parameters_.default_density;
  options.missing = missingMeshesNamed(parameters_.missing_meshes);
  std::istringstream words(parameters_.xacro);
  for (std::string word; words >> word;) {  // roslaunch takes no := within an argument
    const std::size_t equals = word.find('=');
    if (equals != std::string::npos && equals > 0 && word[equals - 1] != ':') word.insert(equals, ":");
    options.xacro.push_back(word);
  }
  options.progress = [this](const std::string& line) { NODELET_INFO_STREAM(line); };
  if (parameters_.rate > 0) options.step = 1 / parameters_.rate;
  if (scene_name.rfind(kParameterScene, 0) == 0) {
    std::string text;
    if (!getNodeHandle().getParam(scene_name.substr(std::strlen(kParameterScene)), text)) {
      throw SetupError(scene_name, "there is no such parameter, or it is no text", "load the robot's launch file first: rosparam list");
    }
    options.text = text;
  }
  return options;
}

std::unique_ptr<SimulationNodelet::Simulation> SimulationNodelet::read(const std::string& scene_name) const {
  SceneDef scene = loadScene(scene_name, options(scene_name));
  for (const auto* lines : {&scene.replaced, &scene.warnings}) {
    for (const std::string& line : *lines) NODELET_WARN_STREAM(line);
  }
  auto simulation = std::make_unique<Simulation>(scene, parameters_.default_density);
  NODELET_INFO_STREAM(sceneText(scene) << simulation->world.planText());
  return simulation;
}

void SimulationNodelet::offer() {
  offer_ = PortOffer(PortTable::process(), parameters_.name, simulation_->port, getName());
  topics_ = std::make_unique<WorldTopics>(getNodeHandle(), parameters_, simulation_->scene, simulation_->port, offer_);
  joint_commands_ = std::make_unique<JointCommands>(getPrivateNodeHandle(), simulation_->port, offer_);
  actor_services_ = std::make_unique<ActorServices>(getPrivateNodeHandle(), simulation_->scene, simulation_->port, offer_);
  motion_inputs_ = std::make_unique<MotionInputs>(getNodeHandle(), simulation_->scene, parameters_.world_frame, simulation_->port, offer_);
  descriptions_.reset();  // those of the scene before go first
  descriptions_ = std::make_unique<RobotDescriptions>(getNodeHandle(), simulation_->scene);
  if (parameters_.alone) thread_ = std::make_unique<WorldThread>(getNodeHandle(), parameters_, simulation_->port.hands);
}

/// Lets go of everything that refers to the world. False: its runner did not give it back in time.
bool SimulationNodelet::withdraw() {
  motion_inputs_.reset();
  actor_services_.reset();
  joint_commands_.reset();
  thread_.reset();
  topics_.reset();
  if (offer_.withdraw()) return true;
  NODELET_ERROR_STREAM(parameters_.name << " was not given back in time; its memory is kept");
  static_cast<void>(new std::shared_ptr<Simulation>(std::move(simulation_)));  // the runner may still use it
  return false;
}

void SimulationNodelet::advertise() {
  ros::NodeHandle& priv = getPrivateNodeHandle();
  services_ = {priv.advertiseService("reset", &SimulationNodelet::onReset, this),
               priv.advertiseService("pause", &SimulationNodelet::onPause, this),
               priv.advertiseService("step", &SimulationNodelet::onStep, this),
               priv.advertiseService("load_scene", &SimulationNodelet::onLoadScene, this),
               priv.advertiseService("save", &SimulationNodelet::onSave, this),
               priv.advertiseService("restore", &SimulationNodelet::onRestore, this),
               priv.advertiseService("grab", &SimulationNodelet::onGrab, this)};
  loading_ = std::make_unique<LoadingThread>(*priv.getCallbackQueue());
  ros::NodeHandle slow(priv);
  slow.setCallbackQueue(&loading_->queue());
  services_.push_back(slow.advertiseService("spawn", &SimulationNodelet::onSpawn, this));
  services_.push_back(slow.advertiseService("delete", &SimulationNodelet::onDelete, this));
}

SimulationNodelet::~SimulationNodelet() {
  if (loading_) loading_->stop();  // its services wait for this thread's queue, which no longer runs
  for (ros::ServiceServer& service : services_) service.shutdown();
  loading_.reset();
  withdraw();
}

template <class Response>
bool SimulationNodelet::send(Response& response, const WorldPort::Command& command) {
  try {
    response.success = offer_.send(simulation_->port, command);
    if (!response.success) response.message = offer_.holder() + " did not answer: nothing was done";
  } catch (const SetupError& error) {
    response.success = false;
    response.message = error.what();
  }
  return true;
}

template <class Response>
bool SimulationNodelet::tell(Response& response, const LoopCommand& command, std::uint64_t* hash) {
  return send(response, WorldPort::Change{{&command}, hash});
}

bool SimulationNodelet::onReset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return tell(response, {RestoreWorld{simulation_->initial_state}});
}

bool SimulationNodelet::onPause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
  return tell(response, {PauseWorld{request.data != 0}});
}

bool SimulationNodelet::onStep(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return tell(response, {StepWorld{}});
}

/// The new scene is read and judged before the old one goes, so that what is refused changes nothing.
bool SimulationNodelet::onLoadScene(haptic_msgs::LoadScene::Request& request, haptic_msgs::LoadScene::Response& response) {
  try {
    std::unique_ptr<Simulation> next = read(request.scene);
    const std::string has = deviceNames(simulation_->port), wants = deviceNames(next->port);
    if (wants != has) {
      throw SetupError(request.scene, "is for the devices" + wants + ", and those of this run are" + has,
                       "start it with ./run demo --scene " + request.scene);
    }
    const double step = simulation_->world.settings().step, next_step = next->world.settings().step;
    if (offer_.heldBy(ClaimRank::kBridge) && next_step != step) {
      throw SetupError(request.scene, "has a step of " + std::to_string(1e3 * next_step) + " ms, the loop one of " +
                                          std::to_string(1e3 * step) + " ms", "set ~rate, which holds for every scene");
    }
    withdraw();
    simulation_ = std::move(next);
    offer();
    response.success = true;
    response.message = simulation_->scene.world.name;
  } catch (const SetupError& error) {
    response.message = error.what();
  }
  return true;
}

bool SimulationNodelet::onSave(haptic_msgs::StateFile::Request& request, haptic_msgs::StateFile::Response& response) {
  WorldCopy copy = simulation_->port.first_copy;
  send(response, WorldPort::Copy{&copy});
  if (!response.success) return true;
  response.hash = copy.hash;
  try {
    if (request.file.empty()) {
      simulation_->saved_state = copy.state;
    } else {
      writeState(request.file, copy.state);
    }
    response.message = std::to_string(copy.state.size() * sizeof(double)) + " bytes";
  } catch (const SetupError& error) {
    response.success = false;
    response.message = error.what();
  }
  return true;
}

bool SimulationNodelet::onRestore(haptic_msgs::StateFile::Request& request,
                                  haptic_msgs::StateFile::Response& response) {
  try {
    if (request.file.empty() && simulation_->saved_state.empty()) {
      throw SetupError("restore", "nothing was saved", "call ~save first, or name a file");
    }
    return tell(response, {RestoreWorld{request.file.empty() ? simulation_->saved_state : readState(request.file)}}, &response.hash);
  } catch (const SetupError& error) {
    response.message = error.what();
  }
  return true;
}

bool SimulationNodelet::onGrab(haptic_msgs::Grab::Request& request, haptic_msgs::Grab::Response& response) {
  const auto& hands = simulation_->port.hands;
  std::string known;
  for (const HandPlacement& hand : hands) known += " " + hand.device;
  const auto hand = std::find_if(hands.begin(), hands.end(), [&](const HandPlacement& h) {
    return request.device.empty() || h.device == request.device;
  });
  if (hand == hands.end()) {
    response.message = "no hand '" + request.device + "'; there are:" + known;
    return true;
  }
  World& world = simulation_->world;
  const PointerDef& named = world.pointer(hand->pointer);
  const std::string link =
      request.link.empty() ? simulation_->scene.world.articulations[named.articulation].links[named.link].name
                           : request.link;
  const int index = world.linkIndex(link);
  if (index < 0) {
    response.message = "no link '" + link + "'; there are:";
    for (int i = 0; i < world.linkCount(); ++i) response.message += " " + world.linkName(i);
    return true;
  }
  return tell(response, {GrabLink{hand->pointer, index}});
}

}  // namespace haptic

PLUGINLIB_EXPORT_CLASS(haptic::SimulationNodelet, nodelet::Nodelet)
