/// Stiffness, friction, force limit and coupling, by dynamic_reconfigure of the bridge.
#pragma once
#include <dynamic_reconfigure/Config.h>
#include <haptic_msgs/HandLimits.h>
#include <ros/node_handle.h>

#include <QGroupBox>
#include <string>

#include "haptic_bridge/panel/service_calls.h"
#include "haptic_bridge/panel/tuning_slider.h"

namespace haptic {

class TuningBox : public QGroupBox {
 public:
  TuningBox(ServiceCalls& calls, QWidget* parent);

 private:
  TuningSlider* add(const char* parameter, const char* title, const SliderScale& scale, std::function<std::string(double)> text);
  void set(const std::string& what, const dynamic_reconfigure::Config& config);
  void show(const dynamic_reconfigure::Config& config);
  void show(const haptic_msgs::HandLimits& limits);

  ServiceCalls& calls_;
  bool scene_coupling_ = true;
  double max_force_ = 0;  ///< of the weakest device [N]; 0: not known yet
  TuningSlider *stiffness_, *friction_, *limit_, *coupling_;
  ros::NodeHandle nh_;
  ros::Subscriber parameters_, limits_;
};

}  // namespace haptic
