/// The parameters of cfg/Loop.cfg as dynamic_reconfigure's topics and service.
///
/// dynamic_reconfigure's own server bounds a value in silence before it tells of it: 1e308 became the strongest. This one refuses,
/// with a line, what is out of bounds or unknown; all else is as there: `~set_parameters`, `~parameter_descriptions`,
/// `~parameter_updates`.
#pragma once
#include <dynamic_reconfigure/Reconfigure.h>
#include <haptic_bridge/LoopConfig.h>
#include <ros/node_handle.h>

#include <functional>
#include <mutex>
#include <string>

namespace haptic {

class LoopParameters {
 public:
  /// Makes a change happen; throws SetupError, or returns false, when it did not. Runs in the nodelet's callback threads.
  using Apply = std::function<bool(const haptic_bridge::LoopConfig&)>;

  LoopParameters(ros::NodeHandle& priv, const std::string& name, const haptic_bridge::LoopConfig& start, Apply apply);
  ~LoopParameters();
  void reapply();  ///< another start of the loop: what the user had set holds on

 private:
  bool onSet(dynamic_reconfigure::Reconfigure::Request& request, dynamic_reconfigure::Reconfigure::Response& response);
  void change(const haptic_bridge::LoopConfig& wanted);
  void publish();

  ros::NodeHandle priv_;
  std::string name_;
  Apply apply_;
  std::mutex mutex_;  ///< of `applied_` and its changes
  haptic_bridge::LoopConfig applied_;
  ros::Publisher descriptions_, updates_;
  ros::ServiceServer set_;
};

}  // namespace haptic
