/// The world as topics: takes snapshots from the port in a thread of its own.
#pragma once
#include <haptic_msgs/ScenePlan.h>
#include <ros/node_handle.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "haptic_core/loop/ports.h"
#include "haptic_core/world/contact_detail.h"
#include "penalty_sim/live_report.h"
#include "penalty_sim/scene_markers.h"
#include "penalty_sim/sensor_topics.h"
#include "penalty_sim/simulation_parameters.h"

namespace haptic {

/// tf of all links, contacts, step_report, markers at ~frame_rate; joint_states at ~joint_rate; every sample of sensors
/// (sensor_topics.h); scene_plan latched, soon
/// after the start with the certificate of stability; links that never move, and alone the devices' bases, as static tf. A frame
/// is published once: tf refuses a stamp twice, so a world that stands still is silent. Of one set of bodies: where some come or go, it
/// is stopped before and another one made after, and the first goes last, so that no topic is without a publisher meanwhile.
class WorldTopics {
 public:
  WorldTopics(ros::NodeHandle& nh, const SimulationParameters& parameters, const SceneDef& scene, WorldPort& port,
              PortOffer& offer);
  ~WorldTopics();
  void stop();  ///< nothing that looks at the world's definition goes on

 private:
  void run();
  void publish(const WorldSnapshot& snapshot);
  void publishJoints(const WorldSnapshot& snapshot);
  void publishFrames(const WorldSnapshot& snapshot, const ros::Time& stamp);
  void publishStatic(const SceneDef& scene);
  void publishPlan(const SceneDef& scene);
  void publishCertificate();

  SimulationParameters parameters_;
  WorldPort& port_;
  PortOffer& offer_;
  std::vector<std::string> links_, joints_;
  std::vector<bool> fixed_;  ///< per link: its frame is static
  double step_;
  WorldDef definition_;                 ///< for the certificate
  haptic_msgs::ScenePlan plan_message_;
  ros::Publisher contacts_, step_report_, joint_states_, model_;
  PatchOutline outline_;
  SensorTopics sensors_;
  SceneMarkers markers_;
  LiveReport live_;
  tf2_ros::TransformBroadcaster broadcaster_;
  tf2_ros::StaticTransformBroadcaster static_broadcaster_;
  std::atomic<bool> stop_{false};
  std::thread thread_, certifier_;
};

}  // namespace haptic
