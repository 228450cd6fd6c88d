/// The simulation: loads a scene, offers its world to the bridge, or steps it over topics.
#pragma once
#include <haptic_msgs/Delete.h>
#include <haptic_msgs/Grab.h>
#include <haptic_msgs/LoadScene.h>
#include <haptic_msgs/Spawn.h>
#include <haptic_msgs/StateFile.h>
#include <nodelet/nodelet.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "haptic_core/loop/ports.h"
#include "haptic_core/world/world.h"
#include "penalty_sim/actor_services.h"
#include "penalty_sim/joint_commands.h"
#include "penalty_sim/loading_thread.h"
#include "penalty_sim/motion_inputs.h"
#include "penalty_sim/robot_descriptions.h"
#include "penalty_sim/world_thread.h"
#include "penalty_sim/world_topics.h"
#include "scene/scene_bodies.h"

namespace haptic {

class SimulationNodelet : public nodelet::Nodelet {
 public:
  ~SimulationNodelet() override;

 private:
  /// What a lease gives away: destroyed after the port has come back, or not at all.
  struct Simulation {
    Simulation(const SceneDef& scene_def, double default_density);
    SceneDef scene;
    World world;
    WorldPort port;
    std::vector<double> initial_state, saved_state;
  };

  void onInit() override;
  void start();
  SceneOptions options(const std::string& scene_name) const;              ///< throws SetupError
  std::unique_ptr<Simulation> read(const std::string& scene_name) const;  ///< throws SetupError
  void offer();
  bool withdraw();
  void advertise();
  /// Sends the world's runner a command and turns what goes wrong into a service's answer.
  template <class Response>
  bool send(Response& response, const WorldPort::Command& command);
  /// The same for one that changes the world; `hash`: of the world after it.
  template <class Response>
  bool tell(Response& response, const LoopCommand& command, std::uint64_t* hash = nullptr);

  bool onReset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  bool onPause(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response);
  bool onStep(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  bool onLoadScene(haptic_msgs::LoadScene::Request& request, haptic_msgs::LoadScene::Response& response);
  bool onSave(haptic_msgs::StateFile::Request& request, haptic_msgs::StateFile::Response& response);
  bool onRestore(haptic_msgs::StateFile::Request& request, haptic_msgs::StateFile::Response& response);
  bool onGrab(haptic_msgs::Grab::Request& request, haptic_msgs::Grab::Response& response);

  // In the loading thread (simulation_models.cpp):
  bool onSpawn(haptic_msgs::Spawn::Request& request, haptic_msgs::Spawn::Response& response);
  bool onDelete(haptic_msgs::Delete::Request& request, haptic_msgs::Delete::Response& response);
  ChangedScene spawned(const SceneDef& scene, const haptic_msgs::Spawn::Request& request) const;  ///< throws SetupError
  /// Changes the running scene as `make` says of it. Throws SetupError, and nothing has changed.
  std::vector<std::string> change(const std::function<ChangedScene(const SceneDef&)>& make);
  /// In the nodelet's queue: the exchange, and topics of the new bodies; `before`: those of the old ones. Throws where it was refused.
  void exchange(Simulation& running, const ChangedScene& changed, const ChangeBodies& bodies, std::unique_ptr<WorldTopics>& before);

  SimulationParameters parameters_;
  std::shared_ptr<Simulation> simulation_;  ///< the loading thread has it while it compiles for it
  PortOffer offer_;
  std::unique_ptr<WorldTopics> topics_;
  std::unique_ptr<JointCommands> joint_commands_;
  std::unique_ptr<ActorServices> actor_services_;
  std::unique_ptr<MotionInputs> motion_inputs_;
  std::unique_ptr<WorldThread> thread_;
  std::unique_ptr<RobotDescriptions> descriptions_;
  std::unique_ptr<LoadingThread> loading_;
  std::vector<ros::ServiceServer> services_;
};

}  // namespace haptic
