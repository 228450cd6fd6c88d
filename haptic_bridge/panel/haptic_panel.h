/// The panel in rviz: what people touch of a running loop. Everything goes through public services and topics, so that it
/// works from another machine and for whatever started the loop.
#pragma once
#include <ros/node_handle.h>
#include <rosgraph_msgs/Log.h>
#include <rviz/panel.h>

#include <QListWidget>
#include <QPointer>
#include <string>

#include "haptic_bridge/panel/camera.h"
#include "haptic_bridge/panel/device_list.h"
#include "haptic_bridge/panel/scene_box.h"
#include "haptic_bridge/panel/service_calls.h"
#include "haptic_bridge/panel/state_row.h"

namespace haptic {

/// STOP switches the force of every device off; so does the key Escape, wherever in the window the focus is.
/// What is refused is told, with the reason, in the list at the bottom.
class HapticPanel : public rviz::Panel {
 public:
  explicit HapticPanel(QWidget* parent = nullptr);
  ~HapticPanel() override;

  void onInitialize() override;

  bool eventFilter(QObject* receiver, QEvent* event) override;

 private:
  void tell(const std::string& line, bool well);
  void onLog(const rosgraph_msgs::Log& log);

  ServiceCalls* calls_;
  Camera* camera_;
  QPointer<StateRow> row_;  ///< the window it stands in may delete it first
  DeviceList* devices_;
  SceneBox* scene_;
  QListWidget* lines_;
  unsigned long stopped_at_ = 0;  ///< time stamp of the last Escape [ms]
  ros::NodeHandle nh_;
  ros::Subscriber log_, plan_;
};

}  // namespace haptic
