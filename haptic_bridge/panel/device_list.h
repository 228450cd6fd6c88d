/// The cards of all devices there are, found by the type of their topics.
#pragma once
#include <QTimer>
#include <QVBoxLayout>
#include <QWidget>
#include <set>
#include <string>
#include <vector>

#include "haptic_bridge/panel/device_card.h"

namespace haptic {

class DeviceList : public QWidget {
 public:
  DeviceList(ServiceCalls& calls, const Say& say, QWidget* parent);
  void stopAll();
  std::vector<std::string> names() const;
  /// Called in the window's thread whenever a device has come.
  void tellBy(std::function<void()> changed) { changed_ = std::move(changed); }

 private:
  void look();
  void show(const std::set<std::string>& names);

  ServiceCalls& calls_;
  Say say_;
  QVBoxLayout* column_;
  QTimer timer_;
  std::vector<DeviceCard*> cards_;
  std::function<void()> changed_ = [] {};
  bool looking_ = false;
};

}  // namespace haptic
