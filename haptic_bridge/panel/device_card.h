/// One device: its state in words and colour, what to do now, and its buttons.
#pragma once
#include <haptic_msgs/DeviceState.h>
#include <ros/node_handle.h>

#include <QGroupBox>
#include <QLabel>
#include <string>

#include "haptic_bridge/panel/service_calls.h"
#include "haptic_bridge/panel/told_states.h"

class QGridLayout;

namespace haptic {

class DeviceCard : public QGroupBox {
 public:
  DeviceCard(const std::string& name, ServiceCalls& calls, const Say& say, QWidget* parent);

  const std::string& name() const { return name_; }
  /// Motors off, at once. `tell` hears whether it came to pass.
  void stop();
  /// Without news for a while the state is no longer known.
  void age();

 private:
  void addButtons();
  void addButton(QGridLayout& grid, int row, int column, const char* text, const char* help, std::function<void()> press);
  void show(const haptic_msgs::DeviceState& state);
  void showState(const DeviceWord& word, const std::string& advice);

  std::string name_, stop_socket_;
  ServiceCalls& calls_;
  Say say_;
  QLabel *state_, *advice_;
  ros::SteadyTime heard_;
  ros::NodeHandle nh_;
  ros::Subscriber subscriber_;
};

}  // namespace haptic
