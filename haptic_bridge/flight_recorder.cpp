#include "haptic_bridge/flight_recorder.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/WrenchStamped.h>
#include <haptic_msgs/conversions.h>
#include <rosbag/bag.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>

#include "haptic_core/world/runaway.h"

namespace haptic {
namespace {

constexpr std::int64_t kNanoseconds = 1000000000;

/// Creates a folder and those above it; false: it cannot be.
bool makeFolder(const std::string& path) {
  for (std::size_t i = 1; i <= path.size(); ++i) {
    if (i < path.size() && path[i] != '/') continue;
    if (mkdir(path.substr(0, i).c_str(), 0755) != 0 && errno != EEXIST) return false;
  }
  return true;
}

}  // namespace

void FlightRecorder::begin(const haptic_msgs::SessionInfo& info, const RealtimeThread::Start& start) {
  starts_.push_back({{info, 0}, true});
  links_ = start.links;
  devices_.clear();
  for (const SessionStart::HandStart& hand : start.session.hands) devices_.push_back(hand.device);
  states_.assign(devices_.size(), DeviceState::kUncalibrated);
  was_finite_ = true;
}

void FlightRecorder::add(const haptic_msgs::TickRecord::ConstPtr& run) {
  runs_.push_back(run);
  forgetOld();
}

void FlightRecorder::add(const FlightStart& memory) { starts_.push_back({memory, false}); }

/// What comes before the second start goes once that one is old enough to begin with.
void FlightRecorder::forgetOld() {
  const auto next = runs_.back()->first_tick + runs_.back()->ticks;
  const auto kept = static_cast<std::uint64_t>((kSeconds + kAfter) * parameters_.rate);
  while (starts_.size() > 1 && starts_[1].info.first_tick + kept <= next) starts_.pop_front();
  if (starts_.empty()) return;
  const std::uint64_t first = starts_.front().info.first_tick;
  while (!runs_.empty() && runs_.front()->first_tick < first) runs_.pop_front();
  while (!events_.empty() && events_.front().tick < first) events_.pop_front();
}

void FlightRecorder::add(const haptic_msgs::LoopEvent& event) {
  events_.push_back(event);
  if (event.kind == event.HAND_GONE && event.hand < static_cast<int>(devices_.size())) {
    devices_.erase(devices_.begin() + event.hand);
    states_.erase(states_.begin() + event.hand);
  }
}

/// What is wrong in this tick that was not in the one before; empty: nothing.
std::string FlightRecorder::faultOf(const TickSample& sample) {
  std::string fault;
  if (was_finite_ && !sample.step.finite) {
    const int c = sample.step.culprit;
    fault = std::string("the world stopped: ") + whyStopped(sample.step) +
            (c >= 0 && c < static_cast<int>(links_.size()) ? " at link " + links_[c] : std::string());
  }
  was_finite_ = sample.step.finite;
  for (int i = 0; i < sample.hands && i < static_cast<int>(states_.size()); ++i) {
    const HandSample& hand = sample.hand[i];
    const bool worse = hand.state != states_[i] && (hand.state == DeviceState::kFault || hand.state == DeviceState::kReduced);
    states_[i] = hand.state;
    if (worse) fault = devices_[i] + " went to " + toString(hand.state) + ((hand.flags & kLinkLost) ? ": link lost" : "");
    if (hand.over_clamp) fault = devices_[i] + ": a tension or the wrench left the device's bounds";
  }
  return fault;
}

std::string FlightRecorder::add(const TickSample& sample) {
  samples_.push_back(sample);
  while (samples_.size() > static_cast<std::size_t>((kSeconds + kAfter) * parameters_.rate)) samples_.pop_front();
  const std::string fault = faultOf(sample);
  const bool quiet = written_ns_ != 0 && sample.start_ns - written_ns_ < kQuiet * kNanoseconds;
  if (!fault.empty() && fault_.empty() && !quiet) {
    fault_ = fault;
    fault_tick_ = sample.tick;
  }
  if (fault_.empty() || sample.tick < fault_tick_ + static_cast<std::uint64_t>(kAfter * parameters_.rate)) return {};
  return writeNow(fault_);
}

std::string FlightRecorder::writeNow(const std::string& why) {
  if (parameters_.flight_folder.empty() || samples_.empty()) {
    fault_.clear();
    return {};
  }
  fault_ = why;
  const std::string result = write();
  written_ns_ = samples_.back().start_ns;
  fault_.clear();
  return result;
}

std::string FlightRecorder::write() const {
  char stamp[32];
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", &local);
  std::string path = parameters_.flight_folder + "/flight-" + stamp + ".bag";
  for (int i = 2; access(path.c_str(), F_OK) == 0; ++i) {  // two loops may fail in one second
    path = parameters_.flight_folder + "/flight-" + stamp + "-" + std::to_string(i) + ".bag";
  }
  if (!makeFolder(parameters_.flight_folder)) return fault_ + "; " + parameters_.flight_folder + " cannot be made: not kept";
  try {
    rosbag::Bag bag(path, rosbag::bagmode::Write);
    bag.setCompression(rosbag::compression::LZ4);
    const ros::Time first = toStamp(samples_.front().start_ns);
    for (std::size_t i = 0; i < starts_.size(); ++i) {
      if (i == 0 || starts_[i].begins_session) bag.write("recorded/session", first, starts_[i].info);
    }
    int contained = starts_.empty() ? 0 : starts_.front().events;
    for (const auto& event : events_) {
      if (event.tick == starts_.front().info.first_tick && contained-- > 0) continue;
      bag.write("recorded/events", std::max(first, event.header.stamp), event);
    }
    for (const auto& run : runs_) bag.write("recorded/ticks", std::max(first, run->header.stamp), *run);
    for (const TickSample& sample : samples_) {
      const ros::Time at = toStamp(sample.start_ns);
      for (int i = 0; i < sample.hands && i < static_cast<int>(devices_.size()); ++i) {
        geometry_msgs::PoseStamped pose;
        geometry_msgs::WrenchStamped wrench;
        pose.header.stamp = wrench.header.stamp = at;
        pose.header.frame_id = wrench.header.frame_id = devices_[i] + "_base";
        pose.pose = toPose(sample.hand[i].X_BG);
        bag.write("flight/" + devices_[i] + "/pose", at, pose);
        wrench.wrench = toWrench(sample.hand[i].F_asked_B);
        bag.write("flight/" + devices_[i] + "/wrench_asked", at, wrench);
        wrench.wrench = toWrench(sample.hand[i].F_achieved_B);
        bag.write("flight/" + devices_[i] + "/wrench", at, wrench);
      }
    }
    diagnostic_msgs::DiagnosticArray what;
    what.header.stamp = toStamp(samples_.back().start_ns);
    what.status.resize(1);
    what.status[0].level = diagnostic_msgs::DiagnosticStatus::ERROR;
    what.status[0].name = "flight recorder";
    what.status[0].message = fault_ + ", at tick " + std::to_string(fault_tick_);
    bag.write("diagnostics", what.header.stamp, what);
    bag.close();
    rosbag::Bag(path, rosbag::bagmode::Read);  // closing does not say that the disk is full: the index at the end does
  } catch (const rosbag::BagException& error) {
    return fault_ + "; the last seconds could not be written to " + path + ": " + error.what();
  }
  return fault_ + "; the last seconds are in " + path;
}

}  // namespace haptic
