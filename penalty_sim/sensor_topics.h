/// The sensors of a world as topics.
#pragma once
#include <ros/node_handle.h>

#include <vector>

#include "haptic_core/loop/ports.h"

namespace haptic {

/// `sensors/NAME` of each <haptic:sensor>: WrenchStamped of joints and contacts, Imu of inertial units. Every sample, stamped with its
/// tick, while somebody subscribes to any of them; otherwise the loop hands out nothing.
class SensorTopics {
 public:
  SensorTopics(ros::NodeHandle& nh, WorldPort& port, PortOffer& offer);

  bool wanted() const;  ///< somebody subscribes
  void publish();       ///< what has come since the last call

 private:
  void publish(const SensorSample& sample) const;

  WorldPort& port_;
  PortOffer& offer_;
  std::vector<SensorDef> sensors_;
  std::vector<ros::Publisher> publishers_;  ///< by sensor
  bool streams_ = false;
};

}  // namespace haptic
