/// The simulation: loads a scene, offers its world to the bridge, or steps it over topics.
#pragma once
#include <haptic_msgs/Grab.h>
#include <haptic_msgs/LoadScene.h>
#include <haptic_msgs/StateFile.h>
#include <nodelet/nodelet.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>

#include <memory>
#include <string>
#include <vector>

#include "haptic_core/loop/ports.h"
#include "haptic_core/world/world.h"
#include "penalty_sim/actor_services.h"
#include "penalty_sim/joint_commands.h"
#include "penalty_sim/motion_inputs.h"
#include "penalty_sim/world_thread.h"
#include "penalty_sim/world_topics.h"

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

  SimulationParameters parameters_;
  std::unique_ptr<Simulation> simulation_;
  PortOffer offer_;
  std::unique_ptr<WorldTopics> topics_;
  std::unique_ptr<JointCommands> joint_commands_;
  std::unique_ptr<ActorServices> actor_services_;
  std::unique_ptr<MotionInputs> motion_inputs_;
  std::unique_ptr<WorldThread> thread_;
  std::vector<ros::ServiceServer> services_;
};

}  // namespace haptic
