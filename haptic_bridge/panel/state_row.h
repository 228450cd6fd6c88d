/// One row above the picture: what goes on, or a banner that says what to do.
#pragma once
#include <haptic_msgs/ScenePlan.h>
#include <ros/node_handle.h>

#include <QLabel>
#include <QTimer>
#include <QToolBar>
#include <map>
#include <string>
#include <vector>

#include "haptic_bridge/panel/told_states.h"

namespace haptic {

/// A state stays for kStays after it was last said, so that it can be read. The weightiest come first; calm ones show alone.
class StateRow : public QToolBar {
 public:
  explicit StateRow(QWidget* parent = nullptr);

  void say(const std::string& source, const std::vector<Told>& told);
  void hear(const haptic_msgs::TickStatistics& loop);
  void hear(const haptic_msgs::StepReport& step);
  /// `publisher`: name of the node, which is `replay` where a recording is shown.
  void hear(const haptic_msgs::ScenePlan& plan, const std::string& publisher);

  void subscribe();  ///< to the loop's topics; the cards of devices say what these tell
  void refresh();    ///< as of now

  static constexpr double kStays = 2;  ///< [s]

 private:
  /// When each text of a source was said last [s].
  using Said = std::map<std::string, std::pair<Weight, double>>;

  QLabel* row_;
  QTimer timer_;
  std::map<std::string, Said> banners_;               ///< by source: what is more than calm
  std::map<std::string, std::vector<Told>> present_;  ///< by source: as it was told last
  std::vector<std::string> pointers_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace haptic
