/// Every parameter of the simulation, in one place.
#pragma once
#include <ros/node_handle.h>

#include <string>

#include "haptic_core/loop/realtime.h"

namespace haptic {

struct SimulationParameters {
  std::string scene;              ///< ~scene: path of a URDF or scene list, or the name of one
  std::string name;               ///< of the world's port: the last part of the node's name
  double rate = 0;                ///< ~rate [Hz]: one step is 1/rate; 0: the scene's own step
  bool alone = true;              ///< ~alone: step in an own thread while no bridge holds the world
  std::string world_frame;        ///< ~world_frame: frame of everything published
  double frame_rate = 30;         ///< ~frame_rate [Hz]: of tf, markers, contacts and step_report
  double joint_rate = 100;        ///< ~joint_rate [Hz]: of joint_states
  double pose_age_limit = 0.1;    ///< ~pose_age_limit [s]: alone: a pointer stands still when its pose is older
  double wrench_rate = 500;       ///< ~wrench_rate [Hz]: alone: of `DEVICE/wrench_command`
  std::string missing_meshes;     ///< ~missing_meshes: what becomes of collisions whose mesh is not there: stop, box, skip
  std::string xacro;              ///< ~xacro: arguments of xacro files, "name=value name=value"
  double default_density = 0;     ///< ~default_density [kg/m³] of moving links without <inertial>; 0: refuse them
  RealtimeSettings realtime;      ///< ~priority, ~cpu, ~lock_memory: of the own thread
};

/// Throws SetupError naming parameter, unit and bounds.
SimulationParameters readSimulationParameters(const std::string& node, const ros::NodeHandle& priv);

}  // namespace haptic
