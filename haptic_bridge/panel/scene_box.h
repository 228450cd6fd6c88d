/// The scene: pause, step, reset, another scene, grabbing of a body.
#pragma once
#include <haptic_msgs/ScenePlan.h>
#include <ros/node_handle.h>

#include <QComboBox>
#include <QGroupBox>
#include <string>
#include <vector>

#include "haptic_bridge/panel/service_calls.h"

class QPushButton;

namespace haptic {

class SceneBox : public QGroupBox {
 public:
  SceneBox(ServiceCalls& calls, QWidget* parent);
  void setDevices(const std::vector<std::string>& names);

 private:
  QPushButton* button(const char* text, const char* help, std::function<void()> press);
  void show(const haptic_msgs::ScenePlan& plan);
  void grab(const std::string& link);

  ServiceCalls& calls_;
  QComboBox *scenes_, *hands_, *links_;
  ros::NodeHandle nh_;
  ros::Subscriber subscriber_;
};

}  // namespace haptic
