#include "haptic_bridge/panel/device_list.h"

#include <ros/master.h>

#include <algorithm>

namespace haptic {
namespace {

constexpr int kLookEvery = 1000;  // the master is asked this often [ms]

/// Devices whose `state` somebody announces.
std::set<std::string> devicesAtMaster() {
  ros::master::V_TopicInfo topics;
  std::set<std::string> names;
  if (!ros::master::getTopics(topics)) return names;
  const std::string ending = "/state";
  for (const ros::master::TopicInfo& topic : topics) {
    if (topic.datatype != "haptic_msgs/DeviceState" || topic.name.size() <= ending.size() + 1) continue;
    if (topic.name.compare(topic.name.size() - ending.size(), ending.size(), ending) != 0) continue;
    names.insert(topic.name.substr(1, topic.name.size() - ending.size() - 1));
  }
  return names;
}

}  // namespace

DeviceList::DeviceList(ServiceCalls& calls, const Say& say, QWidget* parent)
    : QWidget(parent), calls_(calls), say_(say), column_(new QVBoxLayout(this)) {
  column_->setContentsMargins(0, 0, 0, 0);
  connect(&timer_, &QTimer::timeout, this, [this] { look(); });
  timer_.start(kLookEvery);
  look();
}

void DeviceList::look() {
  for (DeviceCard* card : cards_) card->age();
  if (looking_) return;
  looking_ = true;
  calls_.start(ServiceCalls::Lane::kOrdinary, [this] {
    const std::set<std::string> names = devicesAtMaster();
    QMetaObject::invokeMethod(&calls_, [this, names] {
      looking_ = false;
      show(names);
    });
  });
}

/// A device that has gone keeps its card, which says so.
void DeviceList::show(const std::set<std::string>& names) {
  const std::vector<std::string> known = this->names();
  const std::size_t before = cards_.size();
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    cards_.push_back(new DeviceCard(name, calls_, say_, this));
    column_->addWidget(cards_.back());
  }
  if (cards_.size() != before) changed_();
}

void DeviceList::stopAll() {
  if (cards_.empty()) calls_.tell("STOP: no device is known yet; cut the power of the motors if one pulls", false);
  for (DeviceCard* card : cards_) card->stop();
}

std::vector<std::string> DeviceList::names() const {
  std::vector<std::string> names;
  for (const DeviceCard* card : cards_) names.push_back(card->name());
  return names;
}

}  // namespace haptic
