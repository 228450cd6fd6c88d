/// `wrench_command`: a wrench on the hand from a topic, in the device's base, with its age. `grasp_command`: the force
/// along the opening of a 7-DOF grip [N].
#pragma once
#include <geometry_msgs/WrenchStamped.h>
#include <haptic_msgs/heard_frames.h>
#include <ros/node_handle.h>
#include <std_msgs/Float64.h>

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "haptic_core/base/latest_value.h"
#include "haptic_core/base/spatial.h"
#include "spidar_driver/authority/judged_subscription.h"

namespace haptic {

/// A command's age counts from its receipt on the steady clock: stamps of other machines, bags and simulated
/// clocks say nothing about whether its sender still lives.
class WrenchInput {
 public:
  struct Command {
    Wrench F_G_B;                ///< on the hand, about the grip's origin, axes of the base
    std::int64_t received_ns = 0;
    bool given = false;
  };
  struct Grasp {
    double force = 0;            ///< closes the grip when positive [N]
    std::int64_t received_ns = 0;
  };
  /// Says why a command must not act now; empty: it may.
  using Gate = std::function<std::string()>;

  /// `takes_grasp`: the device has a 7th degree of freedom.
  WrenchInput(ros::NodeHandle& nh, const std::string& base_frame, bool takes_grasp, Gate gate);

  const Command& latest() {      ///< (in realtime) for the device's thread alone
    slot_.read(command_);
    return command_;
  }
  const Grasp& latestGrasp() {   ///< (in realtime) likewise
    grasp_slot_.read(grasp_);
    return grasp_;
  }
  std::uint32_t refused() const { return refused_; }

 private:
  void receive(const geometry_msgs::WrenchStamped::ConstPtr& message);
  void receiveGrasp(const std_msgs::Float64::ConstPtr& message);
  bool rotationToBase(const std::string& frame, Matrix3& R_BF, std::string& why) const;
  void refuse(const std::string& topic, const std::string& why);

  std::string base_frame_, wrench_topic_, grasp_topic_;
  Gate gate_;
  HeardFrames frames_;
  LatestValue<Command> slot_;
  Command command_;
  LatestValue<Grasp> grasp_slot_;
  Grasp grasp_;
  std::atomic<std::uint32_t> refused_{0};
  ros::Publisher taken_;  ///< recorded/wrench_command: what was accepted; a bag of it reaches no motor when played
  // Last: no message may arrive before the rest exists, or after it is gone.
  std::unique_ptr<JudgedSubscription> wrench_command_, grasp_command_;
};

}  // namespace haptic
