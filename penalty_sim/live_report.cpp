#include "penalty_sim/live_report.h"

#include <ros/console.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <chrono>

#include "haptic_core/base/error.h"
#include "haptic_core/world/world.h"
#include "penalty_sim/conversions.h"

namespace haptic {
namespace {

constexpr double kPeriod = 0.5;        // [s]: people read no faster, and the loop keeps its caches
constexpr double kShareOfCore = 0.05;  // of one core that the shadows may take: a large scene is reported less often
constexpr double kLook = 0.1;          // how often it is asked whether somebody listens [s]
constexpr double kTimed = 0.05;        // stages are timed over this long before each report [s]: 50 steps at 1 kHz
constexpr std::chrono::milliseconds kPatience{200};  // a runner that has not ticked for as long is not there

double seconds(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

}  // namespace

LiveReport::LiveReport(ros::NodeHandle& nh, const WorldDef& definition, const std::string& world_frame, WorldPort& port,
                       PortOffer& offer)
    : definition_(definition),
      world_frame_(world_frame),
      port_(port),
      offer_(offer),
      copy_(port.first_copy),
      publisher_(nh.advertise<haptic_msgs::LiveReport>("live_report", 2)) {
  for (int i = 0; i < port.world.linkCount(); ++i) links_.push_back(port.world.linkName(i));
  thread_ = std::thread([this] { run(); });
}

LiveReport::~LiveReport() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  woken_.notify_all();
  thread_.join();
}

void LiveReport::sleep(double seconds) {
  std::unique_lock<std::mutex> lock(mutex_);
  woken_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return stop_; });
}

void LiveReport::run() {
  const auto stopped = [this] {
    std::lock_guard<std::mutex> lock(mutex_);
    return stop_;
  };
  while (!stopped()) {
    if (!wanted()) {
      sleep(kLook);
      continue;
    }
    try {
      if (takeCopy()) report(copy_);
    } catch (const SetupError& error) {
      ROS_ERROR_STREAM("live_report ends: " << error.what());
      return;
    }
    sleep(std::max(kPeriod - kTimed, shadow_time_ / kShareOfCore));
  }
}

/// A copy of the world as the runner left it, with the times of the steps before it. False: nobody runs the world.
bool LiveReport::takeCopy() {
  if (!offer_.send(port_, WorldPort::TimeStages{true}, kPatience)) return false;
  sleep(kTimed);
  const bool taken = offer_.send(port_, WorldPort::Copy{&copy_}, kPatience);
  offer_.send(port_, WorldPort::TimeStages{false}, kPatience);
  const bool fresh = taken && copy_.stamp_ns > seen_ns_;
  if (fresh) seen_ns_ = copy_.stamp_ns;
  return fresh;
}

void LiveReport::report(const WorldCopy& copy) {
  if (!estimator_) estimator_ = std::make_unique<ErrorEstimator>(definition_);
  const std::int64_t begin = steadyNow();
  const ErrorEstimate estimate = estimator_->estimate(copy.state, copy.tuning, copy.bounds);
  shadow_time_ = seconds(steadyNow() - begin);
  const auto m = boost::make_shared<haptic_msgs::LiveReport>(
      toLiveReport(copy, estimate, links_, definition_.settings));
  m->header.frame_id = world_frame_;
  m->header.stamp = toStamp(copy.stamp_ns);
  m->estimates = ++estimates_;
  m->shadow_time = shadow_time_;
  for (const PointerDef& pointer : definition_.pointers) {
    m->pointers.push_back(definition_.articulations[pointer.articulation].links[pointer.link].name);
  }
  publisher_.publish(boost::shared_ptr<const haptic_msgs::LiveReport>(m));
}

}  // namespace haptic
