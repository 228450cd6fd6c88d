/// Force asked and given, tick time against its period, energy balance, error of the step: the last ten seconds.
#pragma once
#include <haptic_msgs/LiveReport.h>
#include <haptic_msgs/TickStatistics.h>
#include <ros/node_handle.h>

#include <QGroupBox>

#include "haptic_bridge/panel/history_strip.h"

namespace haptic {

class HistoryStrips : public QGroupBox {
 public:
  explicit HistoryStrips(QWidget* parent);

 private:
  HistoryStrip* add(const char* title, const char* unit, double least_span);
  void show(const haptic_msgs::TickStatistics& m);
  void show(const haptic_msgs::LiveReport& m);

  HistoryStrip *force_, *tick_, *energy_, *error_;
  double first_balance_ = 0;
  std::uint64_t last_step_ = 0;
  bool balanced_ = false;
  ros::NodeHandle nh_;
  ros::Subscriber statistics_, live_;
};

}  // namespace haptic
